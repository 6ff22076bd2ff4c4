#include "experiments/harness/rate_fit.h"

#include "framework/core/check.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace etendue {

namespace {

struct LogPoint {
  double x, log_x, log_y, weight;
};

struct Parameters {
  double exponent = 0, log_amplitude = 0, plateau = 0;
};

std::optional<Parameters> fit_power(std::span<const LogPoint> points) {
  double w = 0, wx = 0, wy = 0;
  for (const LogPoint& p : points) {
    w += p.weight;
    wx += p.weight * p.log_x;
    wy += p.weight * p.log_y;
  }
  const double mean_x = wx / w, mean_y = wy / w;
  double xx = 0, xy = 0;
  for (const LogPoint& p : points) {
    xx += p.weight * (p.log_x - mean_x) * (p.log_x - mean_x);
    xy += p.weight * (p.log_x - mean_x) * (p.log_y - mean_y);
  }
  if (!(xx > 0)) return std::nullopt;
  return Parameters{xy / xx, mean_y - xy / xx * mean_x, 0};
}

// Of A (x^e + P/A) with the best A: the sum of squares, and log A. x is relative to the largest, so that x^e >= 1 for e < 0.
struct Residual {
  double squares, log_amplitude;
};

Residual plateau_residual(std::span<const LogPoint> points, double last, double exponent, double log_ratio) {
  const double ratio = std::exp(log_ratio);
  double w = 0, wr = 0, wrr = 0;
  for (const LogPoint& p : points) {
    const double r = p.log_y - std::log(std::pow(p.x / last, exponent) + ratio);
    w += p.weight;
    wr += p.weight * r;
    wrr += p.weight * r * r;
  }
  return {wrr - wr * wr / w, wr / w};
}

// The sum of squares is smooth in two unknowns but need not have one minimum: a grid finds the best valley, smaller grids
// follow it. Exponents from -3 to -0.05; the plateau from 1e-5 of the decaying part at the last point to 1e5 of it.
std::optional<Parameters> fit_plateau(std::span<const LogPoint> points) {
  if (points.size() < 4) return std::nullopt;
  double last = 0;
  for (const LogPoint& p : points) last = std::max(last, p.x);
  constexpr double log_bound = 11.5;
  double e = -1.5, q = 0, step_e = 1.45 / 8, step_q = log_bound / 8, best = std::numeric_limits<double>::infinity();
  const auto search = [&](int reach) {
    const double centre_e = e, centre_q = q;
    for (int i = -reach; i <= reach; ++i)
      for (int j = -reach; j <= reach; ++j) {
        const double exponent = std::clamp(centre_e + i * step_e, -3.0, -0.05);
        const double log_ratio = std::clamp(centre_q + j * step_q, -log_bound, log_bound);
        const double squares = plateau_residual(points, last, exponent, log_ratio).squares;
        if (squares >= best) continue;
        best = squares;
        e = exponent;
        q = log_ratio;
      }
  };
  search(8);
  for (int round = 0; round < 24; ++round) {
    step_e *= 0.6;
    step_q *= 0.6;
    search(2);
  }
  const double log_amplitude = plateau_residual(points, last, e, q).log_amplitude;
  return Parameters{e, log_amplitude - e * std::log(last), std::exp(log_amplitude + q)};
}

std::optional<Parameters> fit(std::span<const LogPoint> points, RateLaw::Model model) {
  if (points.size() < 3) return std::nullopt;
  return model == RateLaw::Model::plateau ? fit_plateau(points) : fit_power(points);
}

// Variance of log y, seed by seed left out; infinite where that is no number.
double jackknife_variance(const RatePoint& point, const std::string& metric) {
  const std::size_t seeds = point.x.size();
  if (seeds < 3) return 0;
  std::vector<double> weights(seeds, 1), logs(seeds);
  for (std::size_t i = 0; i < seeds; ++i) {
    weights[i] = 0;
    logs[i] = std::log(rate_value(point, metric, weights));
    weights[i] = 1;
  }
  const auto n = static_cast<double>(seeds);
  const double sd = sample_sd(logs);
  return std::isfinite(sd) ? (n - 1) * (n - 1) / n * sd * sd : std::numeric_limits<double>::infinity();
}

// Least-squares weights from all seeds; equal where nothing is known of the points' variances.
std::vector<double> point_weights(std::span<const RatePoint> points, const std::string& metric) {
  std::vector<double> variances;
  for (const RatePoint& point : points) variances.push_back(jackknife_variance(point, metric));
  const double middle = variances.empty() ? 0 : median(variances);
  if (!(middle > 0) || !std::isfinite(middle)) return std::vector<double>(points.size(), 1);
  for (double& variance : variances) variance = std::isfinite(variance) ? 1 / (variance / middle + 1) : 1e-6;
  return variances;
}

}  // namespace

double rate_value(const RatePoint& point, const std::string& metric, std::span<const double> weights) {
  const std::size_t seeds = point.x.size();
  CHECK_EQ(weights.size(), seeds);
  CHECK_EQ(point.products.size(), seeds * seeds);
  double total = 0, squares = 0, own = 0, weighted_own = 0;
  for (std::size_t i = 0; i < seeds; ++i) {
    const double g = point.products[i * seeds + i];
    total += weights[i];
    squares += weights[i] * weights[i];
    own += weights[i] * g;
    weighted_own += weights[i] * weights[i] * g;
  }
  const double mse = own / total - point.offset;
  if (metric == "mse") return mse;
  if (metric == "rmse") return mse > 0 ? std::sqrt(mse) : mse;
  double all = 0;
  for (std::size_t i = 0; i < seeds; ++i) {
    if (weights[i] == 0) continue;
    double row = 0;
    for (std::size_t j = 0; j < seeds; ++j) row += weights[j] * point.products[i * seeds + j];
    all += weights[i] * row;
  }
  const double bias_squared = (all - weighted_own) / (total * total - squares) - point.offset;
  return metric == "bias2" ? bias_squared : mse - bias_squared;
}

double rate_abscissa(const RatePoint& point, std::span<const double> weights) {
  if (std::all_of(point.x.begin(), point.x.end(), [&](double x) { return x == point.x.front(); })) return point.x.front();
  double total = 0, logs = 0;
  for (std::size_t i = 0; i < point.x.size(); ++i) {
    if (weights[i] == 0) continue;
    total += weights[i];
    logs += weights[i] * std::log(point.x[i]);
  }
  return std::exp(logs / total);
}

RateValue rate_estimate(const RatePoint& point, const std::string& metric) {
  const std::vector<double> ones(point.x.size(), 1);
  RateValue value{rate_abscissa(point, ones), rate_value(point, metric, ones), {}};
  value.interval = {value.y, value.y};
  const double variance = jackknife_variance(point, metric);
  if (!(variance > 0) || !(value.y > 0)) return value;
  const double half = student_t_quantile(0.975, static_cast<double>(point.x.size()) - 1) * std::sqrt(variance);
  value.interval = {value.y * std::exp(-half), value.y * std::exp(half)};
  return value;
}

double RateFit::value(double x) const { return amplitude * std::pow(x, exponent) + plateau; }

std::optional<RateFit> fit_rate(std::span<const RatePoint> points, const std::string& metric, RateLaw::Model model,
                                const BootstrapOptions& options) {
  if (points.empty()) return std::nullopt;
  const std::size_t seeds = points.front().x.size();
  const std::vector<double> weights = point_weights(points, metric);
  std::vector<LogPoint> logs;
  const auto collect = [&](std::span<const double> drawn) {
    logs.clear();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double x = rate_abscissa(points[i], drawn), y = rate_value(points[i], metric, drawn);
      if (x > 0 && y > 0 && std::isfinite(x) && std::isfinite(y)) logs.push_back({x, std::log(x), std::log(y), weights[i]});
    }
  };
  std::vector<double> drawn(seeds, 1);
  collect(drawn);
  const auto found = fit(logs, model);
  if (!found) return std::nullopt;
  RateFit result{found->exponent, std::exp(found->log_amplitude), found->plateau, {}, {},
                 logs.size(),     points.size() - logs.size()};
  const auto by_x = [](const LogPoint& a, const LogPoint& b) { return a.x < b.x; };
  result.from = std::min_element(logs.begin(), logs.end(), by_x)->x;
  result.to = std::max_element(logs.begin(), logs.end(), by_x)->x;
  if (seeds < 3) return result;
  const auto intervals = bootstrap_intervals(
      seeds, 2,
      [&](std::span<const std::size_t> chosen, std::span<double> out) {
        std::fill(drawn.begin(), drawn.end(), 0.0);
        for (const std::size_t i : chosen) drawn[i] += 1;
        collect(drawn);
        const auto again = fit(logs, model);
        out[0] = again ? again->exponent : std::numeric_limits<double>::quiet_NaN();
        out[1] = again ? again->plateau : std::numeric_limits<double>::quiet_NaN();
      },
      options);
  result.exponent_interval = intervals[0];
  if (model == RateLaw::Model::plateau) result.plateau_interval = intervals[1];
  return result;
}

}  // namespace etendue
