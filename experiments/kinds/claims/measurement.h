// Measurements that test claims: works that take turns on one scene, and figures that are ratios of their times, or counts.
//
// A claim expects some of a measurement's figures to lie in an interval; experiments/statistics/verdict.h compares the two.
// Variants of the product's code and scenes that only claims need are in this folder.
#pragma once

#include "accel/registry.h"
#include "experiments/kinds/timing.h"
#include "experiments/statistics/verdict.h"
#include "framework/core/error.h"
#include "framework/io/scene_files.h"
#include "framework/scene/scene.h"

#include <deque>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace etendue {

struct Quantity {
  std::string name;  // as an experiment's `expect` names it
  FigureKind kind = FigureKind::factor;
  std::string text;  // what it is, for a table
  // Which works' times: that of the one over that of the other, or, without `over`, its own. Without both the figure is
  // counted. A work on a structure is called as that is: "binned-sah layout=bvh16".
  std::string time = {}, over = {};
};

struct MeasureTask {
  std::string scene;     // as load_claim_scene takes it
  int resolution = 256;  // about resolution^2 rays of a kind
  int repetitions = 9;   // interleaved, of which medians and quartiles are taken
  int threads = 1;       // of a measurement that is parallel
  std::uint64_t seed = 1;
  std::function<void(double share)> progress = [](double) {};
  SceneReading reading = {};
};

struct MeasureResult {
  std::vector<std::pair<std::string, Measured>> figures;  // by quantity; those of works that did not run are left out
  std::vector<std::string> remarks;                       // what a reader of the figures must know
  std::uint64_t disagreements = 0;                        // answers of a variant that are not the product's
};

// The rays on which variants are compared: primary and diffuse ones ask for the closest hit, shadow rays for any.
struct TrialRays {
  std::vector<Ray> closest, shadow;

  std::size_t size() const { return closest.size() + shadow.size(); }
};

// A work that takes part, and what quantities call it.
struct Contender {
  std::string name;
  TimedWork work;
};

// One measurement on one scene, while it is made.
class Trial {
 public:
  Trial(const MeasureTask& of, const std::vector<Quantity>& wanted);

  const MeasureTask task;
  const Scene scene;

  // The works that quantities speak of, each once.
  const std::vector<std::string>& works() const { return works_; }

  // Contenders take turns; their times are kept under their names.
  void race(const std::vector<Contender>& contenders, int repetitions);
  void race(const std::vector<Contender>& contenders) { race(contenders, task.repetitions); }
  void add_time(const std::string& name, double seconds) { times_[name].push_back(seconds); }
  // Times of a sample, scaled to the whole.
  void scale(const std::string& name, double factor);
  Measured time(const std::string& name) const { return summarise(times_.at(name)); }
  Measured ratio(const std::string& name, const std::string& over) const;  // repetition by repetition

  void count(const std::string& quantity, const Measured& value) { counts_[quantity] = value; }
  void count(const std::string& quantity, double value) { count(quantity, {value, value, value}); }
  void remark(std::string text) { remarks_.push_back(std::move(text)); }
  void disagree(std::uint64_t answers) { disagreements_ += answers; }

  // Makes a structure over the scene by its label, "binned-sah bins=16"; it lives as long as the trial.
  const RayQuery& make(const std::string& label);
  // All works are of structures, which trace these rays.
  void race_structures(const TrialRays& rays);
  // Recorded from a render of the scene (accel_rays.h), about resolution^2 of each kind.
  TrialRays record_rays(int resolution) const;
  TrialRays record_rays() const { return record_rays(task.resolution); }

  // Counts the rays for which closest(ray) gives another distance or primitive than the product's structure.
  template <class Closest>
  void hold_to(const RayQuery& product, const std::vector<Ray>& rays, const Closest& closest) {
    for (const Ray& ray : rays) {
      const Hit a = product.closest(ray), b = closest(ray);
      disagree(a.t != b.t || a.primitive != b.primitive || a.instance != b.instance);
    }
  }

  MeasureResult finish() const;

 private:
  const std::vector<Quantity>& quantities_;
  std::vector<std::string> works_;
  std::deque<std::unique_ptr<RayQuery>> structures_;
  std::map<std::string, std::vector<double>> times_;
  std::map<std::string, Measured> counts_;
  std::vector<std::string> remarks_;
  std::uint64_t disagreements_ = 0;
};

struct Measurement {
  std::string name, summary;
  std::vector<Quantity> quantities;
  std::function<void(Trial&)> measure;
  bool parallel = false;  // runs its loops on MeasureTask::threads; others get one thread

  MeasureResult run(const MeasureTask& task) const;
  const Quantity* quantity(std::string_view quantity_name) const;
};

std::span<const Measurement> measurements();
const Measurement& find_measurement(const std::string& name, const Location& where);  // throws Error

// Each file gives its rows of the table.
std::vector<Measurement> builder_measurements();    // which tree
std::vector<Measurement> traversal_measurements();  // how it is traversed
std::vector<Measurement> change_measurements();     // what becomes of it
std::vector<Measurement> space_measurements();      // trees of boxes against cells of space
std::vector<Measurement> object_measurements();     // cylinders, rotated objects
std::vector<Measurement> image_measurements();      // whole images: seconds
std::vector<Measurement> task_measurements();       // images cut into tasks
std::vector<Measurement> sampling_measurements();   // directions, caches
std::vector<Measurement> content_measurements();    // what a scene is spared that lacks a thing
std::vector<Measurement> coarse_measurements();     // what indirect rays gain from coarser meshes

// --- works ---

// Reads "bins=16 leaf_size=2" as parameters.
ParamMap params_of(const std::string& text);

// Keeps at most `count` of the rays, evenly spread.
std::vector<Ray> every_nth(const std::vector<Ray>& rays, std::size_t count);

// Finds the closest hit of each ray by a function of it.
template <class Closest>
TimedWork tracing(const std::vector<Ray>& rays, Closest closest) {
  return timed([&rays, closest] {
    float sum = 0;
    for (const Ray& ray : rays) sum += closest(ray).t < infinity;
    keep_answer(sum);
  });
}

// Traces all of the rays through a structure.
template <class Structure>
void trace_rays(const Structure& structure, const TrialRays& rays) {
  float sum = 0;
  for (const Ray& ray : rays.closest) sum += structure.closest(ray).t < infinity;
  for (const Ray& ray : rays.shadow) sum += structure.occluded(ray);
  keep_answer(sum);
}
template <class Structure>
TimedWork tracing_all(const Structure& structure, const TrialRays& rays, Clock clock = Clock::wall) {
  return timed([&structure, &rays] { trace_rays(structure, rays); }, clock);
}

// Keeps as many of them, evenly spread, as take about so long, at least 64 of each kind: some variants would take minutes.
template <class Structure>
TrialRays affordable_sample(const Structure& structure, const TrialRays& rays, double seconds) {
  constexpr std::size_t least = 64;
  const TrialRays trial{every_nth(rays.closest, least), every_nth(rays.shadow, least)};
  const double trial_s = seconds_of([&] { trace_rays(structure, trial); });
  const double share =
      std::max(1.0, seconds / trial_s) * least / static_cast<double>(std::max<std::size_t>(1, rays.closest.size()));
  const auto of = [&](const std::vector<Ray>& all) {
    return every_nth(all, static_cast<std::size_t>(std::ceil(share * static_cast<double>(all.size()))));
  };
  return {of(rays.closest), of(rays.shadow)};
}

}  // namespace etendue
