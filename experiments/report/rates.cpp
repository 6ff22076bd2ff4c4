#include "experiments/report/rates.h"

#include "experiments/log/products.h"
#include "experiments/report/declared.h"
#include "framework/core/error.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace etendue {

namespace {

constexpr double slack = 1e-9;  // of a window's ends

double abscissa(const CheckpointRecord& checkpoint, const Prediction& law) {
  const std::string& x = law.x;
  if (x == "iterations") return static_cast<double>(checkpoint.iterations);
  if (x == "time") return checkpoint.time_s;
  if (x == "records" && !law.region.empty()) {
    const auto* metrics = metrics_in(checkpoint, law.region);
    return metrics ? find_value(*metrics, x).value_or(0) : 0;  // the image's number is another measure
  }
  return static_cast<double>(find_value(checkpoint.counters, x).value_or(0));
}

// A point of which only the seeds' own errors are known.
RatePoint diagonal_point(const std::vector<double>& x, const std::vector<double>& mse, double offset) {
  const std::size_t seeds = x.size();
  RatePoint point{x, std::vector<double>(seeds * seeds, 0), offset};
  for (std::size_t i = 0; i < seeds; ++i) point.products[i * seeds + i] = mse[i];
  return point;
}

class Gatherer {
 public:
  Gatherer(const ReportData& data, const SceneData& scene, const Prediction& law)
      : data_(data), law_(law), offset_(subtracted_variance(scene, law.region)) {}

  // Throws Error where the log does not hold what the law speaks of.
  std::vector<RatePoint> checkpoints(const Configuration& configuration) const {
    const std::size_t seeds = configuration.replicates.size();
    if (seeds < 2 && law_.needs_images()) throw Error("needs two seeds");
    if (!aligned(configuration)) {
      if (law_.needs_images()) throw Error("seeds stopped at different iterations");
      return interpolated(configuration);
    }
    const std::size_t count = configuration.replicates.front().checkpoints.size();
    std::vector<RatePoint> points;
    std::vector<double> x(seeds), mse(seeds);
    for (std::size_t k = 0; k < count; ++k) {
      for (std::size_t i = 0; i < seeds; ++i) {
        const CheckpointRecord& checkpoint = *configuration.replicates[i].checkpoints[k];
        x[i] = abscissa(checkpoint, law_);
        mse[i] = logged_mse(checkpoint, law_.region);
      }
      points.push_back(diagonal_point(x, mse, offset_));
    }
    if (law_.needs_images()) add_products(configuration, points);
    return points;
  }

  // The last checkpoint of each configuration, of the seeds that all of them have.
  std::vector<RatePoint> ends(const std::vector<const Configuration*>& configurations) const {
    std::set<std::uint64_t> seeds;
    for (const Replicate& replicate : configurations.front()->replicates) seeds.insert(replicate.seed);
    for (const Configuration* configuration : configurations)
      std::erase_if(seeds, [&](std::uint64_t seed) { return replicate_of(*configuration, seed) == nullptr; });
    if (seeds.empty()) throw Error("the configurations have no seed in common");
    if (law_.needs_images()) throw Error("bias and variance are found over checkpoints only");
    std::vector<RatePoint> points;
    for (const Configuration* configuration : configurations) {
      std::vector<double> x, mse;
      for (const std::uint64_t seed : seeds) {
        const CheckpointRecord& last = *replicate_of(*configuration, seed)->last();
        x.push_back(abscissa(last, law_));
        mse.push_back(logged_mse(last, law_.region));
      }
      points.push_back(diagonal_point(x, mse, offset_));
    }
    return points;
  }

 private:
  static const Replicate* replicate_of(const Configuration& configuration, std::uint64_t seed) {
    for (const Replicate& replicate : configuration.replicates)
      if (replicate.seed == seed) return &replicate;
    return nullptr;
  }

  static bool aligned(const Configuration& configuration) {
    const auto& first = configuration.replicates.front().checkpoints;
    return std::ranges::all_of(configuration.replicates, [&](const Replicate& replicate) {
      return std::equal(first.begin(), first.end(), replicate.checkpoints.begin(), replicate.checkpoints.end(),
                        [](const auto* a, const auto* b) { return a->iterations == b->iterations; });
    });
  }

  // Runs that a clock ended: each seed's curve is read where their checkpoints lie on the mean.
  std::vector<RatePoint> interpolated(const Configuration& configuration) const {
    std::vector<Curve> curves;
    double low = 0, high = std::numeric_limits<double>::infinity();
    std::size_t shared = std::numeric_limits<std::size_t>::max();
    for (const Replicate& replicate : configuration.replicates) {
      Curve& curve = curves.emplace_back();
      for (const CheckpointRecord* checkpoint : replicate.checkpoints) {
        const double x = abscissa(*checkpoint, law_);
        if (!(x > (curve.empty() ? 0 : curve.x.back()))) continue;
        curve.x.push_back(x);
        curve.y.push_back(logged_mse(*checkpoint, law_.region));
      }
      if (curve.empty()) throw Error(fmt::format("{} was not counted", law_.x));
      low = std::max(low, curve.x.front());
      high = std::min(high, curve.x.back());
      shared = std::min(shared, curve.x.size());
    }
    std::vector<RatePoint> points;
    double last = 0;
    for (std::size_t k = 0; k < shared && low <= high; ++k) {
      std::vector<double> at, mse;
      for (const Curve& curve : curves) at.push_back(curve.x[curve.x.size() - shared + k]);
      const double x = std::clamp(geometric_mean(at), low, high);
      if (x <= last * (1 + slack)) continue;
      last = x;
      for (const Curve& curve : curves) mse.push_back(value_at(curve, x).value_or(curve.y.back()));
      points.push_back(diagonal_point(std::vector<double>(curves.size(), x), mse, offset_));
    }
    return points;
  }

  void add_products(const Configuration& configuration, std::vector<RatePoint>& points) const {
    const CellName& name = configuration.any_cell()->cell;
    const ProductsRecord* record = current_products(*data_.log, name, law_.region, true);
    if (record == nullptr || record->products.size() != points.size())
      throw Error("the log does not have the products of errors at checkpoints; `etendue run` adds them from images");
    for (std::size_t k = 0; k < points.size(); ++k) points[k].products = mirrored(record->products[k], record->seeds.size());
  }

  const ReportData& data_;
  const Prediction& law_;
  double offset_;
};

void fit_points(FittedRate& rate) {
  std::vector<double> ones(rate.points.empty() ? 0 : rate.points.front().x.size(), 1);
  rate.seeds = ones.size();
  const auto x_of = [&](const RatePoint& point) { return rate_abscissa(point, ones); };
  std::ranges::stable_sort(rate.points, {}, x_of);
  std::vector<RatePoint> window;
  std::ranges::copy_if(rate.points, std::back_inserter(window), [&](const RatePoint& point) {
    return x_of(point) >= rate.law->from * (1 - slack) && x_of(point) <= rate.law->to * (1 + slack);
  });
  rate.fit = fit_rate(window, rate.law->metric, rate.law->model);
  if (!rate.fit)
    rate.problem = fmt::format("{} of {} points lie in the window, too few for a fit", window.size(), rate.points.size());
}

template <class Gather>
FittedRate make_rate(const Prediction& law, const SceneData& scene, const Configuration& first, bool alone,
                     const Gather& gather) {
  FittedRate rate;
  rate.law = &law;
  rate.scene = scene.name;
  rate.method = alone ? law.method : first.shown_integrator;
  rate.holds_noise = law.metric != "variance" && scene.reference &&
                     (!knows_variance(*scene.reference) || (!law.region.empty() && scene.reference->mse_floor > 0));
  try {
    rate.points = gather();
    fit_points(rate);
  } catch (const Error& e) {
    rate.problem = e.what();
  }
  return rate;
}

}  // namespace

std::vector<FittedRate> fit_rates(const ReportData& data) {
  std::vector<FittedRate> rates;
  for (const Prediction& law : data.log->stated.predictions)
    for (const SceneData& scene : data.scenes) {
      if (!law.is_exponent() || !data.log->stated.concerns(law, scene.name)) continue;
      const bool over_time = law.x == "time";
      const std::vector<const Configuration*> configurations = selected(scene, law.method, over_time);
      if (configurations.empty()) continue;
      const Gatherer gatherer(data, scene, law);
      if (law.across) {
        rates.push_back(make_rate(law, scene, *configurations.front(), true, [&] { return gatherer.ends(configurations); }));
        continue;
      }
      for (const Configuration* configuration : configurations) {
        rates.push_back(make_rate(law, scene, *configuration, configurations.size() == 1,
                                  [&] { return gatherer.checkpoints(*configuration); }));
        if (over_time && data.accels.size() > 1) rates.back().method = label(data, *configuration);
      }
    }
  return rates;
}

std::optional<MeasuredRate> measured_rate(const Configuration& configuration, const ReferenceRecord* reference) {
  const auto logged = [&](const char* metric) {
    return !configuration.replicates.empty() && configuration.replicates.front().last()->metrics.contains(metric);
  };
  const std::string metric = logged("mse") ? "mse" : "relmse";
  if (!logged(metric.c_str())) return std::nullopt;

  std::map<double, std::vector<double>> by_iteration;
  for (const Replicate& replicate : configuration.replicates) {
    const Curve curve = curve_of(replicate, metric, Abscissa::iterations);
    for (std::size_t i = 0; i < curve.x.size(); ++i) by_iteration[curve.x[i]].push_back(curve.y[i]);
  }
  const std::size_t replicates = configuration.replicates.size();
  std::erase_if(by_iteration, [&](const auto& entry) { return entry.second.size() != replicates; });
  if (by_iteration.size() < 3) return std::nullopt;
  const double middle = std::sqrt(by_iteration.begin()->first * by_iteration.rbegin()->first);
  while (by_iteration.size() > 3 && by_iteration.begin()->first < middle) by_iteration.erase(by_iteration.begin());

  const std::optional<double> floor = reference_noise(reference, metric);
  if (!floor) return std::nullopt;  // it would flatten the curve by nobody knows how much
  std::vector<RatePoint> points;
  for (const auto& [iterations, values] : by_iteration)
    points.push_back(diagonal_point(std::vector<double>(replicates, iterations), values, *floor));
  const auto fit = fit_rate(points, "mse", Prediction::Model::power);
  // Points that noise left above zero tell nothing of those below.
  return fit && fit->dropped == 0 ? std::optional(MeasuredRate{*fit, replicates, metric}) : std::nullopt;
}

}  // namespace etendue
