#include "experiments/report/charts/chart_svg.h"

#include "experiments/report/report_text.h"
#include "framework/core/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace etendue {
namespace {

int decade_of(double value) { return static_cast<int>(std::floor(std::log10(value))); }

std::string superscript(int exponent) {
  constexpr const char* digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string out = exponent < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(exponent))) out += digits[c - '0'];
  return out;
}

std::vector<Tick> linear_ticks(Interval range, int most) {
  const double step = round_up_nicely((range.high - range.low) / std::max(1, most));
  const int exponent = static_cast<int>(std::floor(std::log10(step) + 1e-9));
  const double largest = std::max(std::abs(range.low), std::abs(range.high));
  // Beyond these sizes the power of ten is written once per label, with as many digits as the step needs.
  const bool plain = largest < 1e5 && exponent >= -4;
  const int power = largest > 0 ? decade_of(largest) : 0;
  std::vector<Tick> result;
  const auto first = static_cast<long long>(std::ceil(range.low / step - 1e-9));
  const auto last = static_cast<long long>(std::floor(range.high / step + 1e-9));
  for (long long i = first; i <= last; ++i) {
    const double value = static_cast<double>(i) * step;
    std::string text = plain    ? fmt::format("{:.{}f}", value, std::max(0, -exponent))
                       : i == 0 ? std::string("0")
                                : fmt::format("{:.{}f}·10{}", value / std::pow(10.0, power), std::max(0, power - exponent),
                                              superscript(power));
    if (text.starts_with('-')) text.replace(0, 1, "−");
    result.push_back({value, text});
  }
  return result;
}

std::vector<Tick> log_ticks(Interval range, int most) {
  struct Candidate {
    int decade, factor;
    double value;  // factor * 10^decade
    bool labelled = false;
  };
  std::vector<Candidate> candidates;
  const int first = decade_of(range.low), last = decade_of(range.high);
  for (int decade = first; decade <= last; ++decade)
    for (int factor = 1; factor < 10; ++factor) {
      const double value = factor * std::pow(10.0, decade);
      if (value >= range.low * (1 - 1e-9) && value <= range.high * (1 + 1e-9)) candidates.push_back({decade, factor, value});
    }
  const auto label_where = [&](const auto& chosen) {
    for (Candidate& tick : candidates) tick.labelled = chosen(tick);
    return std::ranges::count_if(candidates, [](const Candidate& c) { return c.labelled; });
  };
  const auto decades = label_where([](const Candidate& c) { return c.factor == 1; });
  if (3 * decades > most || decades > 3) {
    const auto step = (decades + most - 1) / most;  // multiples of it, so that 10^0 keeps its label
    label_where([&](const Candidate& c) { return c.factor == 1 && c.decade % step == 0; });
  } else if (label_where([](const Candidate& c) { return c.factor == 1 || c.factor == 2 || c.factor == 5; }) < 2 &&
             label_where([](const Candidate&) { return true; }) < 2) {
    return linear_ticks(range, std::min(most, 4));
  }

  // A whole axis has one style: plain figures from 0.001 to 10000, powers of ten beyond.
  const bool plain =
      std::ranges::all_of(candidates, [](const Candidate& c) { return !c.labelled || (c.decade >= -3 && c.decade <= 4); });
  const auto label = [&](const Candidate& c) {
    if (!c.labelled) return std::string();
    if (plain) return fmt::format("{:.{}f}", c.value, std::max(0, -c.decade));
    return (c.factor == 1 ? "10" : fmt::format("{}·10", c.factor)) + superscript(c.decade);
  };
  const bool minor = last - first <= 9;
  std::vector<Tick> result;
  for (const Candidate& c : candidates)
    if (c.labelled || c.factor == 1 || minor) result.push_back({c.value, label(c)});
  return result;
}

}  // namespace

std::vector<Tick> ticks(Interval range, Scale scale, int most) {
  CHECK_LT(range.low, range.high);
  if (scale == Scale::linear) return linear_ticks(range, most);
  CHECK(range.low > 0);
  return log_ticks(range, most);
}

double position(double value, Interval range, Scale scale) {
  if (scale == Scale::linear) return (value - range.low) / (range.high - range.low);
  if (value <= 0) return -std::numeric_limits<double>::infinity();
  return std::log(value / range.low) / std::log(range.high / range.low);
}

Interval padded_range(const std::vector<double>& values, Scale scale) {
  // No measurement is as large, but a damaged log may hold such numbers, whose ratios and differences would overflow.
  constexpr double most = 1e150;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double value : values) {
    if (!(std::abs(value) <= most) || (scale == Scale::log && value < 1 / most)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  if (low > high) return scale == Scale::log ? Interval{0.1, 1} : Interval{0, 1};
  if (scale == Scale::log) {
    const double middle = std::sqrt(low) * std::sqrt(high);
    const double half = std::max(0.5 * std::log(high / low) * 1.08, std::log(1.5));
    return {middle * std::exp(-half), middle * std::exp(half)};
  }
  const double span = std::max(high - low, 1e-6 * std::max(std::abs(high), std::abs(low)));
  if (span == 0) return {low - 0.5, high + 0.5};
  // Zero is worth showing where it is near.
  if (low > 0 && low < 0.5 * span) return {0, high + 0.05 * span};
  return {low - 0.05 * span, high + 0.05 * span};
}

}  // namespace etendue
