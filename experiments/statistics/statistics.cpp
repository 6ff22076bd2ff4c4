#include "experiments/statistics/statistics.h"

#include "framework/core/check.h"
#include "framework/core/lists.h"
#include "framework/core/rng.h"

#include <algorithm>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>
#include <functional>
#include <numeric>

namespace etendue {
namespace {

std::vector<double> logarithms(std::span<const double> values) {
  return mapped(values, [](double v) { return std::log(v); });
}

bool all_positive(std::span<const double> values) {
  return std::ranges::all_of(values, [](double v) { return v > 0; });
}

}  // namespace

double mean(std::span<const double> values) {
  CHECK(!values.empty());
  // Equal values average to themselves, so that shared iteration counts stay whole numbers.
  if (std::ranges::all_of(values, [&](double v) { return v == values[0]; })) return values[0];
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double geometric_mean(std::span<const double> values) {
  CHECK(!values.empty());
  if (std::ranges::all_of(values, [&](double v) { return v == values[0]; })) return values[0];
  return all_positive(values) ? std::exp(mean(logarithms(values))) : 0;
}

double sample_sd(std::span<const double> values) {
  if (values.size() < 2) return 0;
  const double centre = mean(values);
  double squares = 0;
  for (const double v : values) squares += (v - centre) * (v - centre);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

double quantile(std::span<const double> values, double p) {
  CHECK(!values.empty());
  std::vector<double> sorted(values.begin(), values.end());
  std::ranges::sort(sorted);
  const double position = std::clamp(p, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  const double fraction = position - static_cast<double>(below);
  return fraction == 0 || sorted[below] == sorted[above] ? sorted[below]
                                                         : sorted[below] + fraction * (sorted[above] - sorted[below]);
}

double median(std::span<const double> values) { return quantile(values, 0.5); }

double student_t_quantile(double p, double degrees) {
  CHECK(p > 0 && p < 1 && degrees > 0);
  if (p == 0.5) return 0;
  // Beyond t lies half the incomplete beta function at x = degrees / (degrees + t^2); 1 - x keeps its digits where x is close
  // to 1.
  double rest = 0;
  const double x = boost::math::ibeta_inv(degrees / 2, 0.5, 2 * std::min(p, 1 - p), &rest);
  return std::copysign(std::sqrt(degrees * rest / x), p - 0.5);
}

double sidak_level(double level, std::size_t tests) {
  return tests < 2 ? level : -std::expm1(std::log1p(-level) / static_cast<double>(tests));
}

Interval share_interval(std::size_t count, std::size_t of) {
  CHECK_LE(count, of);
  const auto k = static_cast<double>(count), n = static_cast<double>(of);
  return {count == 0 ? 0 : boost::math::ibeta_inv(k, n - k + 1, 0.025),
          count == of ? 1 : boost::math::ibeta_inv(k + 1, n - k, 0.975)};
}

double tail_index(std::span<const double> values, double share) {
  CHECK(!values.empty());
  const auto count = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  if (count == 0 || count >= values.size()) return lightest_tail;
  std::vector<double> sorted(values.begin(), values.end());
  std::ranges::partial_sort(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(count + 1), std::greater<>());
  if (sorted[count] <= 0) return 0;
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += std::log(sorted[i] / sorted[count]);
  return std::min(lightest_tail, static_cast<double>(count) / std::max(sum, 1e-300));
}

Estimate signed_estimate(std::span<const double> values, double confidence) {
  Estimate estimate{mean(values), {}, Spread::none, values.size()};
  estimate.interval = {estimate.centre, estimate.centre};
  if (values.size() == 2) {
    estimate.interval = {std::min(values[0], values[1]), std::max(values[0], values[1])};
    estimate.spread = Spread::min_max;
  } else if (values.size() > 2) {
    const auto n = static_cast<double>(values.size());
    const double half = student_t_quantile(0.5 + confidence / 2, n - 1) * sample_sd(values) / std::sqrt(n);
    estimate.interval = {estimate.centre - half, estimate.centre + half};
    estimate.spread = Spread::t95;
  }
  return estimate;
}

Estimate geometric_estimate(std::span<const double> values) {
  if (!all_positive(values)) {
    Estimate estimate{median(values), {}, values.size() > 1 ? Spread::min_max : Spread::none, values.size()};
    estimate.interval = {*std::ranges::min_element(values), *std::ranges::max_element(values)};
    return estimate;
  }
  Estimate estimate = signed_estimate(logarithms(values));
  estimate.centre = geometric_mean(values);
  estimate.interval = {std::exp(estimate.interval.low), std::exp(estimate.interval.high)};
  if (estimate.spread == Spread::none) estimate.interval = {estimate.centre, estimate.centre};
  return estimate;
}

std::optional<Ratio> geometric_ratio(std::span<const double> a, std::span<const double> b) {
  if (a.size() < 3 || b.size() < 3 || !all_positive(a) || !all_positive(b)) return std::nullopt;
  const auto log_a = logarithms(a), log_b = logarithms(b);
  const auto squared_error = [](const std::vector<double>& v) {
    const double sd = sample_sd(v);
    return sd * sd / static_cast<double>(v.size());
  };
  const double difference = mean(log_a) - mean(log_b), va = squared_error(log_a), vb = squared_error(log_b);
  if (va + vb == 0) return Ratio{std::exp(difference), {std::exp(difference), std::exp(difference)}};
  const double degrees =
      (va + vb) * (va + vb) / (va * va / static_cast<double>(a.size() - 1) + vb * vb / static_cast<double>(b.size() - 1));
  const double half = student_t_quantile(0.975, degrees) * std::sqrt(va + vb);
  return Ratio{std::exp(difference), {std::exp(difference - half), std::exp(difference + half)}};
}

std::vector<std::optional<Interval>> bootstrap_intervals(
    std::size_t count, std::size_t figures,
    const std::function<void(std::span<const std::size_t>, std::span<double>)>& statistics, const BootstrapOptions& options) {
  CHECK(count > 0 && options.resamples > 0);
  Pcg32 rng(options.seed, count);
  std::vector<std::size_t> indices(count);
  std::vector<std::vector<double>> results(figures);
  std::vector<double> result(figures);
  for (int i = 0; i < options.resamples; ++i) {
    for (auto& index : indices) index = static_cast<std::size_t>((std::uint64_t{rng.next()} * count) >> 32);
    statistics(indices, result);
    for (std::size_t f = 0; f < figures; ++f)
      if (std::isfinite(result[f])) results[f].push_back(result[f]);
  }
  constexpr double confidence = 0.95;
  double tail = (1 - confidence) / 2;
  if (count > 1) {
    const auto n = static_cast<double>(count);
    tail = 0.5 * std::erfc(std::sqrt(n / (n - 1)) * student_t_quantile(1 - tail, n - 1) / std::numbers::sqrt2);
  }
  std::vector<std::optional<Interval>> intervals(figures);
  for (std::size_t f = 0; f < figures; ++f)
    if (2 * results[f].size() >= static_cast<std::size_t>(options.resamples))
      intervals[f] = Interval{quantile(results[f], tail), quantile(results[f], 1 - tail)};
  return intervals;
}

std::optional<Interval> bootstrap_interval(std::size_t count,
                                           const std::function<double(std::span<const std::size_t>)>& statistic,
                                           const BootstrapOptions& options) {
  const auto one = [&](std::span<const std::size_t> chosen, std::span<double> out) { out[0] = statistic(chosen); };
  return bootstrap_intervals(count, 1, one, options)[0];
}

std::optional<double> value_at(const Curve& curve, double x) {
  if (curve.empty()) return std::nullopt;
  // An average of equal times may differ from them in its last bits.
  constexpr double slack = 1e-12;
  if (x < curve.x.front() * (1 - slack) || x > curve.x.back() * (1 + slack)) return std::nullopt;
  const auto upper = std::ranges::lower_bound(curve.x, x);
  if (upper == curve.x.begin()) return curve.y.front();
  if (upper == curve.x.end()) return curve.y.back();
  const auto i = static_cast<std::size_t>(upper - curve.x.begin());
  if (curve.x[i] == x) return curve.y[i];
  const double fraction = std::log(x / curve.x[i - 1]) / std::log(curve.x[i] / curve.x[i - 1]);
  const double a = curve.y[i - 1], b = curve.y[i];
  return a > 0 && b > 0 ? a * std::pow(b / a, fraction) : a + fraction * (b - a);
}

double equality_between(double x0, double log_ratio0, double x1, double log_ratio1) {
  return x0 * std::pow(x1 / x0, log_ratio0 / (log_ratio0 - log_ratio1));
}

Arrival time_to(const Curve& curve, double target) {
  if (curve.empty()) return {};
  const auto found = std::ranges::find_if(curve.y, [&](double y) { return y <= target; });
  if (found == curve.y.end()) return {Arrival::Kind::never, curve.x.back()};
  const auto i = static_cast<std::size_t>(found - curve.y.begin());
  if (i == 0) return {Arrival::Kind::before, curve.x.front()};
  const double a = curve.y[i - 1], b = curve.y[i];
  const double fraction = b > 0 && target > 0 ? std::log(target / a) / std::log(b / a) : (a - target) / (a - b);
  return {Arrival::Kind::at, curve.x[i - 1] * std::pow(curve.x[i] / curve.x[i - 1], fraction)};
}

bool is_earlier(const Arrival& a, const Arrival& b) {
  const bool never_a = a.kind == Arrival::Kind::never, never_b = b.kind == Arrival::Kind::never;
  return never_a != never_b ? never_b : a.time < b.time;
}

ArrivalMedian median_arrival(std::span<const Arrival> arrivals) {
  CHECK(!arrivals.empty());
  std::vector<Arrival> sorted(arrivals.begin(), arrivals.end());
  std::ranges::stable_sort(sorted, is_earlier);
  ArrivalMedian result;
  result.count = sorted.size();
  result.arrived =
      static_cast<std::size_t>(std::ranges::count_if(sorted, [](const Arrival& a) { return a.kind != Arrival::Kind::never; }));
  result.late = sorted[(95 * sorted.size() + 99) / 100 - 1];
  const std::size_t upper = sorted.size() / 2, lower = (sorted.size() - 1) / 2;
  result.median = sorted[upper];
  if (result.median.kind != Arrival::Kind::never) {
    result.median.time = 0.5 * (sorted[lower].time + sorted[upper].time);
    if (sorted[lower].kind == Arrival::Kind::before) result.median.kind = Arrival::Kind::before;
  }
  return result;
}

std::vector<std::size_t> pareto_front(std::span<const dvec2> points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    return points[a].x != points[b].x ? points[a].x < points[b].x : points[a].y < points[b].y;
  });
  std::vector<std::size_t> front;
  for (const std::size_t i : order)
    if (front.empty() || points[i].y < points[front.back()].y) front.push_back(i);
  return front;
}

}  // namespace etendue
