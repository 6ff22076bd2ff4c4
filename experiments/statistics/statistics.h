// Statistics of an experiment's figures: averages, quantiles, intervals and Pareto fronts.
//
// Errors are positive and spread over decades, so they are averaged and interpolated in logarithms; a signed figure (bias) is
// averaged as it is. Seeds are the independent replicates: checkpoints of one run are autocorrelated, so every bootstrap
// resamples whole seeds, never checkpoints.
#pragma once

#include "framework/core/vec.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace etendue {

struct Interval {
  double low = 0, high = 0;
  bool contains(double x) const { return low <= x && x <= high; }
};

// All of these CHECK that there is at least one value.
double mean(std::span<const double> values);
double geometric_mean(std::span<const double> values);      // 0 where any value is 0; values must not be negative
double sample_sd(std::span<const double> values);           // with n - 1; 0 for a single value
double quantile(std::span<const double> values, double p);  // linear between order statistics ([Hyndman1996] type 7)
double median(std::span<const double> values);

// Finds the t with P(T <= t) = p for Student's distribution; p lies in (0, 1), degrees of freedom are above 0.
double student_t_quantile(double p, double degrees);
// The level each of `tests` two-sided tests is held to so that all of them together err with `level` ([Sidak1967]).
double sidak_level(double level, std::size_t tests);

// The 95 % interval of a share of which `count` of `of` were seen ([Clopper1934]): all of [0, 1] where of = 0.
Interval share_interval(std::size_t count, std::size_t of);
// The tail index of the largest `share` of the values ([Hill1975]): P(value > v) falls as v^-index there. Moments of that order
// and above are infinite: below 2 a standard error says nothing, below 1 neither does a mean. Values must not be negative. At
// most `lightest_tail`; 0 where no more than that share of the values is above 0, so that there is nothing but tail.
inline constexpr double lightest_tail = 100;
double tail_index(std::span<const double> values, double share);

// How an interval around a centre was made, which depends on how many seeds there are.
enum class Spread : std::uint8_t {
  none,     // one seed: no interval
  min_max,  // two seeds, or a zero among the values: the extremes
  t95       // three or more: 95 % Student interval of the mean (of the logarithms, where the centre is geometric)
};

struct Estimate {
  double centre = 0;
  Interval interval;  // equal to the centre where spread is none
  Spread spread = Spread::none;
  std::size_t count = 0;
};
Estimate geometric_estimate(std::span<const double> values);  // of errors: values >= 0
Estimate signed_estimate(std::span<const double> values, double confidence = 0.95);

// a / b of two geometric means with its 95 % Welch interval ([Welch1947], in logarithms); empty with fewer than three values in
// either, or with zeros.
struct Ratio {
  double value = 1;
  Interval interval;
};
std::optional<Ratio> geometric_ratio(std::span<const double> a, std::span<const double> b);

// 95 % percentile bootstrap ([Efron1993] ch. 13) over `count` replicates: `statistic` gets the indices of a resample; results
// that are not finite are left out. Its percentiles are moved outwards as Student's distribution asks ([Hesterberg2015]
// section 5.2): the plain ones are too narrow for few replicates. It is deterministic in `seed`, and
// empty if fewer than half of the resamples gave a figure.
struct BootstrapOptions {
  int resamples = 2000;
  std::uint64_t seed = 1;
};
std::optional<Interval> bootstrap_interval(std::size_t count,
                                           const std::function<double(std::span<const std::size_t>)>& statistic,
                                           const BootstrapOptions& options = {});
// The intervals of several statistics of the same resamples; `statistics` fills its second argument, which has `figures` of
// them.
std::vector<std::optional<Interval>> bootstrap_intervals(
    std::size_t count, std::size_t figures,
    const std::function<void(std::span<const std::size_t>, std::span<double>)>& statistics,
    const BootstrapOptions& options = {});

// A figure against time or iterations: x strictly ascending and positive.
struct Curve {
  std::vector<double> x, y;
  bool empty() const { return x.empty(); }
};
// Interpolates between the checkpoints around `x`, linear on log-log axes (linear in y where an end is not positive); nothing
// outside them.
std::optional<double> value_at(const Curve& curve, double x);

// The x where the logarithm of a ratio, linear in log x between x0 and x1, is zero: the two have different signs there.
double equality_between(double x0, double log_ratio0, double x1, double log_ratio1);

// When a falling curve first meets `target`. A curve that never arrives is censored at its last time, not dropped; one below
// the target at its first checkpoint arrived at some unknown earlier time.
struct Arrival {
  enum class Kind : std::uint8_t { at, before, never } kind = Kind::never;
  double time = 0;  // at: interpolated; before: of the first checkpoint; never: of the last
};
Arrival time_to(const Curve& curve, double target);
bool is_earlier(const Arrival& a, const Arrival& b);  // what never arrives is later than all else
// The median of several arrivals, and the 95th percentile as an order statistic: the least by which 95 % had arrived, of fewer
// than twenty the last. `never` sorts last, so the one is a time only if more than half arrived, the other if 95 % did.
struct ArrivalMedian {
  Arrival median, late;
  std::size_t arrived = 0, count = 0;
};
ArrivalMedian median_arrival(std::span<const Arrival> arrivals);

// Indices of the points that no other point beats in both coordinates (less is better), by ascending x; of equal points the
// first.
std::vector<std::size_t> pareto_front(std::span<const dvec2> points);

}  // namespace etendue
