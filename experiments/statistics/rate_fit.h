// The exponent at which an error falls, with an interval over seeds, and the split of error into bias and variance.
//
// A point of a convergence curve holds its x and, for the seeds i and j, the mean over the region's pixels and channels of the
// product of their errors, G_ij = mean (x_i - r)(x_j - r). With seeds weighted by how often a resample drew them this gives
//
//   mse       sum_i w_i G_ii / sum_i w_i                          rmse  its root
//   bias2     sum_{i != j} w_i w_j G_ij / sum_{i != j} w_i w_j    = (mean - r)^2 - s^2 / R, free of the seeds' variance
//   variance  mse - bias2
//
// A curve is fitted by weighted least squares in logarithms: log y = log A + e log x, or log y = log (A x^e + P). Weights are 1
// / (v + median v), v the jackknife variance of a point's log y ([Efron1993] ch. 11): ten seeds do not give v precisely enough
// to be used alone. Intervals are a bootstrap over seeds: whole trajectories are drawn, because the checkpoints of one are
// autocorrelated; the weights stay as they were.
#pragma once

#include "experiments/config/prediction.h"
#include "experiments/statistics/statistics.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace etendue {

struct RatePoint {
  std::vector<double> x;         // by seed
  std::vector<double> products;  // G, seeds x seeds; only its diagonal is needed for mse and rmse
  double offset = 0;             // the reference's own variance, subtracted from mse and bias2
};

// The whole matrix of the half that is logged: i <= j, row by row (ProductsRecord).
std::vector<double> mirrored(const std::vector<double>& half, std::size_t seeds);

// The metric at a point from seeds drawn `weights` times each; x as the geometric mean. The metric may come out negative.
double rate_value(const RatePoint& point, const std::string& metric, std::span<const double> weights);
double rate_abscissa(const RatePoint& point, std::span<const double> weights);

// A chart draws the metric from all seeds with its 95 % interval (delta method on the jackknife, Student's t).
struct RateValue {
  double x = 0, y = 0;
  Interval interval;
};
RateValue rate_estimate(const RatePoint& point, const std::string& metric);

// Squared bias and variance of a method's image from G of `count` >= 2 independent images (CHECK). The squared bias is
// unbiased, hence negative at times; its standard error is the jackknife's over images, 0 for two.
struct BiasVariance {
  double bias_squared = 0, variance = 0, standard_error = 0;
  std::size_t count = 0;
};
BiasVariance bias_variance(std::size_t count, const std::vector<double>& half, double reference_variance);

struct RateFit {
  double exponent = 0, amplitude = 0, plateau = 0;              // y = amplitude x^exponent + plateau
  std::optional<Interval> exponent_interval, plateau_interval;  // 95 %; empty for fewer than three seeds
  std::size_t points = 0, dropped = 0;                          // used; with no positive metric, which has no logarithm
  double from = 0, to = 0;                                      // x of the first and last point used

  double value(double x) const;
};
// The points may have any order; all hold the same seeds. Those whose x is not positive lie in no window on a logarithmic axis
// and are neither used nor dropped. Empty where fewer than three points (four for a plateau) are left with a positive metric.
std::optional<RateFit> fit_rate(std::span<const RatePoint> points, const std::string& metric, Prediction::Model model,
                                const BootstrapOptions& options = {});

}  // namespace etendue
