#include "experiments/kinds/stress/stress_sweep.h"

#include "framework/core/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>

namespace etendue {

double excess(double value, const Expected& holds) {
  const bool straddles = std::isfinite(holds.low) && holds.low < 0 && std::isfinite(holds.high) && holds.high > 0;
  const auto beyond = [straddles](double larger, double smaller) {
    if (!std::isfinite(larger) || !std::isfinite(smaller)) return larger > smaller ? 1e300 : -1e300;
    if (straddles) return larger - smaller;
    if (larger > 0 && smaller > 0) return std::log(larger / smaller);
    return larger == 0 && smaller > 0 ? -1e300 : larger - smaller;
  };
  const double above = std::isfinite(holds.high) ? beyond(value, holds.high) : -1e300;
  const double below = std::isfinite(holds.low) ? beyond(holds.low, value) : -1e300;
  return std::max(above, below);
}

namespace {

constexpr int coarse_depth = 2;  // quarters

double mean_excess(const SweepPoint& point, const Expected& holds, std::span<const std::size_t> seeds) {
  double sum = 0;
  for (const std::size_t seed : seeds) sum += point.values[seed];
  return excess(sum / static_cast<double>(seeds.size()), holds);
}

// The t where the mean over these seeds first crosses the bound; 0 where it fails from the start, 1 where it never does.
double crossing(std::span<const SweepPoint> points, const Expected& holds, std::span<const std::size_t> seeds) {
  double last = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double now = mean_excess(points[i], holds, seeds);
    if (now > 0) {
      if (i == 0) return 0;
      const double a = std::min(-last, 1e6), b = std::min(now, 1e6);
      return points[i - 1].t + (points[i].t - points[i - 1].t) * (a + b > 0 ? a / (a + b) : 0.5);
    }
    last = now;
  }
  return 1;
}

// The standard error of a point's mean, in the units of excess().
double spread_of(const SweepPoint& point, const Expected& holds) {
  const double m = mean(point.values), error = sample_sd(point.values) / std::sqrt(static_cast<double>(point.values.size()));
  return std::abs(excess(m + error, holds) - excess(m - error, holds)) / 2;
}

bool is_quarter(const SweepPoint& point) { return std::abs(point.t * 4 - std::round(point.t * 4)) < 1e-9; }

// The distance by which t may lie off, at 95 % of Student's distribution: the noise at the threshold over the slope of its
// quarter.
double crossing_error(std::span<const SweepPoint> points, std::size_t failed, const Expected& holds,
                      std::span<const std::size_t> seeds) {
  std::size_t left = failed - 1, right = failed;
  while (left > 0 && !is_quarter(points[left])) --left;
  while (right + 1 < points.size() && !is_quarter(points[right])) ++right;
  const double rise = mean_excess(points[right], holds, seeds) - mean_excess(points[left], holds, seeds);
  const double slope = rise / (points[right].t - points[left].t);
  const double noise = std::max(spread_of(points[failed - 1], holds), spread_of(points[failed], holds));
  return slope > 0 ? student_t_quantile(0.975, static_cast<double>(seeds.size() - 1)) * noise / slope : 1;
}

std::vector<std::size_t> all_seeds(std::span<const SweepPoint> points) {
  std::vector<std::size_t> seeds(points.empty() ? 0 : points.front().values.size());
  std::iota(seeds.begin(), seeds.end(), std::size_t{0});
  return seeds;
}

}  // namespace

double SweepRange::at(double t) const {
  const double x = from * std::pow(to / from, t);
  return whole ? std::round(x) : std::strtod(fmt::format("{:.6g}", x).c_str(), nullptr);
}

double SweepRange::t_of(double x) const { return std::log(x / from) / std::log(to / from); }

int SweepRange::depth(double factor) const {
  const double steps = std::abs(std::log(to / from)) / std::log(factor);
  return std::clamp(static_cast<int>(std::ceil(std::log2(std::max(1.0, steps)) - 1e-9)), coarse_depth, 16);
}

bool is_failed(const SweepPoint& point, const Expected& holds) { return excess(mean(point.values), holds) > 0; }

std::vector<SweepPoint> sweep(const SweepRange& range, double factor, const Expected& holds,
                              const std::function<std::vector<double>(double x)>& measure) {
  const int steps = 1 << range.depth(factor);
  std::map<int, SweepPoint> points;
  const auto fails = [&](int i) {
    const double t = static_cast<double>(i) / steps, x = range.at(t);
    if (const auto known = points.find(i); known != points.end()) return is_failed(known->second, holds);
    return is_failed(points[i] = {t, x, measure(x)}, holds);
  };
  const int quarter = steps >> coarse_depth;
  int failed = -1;
  for (int i = 0; i <= steps; i += quarter)
    if (fails(i) && failed < 0) failed = i;
  if (failed > 0)
    for (int held = failed - quarter; failed - held > 1;) {
      const int middle = (held + failed) / 2;
      // Between counts of something that follow each other lies none.
      if (range.whole &&
          std::abs(range.at(static_cast<double>(held) / steps) - range.at(static_cast<double>(failed) / steps)) <= 1)
        break;
      (fails(middle) ? failed : held) = middle;
    }
  return values_of(points);
}

Threshold threshold_of(std::span<const SweepPoint> points, const Expected& holds) {
  CHECK(!points.empty());
  const std::vector<std::size_t> seeds = all_seeds(points);
  const auto first = std::ranges::find_if(points, [&](const SweepPoint& p) { return is_failed(p, holds); });
  Threshold threshold;
  threshold.t = crossing(points, holds, seeds);
  if (first == points.end()) {
    threshold.held = threshold.failed = 1;
  } else {
    threshold.holding = first == points.begin() ? Holding::nowhere : Holding::up_to;
    threshold.failed = first->t;
    threshold.held = first == points.begin() ? first->t : std::prev(first)->t;
    threshold.is_monotone = std::all_of(first, points.end(), [&](const SweepPoint& p) { return is_failed(p, holds); });
  }
  threshold.interval = {threshold.held, threshold.failed};
  if (seeds.size() < 2) return threshold;
  const auto found =
      bootstrap_interval(seeds.size(), [&](std::span<const std::size_t> of) { return crossing(points, holds, of); });
  if (!found) return threshold;
  // A repetition has its own noise.
  const double wider = std::sqrt(2.0), t = threshold.t;
  double below = t - found->low, above = found->high - t;
  if (threshold.holding == Holding::up_to) {
    const double error = crossing_error(points, static_cast<std::size_t>(first - points.begin()), holds, seeds);
    below = std::max(below, error);
    above = std::max(above, error);
  }
  threshold.interval = {std::clamp(t - wider * below, 0.0, threshold.held),
                        std::clamp(t + wider * above, threshold.failed, 1.0)};
  return threshold;
}

Mended mended(std::span<const SweepPoint> without, std::span<const SweepPoint> with, const Expected& holds,
              const SweepRange& range) {
  const double decades = std::abs(std::log(range.to / range.from));
  const auto factor = [&](std::span<const std::size_t> seeds) {
    return std::exp(decades * (crossing(with, holds, seeds) - crossing(without, holds, seeds)));
  };
  const std::vector<std::size_t> seeds = all_seeds(without);
  const double a = crossing(without, holds, seeds), b = crossing(with, holds, seeds);
  Mended result{factor(seeds), {}, b >= 1 || a <= 0, b <= 0 || a >= 1};
  result.interval = {result.factor, result.factor};
  if (seeds.size() > 1)
    if (const auto found = bootstrap_interval(seeds.size(), factor)) result.interval = *found;
  if (result.at_most) result.interval.low = 0;
  if (result.at_least) result.interval.high = endless;
  return result;
}

}  // namespace etendue
