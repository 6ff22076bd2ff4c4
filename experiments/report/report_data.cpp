#include "experiments/report/report_data.h"

#include "experiments/report/method_names.h"
#include "experiments/report/reference_noise.h"
#include "experiments/report/report_text.h"
#include "framework/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace etendue {
namespace {

// Metrics with relmse first, then as metrics.h orders them by importance, then whatever else was logged.
std::vector<std::string> order_metrics(const std::set<std::string>& seen) {
  std::vector<std::string> ordered;
  for (const char* name : {"relmse", "mse", "trimmed_relmse", "smape", "flip", "bias"})
    if (seen.contains(name)) ordered.push_back(name);
  for (const std::string& name : seen)
    if (!contains(ordered, name)) ordered.push_back(name);
  // A signed figure cannot lead: its zero says nothing of noise.
  if (ordered.size() > 1 && ordered.front() == "bias") std::rotate(ordered.begin(), ordered.begin() + 1, ordered.end());
  return ordered;
}

// Until when the last value of the metric's curve is that of the image: a last image without a value has none to hold.
double held_until(const Replicate& replicate, const std::string& metric) {
  return replicate.last()->metrics.contains(metric) ? replicate.held_s : 0;
}

// Gives of one replicate what estimate_at gives of all.
std::optional<double> value_then(const Replicate& replicate, const std::string& metric, double time_s) {
  constexpr double slack = 1e-9;  // an average of equal times may differ from them in its last bits
  std::vector<const CheckpointRecord*> checkpoints = replicate.checkpoints;
  std::erase_if(checkpoints, [&](const CheckpointRecord* c) { return !c->metrics.contains(metric); });
  const auto next = std::ranges::upper_bound(checkpoints, time_s * (1 + slack), {}, &CheckpointRecord::time_s);
  if (next == checkpoints.begin()) return std::nullopt;
  const CheckpointRecord &a = **std::prev(next), &b = next == checkpoints.end() ? a : **next;
  if (&a == &b && time_s > std::max(a.time_s, held_until(replicate, metric)) * (1 + slack)) return std::nullopt;
  const auto first = static_cast<double>(a.iterations), last = static_cast<double>(b.iterations);
  const double share = &a == &b ? 0 : std::clamp((time_s - a.time_s) / (b.time_s - a.time_s), 0.0, 1.0);
  const double iterations = std::floor(first + share * (last - first) + slack);
  const double before = a.metrics.at(metric);
  return iterations <= first ? before : value_at({{first, last}, {before, b.metrics.at(metric)}}, iterations);
}

// When a run has the image of so many whole iterations.
double time_after(const Replicate& replicate, double iterations) {
  const auto count = [](const CheckpointRecord* checkpoint) { return static_cast<double>(checkpoint->iterations); };
  const auto next = std::ranges::lower_bound(replicate.checkpoints, iterations, {}, count);
  if (next == replicate.checkpoints.end()) return replicate.last()->time_s;
  if (next == replicate.checkpoints.begin()) return (*next)->time_s;
  const CheckpointRecord &a = **std::prev(next), &b = **next;
  return a.time_s + (iterations - count(&a)) / (count(&b) - count(&a)) * (b.time_s - a.time_s);
}

void set_common_time(SceneData& scene, const std::string& metric, bool with_sign) {
  double common = std::numeric_limits<double>::infinity();
  for (const Configuration& configuration : scene.configurations)
    for (const Replicate& replicate : configuration.replicates) {
      const Curve curve = curve_of(replicate, metric, Abscissa::time);
      if (!curve.empty()) common = std::min(common, std::max(curve.x.back(), held_until(replicate, metric)));
    }
  if (!std::isfinite(common)) return;
  scene.common_time_s = common;

  if (with_sign) return;
  std::vector<double> errors;
  for (const Configuration& configuration : scene.configurations)
    if (const auto estimate = estimate_at(configuration, metric, common)) errors.push_back(estimate->centre);
  const std::size_t half = (scene.finished().size() + 1) / 2;
  if (errors.size() < half) return;
  std::ranges::sort(errors);
  if (const double reached = errors[half - 1]; reached > 0) scene.target_error = round_up_nicely(reached);
}

void name_files(std::vector<SceneData>& scenes) {
  std::map<std::string, int> used;
  for (SceneData& scene : scenes) {
    const std::string stem = slug(scene.name);
    const int count = ++used[stem];
    scene.file_stem = stem;
    if (count > 1) scene.file_stem += "-" + std::to_string(count);
  }
}

SceneData& scene_of(ReportData& data, const std::string& name) {
  return find_or_add(data.scenes, [&](const SceneData& scene) { return scene.name == name; }, {.name = name});
}

Configuration& configuration_of(ReportData& data, const CellName& name) {
  const std::size_t integrator = index_in(data.integrators, name.integrator), accel = index_in(data.accels, name.accel);
  const auto same = [&](const Configuration& c) { return c.integrator_index == integrator && c.accel_index == accel; };
  return find_or_add(scene_of(data, name.scene).configurations, same,
                     {name.scene, name.integrator, name.accel, integrator, accel, {}, {}});
}

}  // namespace

std::vector<const Configuration*> SceneData::finished() const {
  std::vector<const Configuration*> found;
  for (const Configuration& configuration : configurations)
    if (!configuration.replicates.empty()) found.push_back(&configuration);
  return found;
}

std::vector<const Configuration*> ReportData::finished() const {
  std::vector<const Configuration*> found;
  for (const SceneData& scene : scenes)
    for (const Configuration* configuration : scene.finished()) found.push_back(configuration);
  return found;
}

std::vector<std::string> ReportData::noisy_references() const {
  std::vector<std::string> names;
  for (const SceneData& scene : scenes)
    if (scene.reference != nullptr && scene.reference->mse_floor > 0) names.push_back(scene.name);
  return names;
}

const CellRecord* Configuration::any_cell() const {
  for (const Replicate& replicate : replicates)
    if (replicate.cell != nullptr) return replicate.cell;
  return failures.empty() ? nullptr : failures.front();
}

ReportData arrange(const RunLog& log) {
  ReportData data;
  data.log = &log;
  std::map<std::string, double> budgets;  // by manifest
  for (const ManifestRecord& manifest : log.manifests) budgets[manifest.id] = manifest.budget_s;
  std::map<CellName, std::vector<const CheckpointRecord*>> checkpoints;
  std::set<std::string> metrics, phases, counters;
  for (const CheckpointRecord& record : log.checkpoints) {
    checkpoints[record.cell].push_back(&record);
    for (const auto& [name, value] : record.metrics) {
      metrics.insert(name);
      if (value < 0 || name == "bias") data.signed_metrics.insert(name);
    }
    for (const auto& [name, value] : record.phases_s) phases.insert(name);
    for (const auto& [name, value] : record.counters) counters.insert(name);
  }
  data.metrics = order_metrics(metrics);
  data.phases.assign(phases.begin(), phases.end());
  if (const auto other = std::ranges::find(data.phases, "other"); other != data.phases.end())
    std::rotate(other, other + 1, data.phases.end());
  data.counters.assign(counters.begin(), counters.end());

  for (const CellRecord& cell : log.cells) {
    Configuration& configuration = configuration_of(data, cell.cell);
    const auto found = checkpoints.find(cell.cell);
    if (cell.status != "done") {
      configuration.failures.push_back(&cell);
      ++data.failed;
      continue;
    }
    ++data.done;
    if (found == checkpoints.end()) continue;
    std::ranges::stable_sort(found->second, {}, &CheckpointRecord::iterations);
    const double held_s = budgets[found->second.back()->manifest];
    configuration.replicates.push_back({cell.cell.seed, &cell, std::move(found->second), held_s});
  }
  for (const StructureRecord& record : log.structures) scene_of(data, record.scene);
  for (SceneData& scene : data.scenes) {
    scene.reference = log.reference(scene.name);
    for (Configuration& configuration : scene.configurations) {
      std::ranges::stable_sort(configuration.replicates, {}, &Replicate::seed);
      data.most_seeds = std::max(data.most_seeds, configuration.replicates.size());
    }
    if (!data.empty()) set_common_time(scene, data.main_metric(), data.is_signed(data.main_metric()));
  }
  name_files(data.scenes);
  name_methods(data);
  return data;
}

const std::map<std::string, double>* metrics_in(const CheckpointRecord& checkpoint, const std::string& region) {
  if (region.empty()) return &checkpoint.metrics;
  const auto found = checkpoint.regions.find(region);
  return found == checkpoint.regions.end() ? nullptr : &found->second;
}

double logged_mse(const CheckpointRecord& checkpoint, const std::string& region) {
  const auto* metrics = metrics_in(checkpoint, region);
  if (metrics == nullptr) throw Error(fmt::format("region '{}' was not logged", region));
  if (const auto mse = find_value(*metrics, "mse")) return *mse;
  throw Error("mse was not logged");
}

double subtracted_variance(const SceneData& scene, const std::string& region) {
  return region.empty() && scene.reference != nullptr ? scene.reference->mse_floor : 0;
}

std::vector<const Configuration*> selected(const SceneData& scene, const std::string& method, bool each_structure) {
  std::vector<const Configuration*> configurations;
  std::set<std::size_t> seen;
  for (const Configuration* configuration : scene.finished())
    if (selects(method, configuration->integrator) && (each_structure || seen.insert(configuration->integrator_index).second))
      configurations.push_back(configuration);
  return configurations;
}

std::string label(const ReportData& data, const Configuration& configuration) {
  const Configuration& c = configuration;
  return data.accels.size() < 2 ? c.shown_integrator : c.shown_integrator + " · " + c.shown_accel;
}

std::string short_label(const ReportData& data, const Configuration& configuration) {
  const Configuration& c = configuration;
  return data.accels.size() < 2 ? c.short_integrator : c.short_integrator + " · " + c.short_accel;
}

Curve curve_of(const Replicate& replicate, const std::string& metric, Abscissa abscissa) {
  Curve curve;
  for (const CheckpointRecord* checkpoint : replicate.checkpoints) {
    const auto value = find_value(checkpoint->metrics, metric);
    const double x = abscissa == Abscissa::time ? checkpoint->time_s : static_cast<double>(checkpoint->iterations);
    if (!value || !(x > (curve.empty() ? 0 : curve.x.back()))) continue;
    curve.x.push_back(x);
    curve.y.push_back(*value);
  }
  return curve;
}

std::vector<double> values_at(const Configuration& configuration, const std::string& metric, double time_s) {
  std::vector<double> values;
  for (const Replicate& replicate : configuration.replicates)
    if (const auto value = value_then(replicate, metric, time_s)) values.push_back(*value);
  return values;
}

std::optional<Estimate> estimate_at(const Configuration& configuration, const std::string& metric, double time_s,
                                    bool with_sign) {
  const std::vector<double> values = values_at(configuration, metric, time_s);
  // An average over only those seeds that were early enough would favour them.
  if (values.empty() || values.size() < configuration.replicates.size()) return std::nullopt;
  return with_sign ? signed_estimate(values) : geometric_estimate(values);
}

std::optional<double> reference_noise(const ReferenceRecord* reference, const std::string& metric) {
  if (reference == nullptr || reference->mse_floor <= 0) return 0;
  if (metric == "mse") return reference->mse_floor;
  if (metric == "relmse" && reference->relmse_floor > 0) return reference->relmse_floor;
  return std::nullopt;
}

std::string noise_in_ratios(const ReportData& data) {
  bool has_noise = false, is_known = true, is_taken_off = false;
  for (const SceneData& scene : data.scenes) {
    const auto noise = reference_noise(scene.reference, data.main_metric());
    has_noise |= noise != 0.0;
    is_known &= noise.has_value();
    is_taken_off |= noise.value_or(0) > 0;
  }
  if (!has_noise) return "";
  std::string note;
  if (is_taken_off) note = noise_taken_off;
  if (!is_known)
    note += std::string(note.empty() ? "" : " ") +
            "Errors against references whose noise nobody knows hold it, which brings ratios nearer to 1.";
  return note;
}

std::optional<double> error_at(const SceneData& scene, const Configuration& configuration, const std::string& metric,
                               double time_s) {
  const auto estimate = estimate_at(configuration, metric, time_s);
  if (!estimate) return std::nullopt;
  const double noise = reference_noise(scene.reference, metric).value_or(0);
  return without_noise(estimate->centre, noise);
}

std::vector<double> final_values(const Configuration& configuration, const std::string& metric) {
  std::vector<double> values;
  for (const Replicate& replicate : configuration.replicates)
    if (const auto value = find_value(replicate.last()->metrics, metric)) values.push_back(*value);
  return values;
}

std::vector<SeriesPoint> aggregate(const Configuration& configuration, const std::string& metric, Abscissa abscissa,
                                   bool with_sign) {
  std::vector<Curve> curves;
  for (const Replicate& replicate : configuration.replicates)
    if (Curve curve = curve_of(replicate, metric, abscissa); !curve.empty()) curves.push_back(std::move(curve));
  if (curves.empty()) return {};
  const auto estimate = [&](const std::vector<double>& y) { return with_sign ? signed_estimate(y) : geometric_estimate(y); };

  double low = 0, high = std::numeric_limits<double>::infinity();
  std::size_t shared = std::numeric_limits<std::size_t>::max();
  for (const Curve& curve : curves) {
    low = std::max(low, curve.x.front());
    high = std::min(high, curve.x.back());
    shared = std::min(shared, curve.x.size());
  }
  std::vector<double> at(curves.size()), y(curves.size());
  if (!(low < high)) {  // no span that all seeds share: their last checkpoints as one point
    for (std::size_t i = 0; i < curves.size(); ++i) {
      at[i] = curves[i].x.back();
      y[i] = curves[i].y.back();
    }
    return {{geometric_mean(at), estimate(y)}};
  }
  std::vector<double> grid;
  for (std::size_t k = 0; k <= shared; ++k) {
    for (std::size_t i = 0; i < curves.size() && k < shared; ++i) at[i] = curves[i].x[k];
    const double x = k < shared ? std::clamp(geometric_mean(at), low, high) : high;
    if (grid.empty() || x > grid.back() * (1 + 1e-9)) grid.push_back(x);
  }
  std::vector<SeriesPoint> points;
  for (const double x : grid) {
    for (std::size_t i = 0; i < curves.size(); ++i) y[i] = value_at(curves[i], x).value_or(curves[i].y.back());
    points.push_back({x, estimate(y)});
  }
  return points;
}

std::optional<ArrivalMedian> arrival_of(const Configuration& configuration, const std::string& metric, double target) {
  std::vector<Arrival> arrivals;
  for (const Replicate& replicate : configuration.replicates)
    if (const Curve curve = curve_of(replicate, metric, Abscissa::iterations); !curve.empty()) {
      Arrival& arrival = arrivals.emplace_back(time_to(curve, target));
      arrival.time = time_after(replicate, std::ceil(arrival.time - 1e-9));
    }
  if (arrivals.empty() || target <= 0) return std::nullopt;
  return median_arrival(arrivals);
}

std::vector<FrontPoint> front_points(const SceneData& scene, const std::string& metric, bool with_sign) {
  std::vector<FrontPoint> points;
  std::vector<dvec2> positions;
  for (std::size_t c = 0; c < scene.configurations.size(); ++c)
    for (const SeriesPoint& point : aggregate(scene.configurations[c], metric, Abscissa::time, with_sign)) {
      const double error = with_sign ? std::abs(point.y.centre) : point.y.centre;
      points.push_back({c, point.x, error, false});
      positions.emplace_back(point.x, error);
    }
  for (const std::size_t i : pareto_front(positions)) points[i].on_front = true;
  return points;
}

std::vector<LeadInterval> lead_intervals(const SceneData& scene, const std::string& metric) {
  std::set<double> times;
  for (const Configuration& configuration : scene.configurations)
    for (const SeriesPoint& point : aggregate(configuration, metric, Abscissa::time, false)) times.insert(point.x);
  std::vector<LeadInterval> result;
  for (const double time : times) {
    if (time > scene.common_time_s * (1 + 1e-9)) break;  // beyond it runs have ended that might have gone on
    std::size_t leader = scene.configurations.size();
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < scene.configurations.size(); ++c)
      if (const auto error = estimate_at(scene.configurations[c], metric, time); error && error->centre < least) {
        least = error->centre;
        leader = c;
      }
    if (leader == scene.configurations.size() || (!result.empty() && result.back().configuration == leader)) continue;
    result.push_back({leader, time});
  }
  return result;
}

}  // namespace etendue
