#include "experiments/run/run_cell.h"

#include "accel/registry.h"
#include "accel/scene/auto_structure.h"
#include "experiments/report/declared.h"
#include "experiments/run/memory_forecast.h"
#include "framework/core/check.h"
#include "framework/core/counters.h"
#include "framework/core/memory.h"
#include "framework/core/parallel.h"
#include "framework/image/metrics.h"
#include "integrators/choice/auto.h"
#include "integrators/registry.h"
#include "integrators/warnings/coinciding.h"
#include "integrators/warnings/mixed_surfaces.h"
#include "integrators/warnings/out_of_reach.h"
#include "integrators/warnings/seldom_lights.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>

namespace etendue {

namespace {

constexpr double progress_interval_s = 0.1;

// Memory that earlier cells left goes back to the system, and the kernel's high-water mark of this process starts anew (Linux;
// where it cannot be reset, the peak is that of the run).
void reset_peak_memory() {
  release_freed_memory();
  std::ofstream("/proc/self/clear_refs") << "5";
}

bool is_finite(const Image& image) {
  return std::ranges::all_of(image.pixels, [](const dvec3& p) { return std::isfinite(p.x + p.y + p.z); });
}

// Measures an image's error by the metrics asked for, and that of parts of it. A value that is not finite (from an image full
// of overflow) is left out: a log cannot hold it.
class Measurement {
 public:
  Measurement(const Image& image, const Image& reference, const std::vector<std::string>& metrics)
      : image_(image), reference_(reference) {
    for (const std::string& name : metrics) {
      const Metric* metric = find_metric(name);
      CHECK(metric != nullptr);
      metrics_.push_back(metric);
      if (metric->errors && is_finite(image)) errors_[name] = metric->errors(image, reference);
    }
  }

  std::map<std::string, double> of_image() const {
    return values(image_, reference_, [](const std::vector<double>& errors) { return mean_of(errors); });
  }
  std::map<std::string, double> of(const Region& region) const {
    return values(crop(image_, region), crop(reference_, region), [&](const std::vector<double>& errors) {
      return mean_of(mapped(region.pixels, [&](std::size_t pixel) { return errors[pixel]; }));
    });
  }

 private:
  template <class Mean>
  std::map<std::string, double> values(const Image& image, const Image& reference, const Mean& mean) const {
    std::map<std::string, double> found;
    for (const Metric* metric : metrics_) {
      const std::string name(metric->name);
      const auto errors = errors_.find(name);
      if (metric->errors && errors == errors_.end()) continue;
      const double value = metric->errors ? mean(errors->second) : metric->compute(image, reference);
      if (std::isfinite(value)) found[name] = value;
    }
    return found;
  }

  const Image &image_, &reference_;
  std::vector<const Metric*> metrics_;
  std::map<std::string, std::vector<double>> errors_;  // of each pixel, of metrics that have them
};

class CellRunner {
 public:
  explicit CellRunner(const CellTask& task) : task_(task), film_(task.resolution), schedule_(task.budget) {}

  CellResult run() {
    reset_counters();
    reset_peak_memory();
    clock_.start();
    std::unique_ptr<RayQuery> rays;
    std::optional<LightSampler> lights;
    {
      const auto building = phases_.measure("build");
      const Method accel = structure();
      rays = find_ray_structure(accel.name, accel.where).make(task_.scene, accel.params);
      result_.fallback = rays->fallback;
      lights.emplace(task_.scene);
    }
    if (task_.live) {
      sampled_.emplace(*rays);
      window_.emplace(task_.scene);
    }
    const auto& entry = find_integrator(task_.integrator.name, task_.integrator.where);
    const auto integrator = entry.make(task_.integrator.params);
    const RayQuery& asked = sampled_ ? *sampled_ : *rays;
    RenderContext context = context_of(task_.scene, task_.needs, asked, *lights, task_.seed, task_.resolution, phases_);
    context.states_error = task_.confidence;
    context.effort = effort();
    context.window = task_.window;
    if (task_.before_prepare) task_.before_prepare(*integrator, context);
    integrator->prepare(context);
    fail_over_memory(iterations_);
    if (const MethodChoice* choice = integrator->choice()) {
      result_.chosen = Method{choice->name, choice->params};
      result_.why = choice->why;
    }
    iterate(*integrator, context);
    clock_.stop();
    result_.expectation = integrator->expectation();
    result_.image = film_.mean();
    if (const auto& [begin, end] = task_.window; end != ivec2(0)) result_.image = part_of(result_.image, begin, end);
    result_.image_hash = hash_of(result_.image);
    result_.non_finite = film_.non_finite();
    if (task_.finished) task_.finished(*integrator, context, result_);
    if (task_.looks_for_left_out) look_for_left_out(context);
    return std::move(result_);
  }

 private:
  void look_for_left_out(const RenderContext& context) {
    const Method used = result_.chosen.value_or(task_.integrator);
    std::vector<std::string>& told = result_.out_of_reach;
    const auto tell = [&told](std::string text) {
      if (!text.empty()) told.push_back(std::move(text));
    };
    // Pilots choose lights in their own way, after which nothing tells how the method chose them.
    std::string seldom = lights_seldom_chosen(context, used.name);
    tell(light_out_of_reach(context, used.name, used.params));
    const bool said = used.name == "bdpt" && !told.empty();  // both say the same of it
    if (const std::string& left_out = result_.expectation.left_out; !left_out.empty() && !said)
      tell(fmt::format("{}: {}", used.name, left_out));
    tell(surfaces_mixed(context, used.name, used.params));
    tell(surfaces_coincide(context));
    tell(lights_coincide(context));
    tell(std::move(seldom));
  }

  Effort effort() const { return task_.effort.value_or(effort_of(task_.budget)); }

  // The one asked for; in the place of `auto` the one that suits the rays that the budget lets a method trace.
  Method structure() {
    Method accel = task_.accel;
    if (accel.name != "auto" || accel.params.contains("rays")) return accel;
    const Effort chosen_for = effort_chosen_for(task_.integrator.name, task_.integrator.params, effort());
    MethodChoice choice = structure_for(task_.scene, task_.resolution, chosen_for);
    accel.name = choice.name;
    for (auto& [key, value] : choice.params) accel.params[key] = std::move(value);
    result_.chosen_accel = accel;
    result_.accel_why = std::move(choice.why);
    return accel;
  }

  void iterate(Integrator& integrator, RenderContext& context) {
    mark_live();
    for (bool last = false; !last;) {
      const double before = clock_.wall_s();
      integrator.iteration(context, static_cast<std::uint32_t>(iterations_), film_);
      const double now = clock_.wall_s();
      ++iterations_;
      fail_over_memory(iterations_);
      mark_live();
      const bool done = schedule_.finished(iterations_, now, now - before);
      result_.stopped = !done && task_.stop && task_.stop();
      last = done || result_.stopped;
      const bool due = schedule_.checkpoint_due(iterations_, now);
      const bool error_due = schedule_.error_due(iterations_);
      if (!last && !due && !error_due && now - told_s_ < progress_interval_s) continue;
      clock_.stop();
      if (error_due || (last && task_.budget.error)) {
        result_.reached_error = error_reached();
        last = last || result_.reached_error;
        result_.stopped = result_.stopped && !result_.reached_error;
      }
      if (last || due) checkpoint(integrator);
      if (task_.live) task_.live(live_figures());
      if (task_.progress) task_.progress(iterations_, clock_.wall_s());
      if (task_.preview) task_.preview(film_);
      told_s_ = now;
      clock_.start();
    }
  }

  void mark_live() {
    if (window_) window_->mark(clock_.wall_s(), read_counters(), sampled_->work());
  }

  // The error is measured anew when that would take a twentieth of the time since.
  LiveFigures live_figures() {
    LiveFigures figures = window_->figures();
    if (task_.reference && now_s() >= next_live_error_s_) {
      const double took = seconds_of([&] { live_error_ = relmse(film_.mean(), *task_.reference); });
      next_live_error_s_ = now_s() + 20 * took;
    }
    figures.error = live_error_;
    return figures;
  }

  bool error_reached() const {
    CHECK(task_.reference != nullptr);
    return relmse(film_.mean(), *task_.reference) <= *task_.budget.error;
  }

  // The clock is stopped meanwhile.
  void checkpoint(Integrator& integrator) {
    CheckpointRecord record;
    record.iterations = iterations_;
    record.time_s = clock_.wall_s();
    record.cpu_s = clock_.cpu_s();
    record.peak_memory_bytes = peak_memory_bytes();  // before the metrics take their own
    record.phases_s = phases_.seconds();
    double other = record.time_s;
    for (const auto& [phase, seconds] : record.phases_s) other -= seconds;
    record.phases_s["other"] = std::max(0.0, other);
    const CounterValues counters = read_counters();
    for (std::size_t i = 0; i < counter_count; ++i)
      record.counters[std::string(counter_name(static_cast<Counter>(i)))] = counters[i];
    record.non_finite = film_.non_finite_count();
    Image image = film_.mean();
    if (task_.reference) {
      const Measurement measurement(image, *task_.reference, task_.metrics);
      record.metrics = measurement.of_image();
      if (task_.confidence && integrator.cache())
        record.confidence = confidence_of(image, integrator.cache()->standard_error(), *task_.reference);
      for (const Region& region : task_.regions) record.regions[region.name] = measurement.of(region);
      if (!task_.regions.empty()) count_records(integrator, record);
    }
    if (task_.keep_images) result_.checkpoint_images.push_back(std::move(image));
    result_.checkpoints.push_back(std::move(record));
  }

  // Counts how many of a cache's records lie in each region; those on its border belong to what lies beside it too.
  void count_records(Integrator& integrator, CheckpointRecord& record) const {
    if (!integrator.cache()) return;
    const auto shapes = integrator.cache()->record_shapes();
    for (const Region& region : task_.regions)
      record.regions[region.name]["records"] = static_cast<double>(std::ranges::count_if(shapes, [&](const auto& shape) {
        const auto seen = task_.scene.camera.connect(task_.resolution, shape.position, vec2(0.5f));
        return seen && region.holds(ivec2(seen->film), task_.resolution);
      }));
  }

  const CellTask& task_;
  Film film_;
  BudgetSchedule schedule_;
  PhaseTimes phases_;
  RunClock clock_;
  CellResult result_;
  std::uint64_t iterations_ = 0;
  double told_s_ = 0;
  std::optional<SampledRays> sampled_;  // these of a cell that is watched
  std::optional<LiveWindow> window_;
  std::optional<double> live_error_;
  double next_live_error_s_ = 0;
};

}  // namespace

RenderContext context_of(const Scene& scene, const SceneNeeds& needs, const RayQuery& rays, LightSampler& lights,
                         std::uint64_t seed, ivec2 resolution, PhaseTimes& phases) {
  const auto points = [](const std::string& name) { return find_point_structure(name, {}).make(); };
  const auto records = [](const std::string& name, const Bounds& bounds) {
    return find_record_structure(name, {}).make(bounds);
  };
  return {scene, needs, rays, lights, seed, resolution, phases, points, records};
}

MethodChoice structure_for(const Scene& scene, ivec2 resolution, const Effort& effort) {
  const double pixels = static_cast<double>(resolution.x) * resolution.y;
  return choose_structure(scene, pixels * rays_before_paths(scene, effort, resolution));
}

Effort effort_of(const Budget& budget) {
  return {budget.time_s.value_or(0), budget.samples.value_or(0), budget.error.value_or(0)};
}

void require_room_for_image(const std::string& scene, ivec2 resolution, int copies) {
  constexpr double most = 1 << 28;
  const Location where{fmt::format("{}{}{} x {} pixels", scene, scene.empty() ? "" : " at ", resolution.x, resolution.y)};
  const double pixels = static_cast<double>(resolution.x) * resolution.y;
  if (pixels > most) throw Error(where, fmt::format("expected {:.0f} pixels (16384 x 16384) in all at most", most));
  require_memory(pixels * (sizeof(dvec3) + sizeof(double) + static_cast<double>(copies) * sizeof(dvec3)), where,
                 "the image, with the sums it is made of,", "fewer pixels, or more memory");
}

CellResult run_cell(const CellTask& task) {
  refuse_over_memory(task.scene.name, task.scene, task.needs, task.accel, task.integrator, task.resolution);
  require_room_for_image(task.scene.name, task.resolution, 2);
  require_room_for_photons(task.needs, task.integrator, task.resolution);
  CellResult result;
  with_threads(task.threads, [&] { result = CellRunner(task).run(); });
  return result;
}

std::string_view bias_name(Bias bias) {
  constexpr std::string_view names[] = {"unbiased", "consistent", "biased"};
  return names[static_cast<std::size_t>(bias)];
}

}  // namespace etendue
