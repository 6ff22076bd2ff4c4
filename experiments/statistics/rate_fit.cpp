#include "experiments/statistics/rate_fit.h"

#include "framework/core/check.h"

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

struct LogPoint {
  double x, log_x, log_y, weight;
};

struct FitParameters {
  double exponent = 0, log_amplitude = 0, plateau = 0;
};

std::optional<FitParameters> fit_power(std::span<const LogPoint> points) {
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
  return FitParameters{xy / xx, mean_y - xy / xx * mean_x, 0};
}

// y = A (x^e + ratio), x relative to the largest. The residuals log y - log(x^e + ratio) less their mean, which is log A, and
// how they change with e and with the logarithm of the ratio.
class PlateauResiduals {
 public:
  explicit PlateauResiduals(std::span<const LogPoint> points) : points_(points) {
    for (const LogPoint& p : points) last_ = std::max(last_, p.log_x);
  }

  double squares(const dvec2& at) { return evaluate(at).squares; }

  // Takes one step of Gauss and Newton, damped as by [Marquardt1963].
  dvec2 step(const dvec2& at, double damping) {
    const Sums s = evaluate(at);
    const double ee = s.ee * (1 + damping), qq = s.qq * (1 + damping), determinant = ee * qq - s.eq * s.eq;
    if (!(std::abs(determinant) > 1e-300)) return at;
    return bounded(at + dvec2(qq * s.re - s.eq * s.rq, ee * s.rq - s.eq * s.re) / determinant);
  }

  FitParameters parameters(const dvec2& at) {
    const double log_amplitude = evaluate(at).log_amplitude;
    return {at.x, log_amplitude - at.x * last_, std::exp(log_amplitude + at.y)};
  }

  // Exponents from -3 to -0.05; a plateau from 1e-5 to 1e5 times the decaying part at the last point.
  static constexpr double steepest = -3, flattest = -0.05, log_bound = 11.5;
  static dvec2 bounded(const dvec2& at) {
    return {std::clamp(at.x, steepest, flattest), std::clamp(at.y, -log_bound, log_bound)};
  }

 private:
  struct Sums {
    double squares, log_amplitude, ee, eq, qq, re, rq;
  };

  Sums evaluate(const dvec2& at) {
    const double ratio = std::exp(at.y);
    double w = 0, r = 0, e = 0, q = 0, rr = 0, ee = 0, eq = 0, qq = 0, re = 0, rq = 0;
    for (const LogPoint& p : points_) {
      const double x = p.log_x - last_, decaying = std::exp(at.x * x), model = decaying + ratio;
      const double residual = p.log_y - std::log(model), by_e = decaying * x / model, by_q = ratio / model;
      w += p.weight;
      r += p.weight * residual;
      e += p.weight * by_e;
      q += p.weight * by_q;
      rr += p.weight * residual * residual;
      ee += p.weight * by_e * by_e;
      eq += p.weight * by_e * by_q;
      qq += p.weight * by_q * by_q;
      re += p.weight * residual * by_e;
      rq += p.weight * residual * by_q;
    }
    return {rr - r * r / w, r / w, ee - e * e / w, eq - e * q / w, qq - q * q / w, re - r * e / w, rq - r * q / w};
  }

  std::span<const LogPoint> points_;
  double last_ = -std::numeric_limits<double>::infinity();
};

// The sum of squares may have several valleys: a grid finds the deepest, steps of Gauss and Newton its bottom.
std::optional<FitParameters> fit_plateau(std::span<const LogPoint> points) {
  if (points.size() < 4) return std::nullopt;
  using R = PlateauResiduals;
  R residuals(points);
  constexpr int steps = 12;
  dvec2 best(0);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; j <= steps; ++j) {
      const dvec2 at(R::steepest + i * (R::flattest - R::steepest) / steps, R::log_bound * (2.0 * j / steps - 1));
      const double squares = residuals.squares(at);
      if (squares >= least) continue;
      least = squares;
      best = at;
    }
  double damping = 1e-2;
  for (int i = 0; i < 60 && damping < 1e8; ++i) {
    const dvec2 next = residuals.step(best, damping);
    const double squares = residuals.squares(next);
    const bool better = squares < least;
    const double change = glm::length(next - best);
    damping *= better ? 0.2 : 5;
    if (better) {
      best = next;
      least = squares;
    }
    if (change < 1e-10) break;
  }
  return residuals.parameters(best);
}

std::optional<FitParameters> fit(std::span<const LogPoint> points, Prediction::Model model) {
  if (points.size() < 3) return std::nullopt;
  return model == Prediction::Model::plateau ? fit_plateau(points) : fit_power(points);
}

// Variance of change(y), seed by seed left out; infinite where that is no number, 0 where there are fewer than three.
double jackknife_variance(const RatePoint& point, const std::string& metric, double (*change)(double)) {
  const std::size_t seeds = point.x.size();
  if (seeds < 3) return 0;
  std::vector<double> weights(seeds, 1), values(seeds);
  for (std::size_t i = 0; i < seeds; ++i) {
    weights[i] = 0;
    values[i] = change(rate_value(point, metric, weights));
    weights[i] = 1;
  }
  const auto n = static_cast<double>(seeds);
  const double sd = sample_sd(values);
  return std::isfinite(sd) ? (n - 1) * (n - 1) / n * sd * sd : std::numeric_limits<double>::infinity();
}

// Least-squares weights from all seeds; equal where nothing is known of the points' variances.
std::vector<double> point_weights(std::span<const RatePoint> points, const std::string& metric) {
  auto variances = mapped(points, [&](const RatePoint& point) { return jackknife_variance(point, metric, std::log); });
  const double middle = variances.empty() ? 0 : median(variances);
  if (!(middle > 0) || !std::isfinite(middle)) return std::vector<double>(points.size(), 1);
  for (double& variance : variances) variance = std::isfinite(variance) ? 1 / (variance / middle + 1) : 1e-6;
  return variances;
}

}  // namespace

std::vector<double> mirrored(const std::vector<double>& half, std::size_t seeds) {
  CHECK_EQ(half.size(), seeds * (seeds + 1) / 2);
  std::vector<double> products(seeds * seeds);
  std::size_t pair = 0;
  for (std::size_t i = 0; i < seeds; ++i)
    for (std::size_t j = i; j < seeds; ++j) products[i * seeds + j] = products[j * seeds + i] = half[pair++];
  return products;
}

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
  if (std::ranges::all_of(point.x, [&](double x) { return x == point.x.front(); })) return point.x.front();
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
  const double variance = jackknife_variance(point, metric, std::log);
  if (!(variance > 0) || !(value.y > 0)) return value;
  const double half = student_t_quantile(0.975, static_cast<double>(point.x.size()) - 1) * std::sqrt(variance);
  value.interval = {value.y * std::exp(-half), value.y * std::exp(half)};
  return value;
}

BiasVariance bias_variance(std::size_t count, const std::vector<double>& half, double reference_variance) {
  CHECK_LE(std::size_t{2}, count);
  const std::vector<double> ones(count, 1);
  const RatePoint point{ones, mirrored(half, count), reference_variance};
  const double variance = jackknife_variance(point, "bias2", [](double y) { return y; });
  return {rate_value(point, "bias2", ones), rate_value(point, "variance", ones), std::sqrt(variance), count};
}

double RateFit::value(double x) const { return amplitude * std::pow(x, exponent) + plateau; }

std::optional<RateFit> fit_rate(std::span<const RatePoint> given, const std::string& metric, Prediction::Model model,
                                const BootstrapOptions& options) {
  std::vector<RatePoint> points;
  for (const RatePoint& point : given)
    if (std::ranges::all_of(point.x, [](double x) { return x > 0; })) points.push_back(point);
  if (points.empty()) return std::nullopt;
  const std::size_t seeds = points.front().x.size();
  const std::vector<double> weights = point_weights(points, metric);
  std::vector<LogPoint> logs;
  const auto collect = [&](std::span<const double> drawn) {
    logs.clear();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double x = rate_abscissa(points[i], drawn), y = rate_value(points[i], metric, drawn);
      if (y > 0 && std::isfinite(x) && std::isfinite(y)) logs.push_back({x, std::log(x), std::log(y), weights[i]});
    }
  };
  std::vector<double> drawn(seeds, 1);
  collect(drawn);
  const auto found = fit(logs, model);
  if (!found) return std::nullopt;
  RateFit result{found->exponent, std::exp(found->log_amplitude), found->plateau, {}, {},
                 logs.size(),     points.size() - logs.size()};
  const auto by_x = [](const LogPoint& a, const LogPoint& b) { return a.x < b.x; };
  result.from = std::ranges::min_element(logs, by_x)->x;
  result.to = std::ranges::max_element(logs, by_x)->x;
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
  if (model == Prediction::Model::plateau) result.plateau_interval = intervals[1];
  return result;
}

}  // namespace etendue
