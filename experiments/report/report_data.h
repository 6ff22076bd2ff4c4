// A log arranged for reading: scenes, the configurations tried on each (integrator and structure, every parameter fixed), their
// seeds as replicates, and what statistics say of them. Tables, charts and the page are all drawn from this.
#pragma once

#include "experiments/log/log.h"
#include "experiments/statistics/statistics.h"

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace etendue {

enum class Abscissa : std::uint8_t { time, iterations };

struct Replicate {
  std::uint64_t seed = 0;
  const CellRecord* cell = nullptr;
  std::vector<const CheckpointRecord*> checkpoints;  // by iterations
  // The time that ended it: it stopped before an iteration that would not fit, and has its last image until then.
  double held_s = 0;

  const CheckpointRecord* last() const { return checkpoints.empty() ? nullptr : checkpoints.back(); }
};

struct Configuration {
  std::string scene, integrator, accel;
  std::size_t integrator_index = 0, accel_index = 0;  // over the whole log, in order of first appearance: colour and dash
  std::vector<Replicate> replicates;                  // cells that are done and have a checkpoint, by seed
  std::vector<const CellRecord*> failures;
  // The names that reports give them, and those of charts (method_names.h).
  std::string shown_integrator = {}, shown_accel = {}, short_integrator = {}, short_accel = {};

  const CellRecord* any_cell() const;
};

struct SceneData {
  std::string name = {};
  std::string file_stem = {};  // unique among scenes
  const ReferenceRecord* reference = nullptr;
  std::vector<Configuration> configurations = {};
  // The latest time until which every replicate ran, or its budget of time lasted; 0: nothing finished.
  double common_time_s = 0;
  double target_error = 0;  // of the main metric: what at least half of the configurations reach by the common time; 0: none

  std::vector<const Configuration*> finished() const;  // those that have a replicate
};

struct ReportData {
  const RunLog* log = nullptr;
  std::vector<std::string> metrics;      // the main one first
  std::set<std::string> signed_metrics;  // bias, and any of which a negative value was seen: averaged as they are
  std::vector<std::string> integrators, accels, phases, counters;
  std::vector<std::string> shown_accels, left_out_of_names;  // method_names.h
  std::vector<SceneData> scenes;
  std::size_t done = 0, failed = 0, most_seeds = 0;
  std::vector<std::string> findings;   // what is missing or not to be believed (trust.h); the reader of the files' to fill
  std::vector<std::string> conflicts;  // scenes whose merged logs are of several versions or references; the merger's to fill

  std::vector<const Configuration*> finished() const;  // of all scenes
  bool empty() const { return metrics.empty(); }
  const std::string& main_metric() const { return metrics.front(); }  // relmse where it was logged
  bool is_signed(const std::string& metric) const { return signed_metrics.contains(metric); }
  // The scenes whose references have noise of their own, which is part of every error.
  std::vector<std::string> noisy_references() const;
};

// Keeps pointers into `log`.
ReportData arrange(const RunLog& log);

// Gives the metrics that a checkpoint logged of a region (empty: of the whole image); null where it did not.
const std::map<std::string, double>* metrics_in(const CheckpointRecord& checkpoint, const std::string& region);
// Throws Error where it was not logged.
double logged_mse(const CheckpointRecord& checkpoint, const std::string& region);
// The reference's own variance, which is known for the image as a whole; of a region it is left in.
double subtracted_variance(const SceneData& scene, const std::string& region);

// The configurations that a prediction's method selects and that have replicates; of several structures the first says it all,
// since structures change only the time, unless each is asked for.
std::vector<const Configuration*> selected(const SceneData& scene, const std::string& method, bool each_structure);

// "integrator" alone where the log has one structure, else "integrator · structure"; and shorter, for charts.
std::string label(const ReportData& data, const Configuration& configuration);
std::string short_label(const ReportData& data, const Configuration& configuration);

// One replicate's metric; checkpoints at time 0, out of order or without the metric are left out.
Curve curve_of(const Replicate& replicate, const std::string& metric, Abscissa abscissa);

// The part of every value of a metric that is the reference's noise; nullopt where nobody knows it.
std::optional<double> reference_noise(const ReferenceRecord* reference, const std::string& metric);

// Tells people, beneath ratios of errors, what became of the noise of references; "" where they have none.
std::string noise_in_ratios(const ReportData& data);

// The estimate that estimate_at gives, for ratios: without the noise of the scene's reference where that is known of the
// metric. The rest counts as a tenth of that noise at least, as its own estimate is not exact either.
std::optional<double> error_at(const SceneData& scene, const Configuration& configuration, const std::string& metric,
                               double time_s);

// The metric over replicates at a time, of the image that each has then: that of its last whole iteration. Between checkpoints
// iterations are taken as equally long, and the metric as linear over them on log-log axes. There is none before a replicate's
// first checkpoint, or after its last and its budget.
std::optional<Estimate> estimate_at(const Configuration& configuration, const std::string& metric, double time_s,
                                    bool with_sign = false);
// Gives the metric of each replicate there; fewer than the replicates where some have no value.
std::vector<double> values_at(const Configuration& configuration, const std::string& metric, double time_s);
// Gives the metric of each replicate's last checkpoint.
std::vector<double> final_values(const Configuration& configuration, const std::string& metric);

// Makes the configuration's curve over all its seeds. Vertices lie at the checkpoints (averaged over seeds); each seed is
// interpolated there, so no seed is read outside what it measured.
struct SeriesPoint {
  double x = 0;
  Estimate y;
};
std::vector<SeriesPoint> aggregate(const Configuration& configuration, const std::string& metric, Abscissa abscissa,
                                   bool with_sign);

// When the configuration's seeds reach the scene's target error, which takes whole iterations.
std::optional<ArrivalMedian> arrival_of(const Configuration& configuration, const std::string& metric, double target);

// Every checkpoint of every configuration as (time, error), and which of them nothing beats; of a metric with a sign the error
// is the mean's magnitude.
struct FrontPoint {
  std::size_t configuration = 0;
  double time_s = 0, error = 0;
  bool on_front = false;
};
std::vector<FrontPoint> front_points(const SceneData& scene, const std::string& metric, bool with_sign = false);

// `configuration` has the least error from `begin_s` on, until the next one has: of the images that they have then.
struct LeadInterval {
  std::size_t configuration = 0;
  double begin_s = 0;
};
std::vector<LeadInterval> lead_intervals(const SceneData& scene, const std::string& metric);

}  // namespace etendue
