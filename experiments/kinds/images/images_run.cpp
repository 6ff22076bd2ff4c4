#include "experiments/kinds/images/images_run.h"

#include "experiments/kinds/structures/accel_comparison.h"
#include "experiments/log/products.h"
#include "experiments/log/trust.h"
#include "experiments/report/report.h"
#include "experiments/run/memory_forecast.h"
#include "experiments/run/recipe.h"
#include "experiments/run/run_directory.h"
#include "experiments/run/run_reference.h"
#include "framework/core/parallel.h"

#include <fmt/format.h>
#include <algorithm>
#include <memory>
#include <set>

namespace etendue {

namespace {

struct LoadedScene {
  Scene scene;
  SceneNeeds needs;
  ivec2 resolution{0};
  std::vector<Region> regions;
  Reference reference;
};

class Execution {
 public:
  Execution(const RunPlan& plan, RunObserver& observer, const CellFunction& compute)
      : compute_(compute),
        plan_(plan),
        config_(plan.config),
        observer_(observer),
        manifest_(plan_manifest(plan, plan.threads)),
        directory_(plan.directory, manifest_, plan_record(plan, manifest_), plan.fresh, observer),
        scenes_(config_.scenes.size()) {}

  RunSummary run() {
    load_scenes();
    choose_pending();
    StatedRecord stated{config_.predictions, config_.regions, config_.elsewhere};
    for (const auto* methods : {&config_.accels, &config_.integrators})
      for (const Method& method : *methods)
        if (!method.shown_as.empty()) stated.labels[method.label()] = method.shown_as;
    if (const std::string line = to_json_line(stated); line != to_json_line(directory_.earlier().stated))
      directory_.append({line});
    for (std::size_t s = 0; s < scenes_.size(); ++s)
      if (wants_structures(s)) compare_scene_structures(s);
    for (std::size_t i = 0; i < pending_.size(); ++i) run_one(*pending_[i], i);
    log_products();
    directory_.finish();
    report_run(plan_, summary_);
    return std::move(summary_);
  }

 private:
  bool has_cells(std::size_t scene) const {
    return std::ranges::any_of(plan_.cells, [&](const Cell& cell) { return cell.scene == scene; });
  }

  // Cells that an earlier run ended are left out where they are still what it logged: made of the same scene, measured
  // against the same reference, their files whole.
  void choose_pending() {
    const std::set<CellName> whole = directory_.believed_cells();
    for (std::size_t s = 0; s < scenes_.size(); ++s)
      if (scenes_[s] && has_cells(s) && wants_reference(s, whole)) make_scene_reference(s);
    // A reference that is another took its scene's cells out of the log.
    std::set<CellName> logged;
    for (const CellRecord& cell : directory_.earlier().cells) logged.insert(cell.cell);
    for (const Cell& cell : plan_.cells) {
      if (whole.contains(cell.name) && logged.contains(cell.name))
        ++summary_.skipped;
      else
        pending_.push_back(&cell);
    }
    narrate_resumption();
    for (std::size_t s = 0; s < scenes_.size(); ++s)
      if (std::ranges::none_of(pending_, [&](const Cell* cell) { return cell->scene == s; }) && !wants_structures(s))
        scenes_[s].reset();
  }

  bool wants_reference(std::size_t s, const std::set<CellName>& whole) {
    const ReferenceRecord* known = directory_.earlier().reference(config_.scenes[s].name);
    if (known == nullptr || config_.reference.kind == ReferenceChoice::Kind::file) return true;
    if (!damage(*known, plan_.directory).empty()) return true;
    return std::ranges::any_of(plan_.cells, [&](const Cell& cell) { return cell.scene == s && !whole.contains(cell.name); });
  }

  bool wants_structures(std::size_t scene) const {
    return config_.structures && in_shard(scene, plan_.shard) &&
           !directory_.has_structures(config_.scenes[scene].name,
                                      config_.accels.size() * std::max<std::size_t>(1, structure_isas().size()));
  }

  // Those that this machine has; empty: the chosen one alone.
  std::vector<Isa> structure_isas() const {
    std::vector<Isa> isas = config_.structures->isas;
    std::erase_if(isas, [](Isa isa) { return !is_supported(isa); });
    return isas;
  }

  void narrate_resumption() {
    narrate_skipped(plan_, summary_.skipped, observer_);
    for (const ManifestRecord& other : directory_.earlier().manifests)
      if (other.commit != manifest_.commit || other.cpu != manifest_.cpu || other.cpu_family != manifest_.cpu_family ||
          other.cpu_model != manifest_.cpu_model || other.isa != manifest_.isa || other.flags != manifest_.flags)
        observer_.narrate(fmt::format("{}: some cells were run by {} on {} with {}; --fresh runs all of them alike",
                                      plan_.directory, other.commit, other.cpu, other.isa));
  }

  // All of them before anything runs, so that a file that cannot be read is known at once, and so is one that has changed.
  void load_scenes() {
    for (std::size_t s = 0; s < scenes_.size(); ++s) {
      if (!has_cells(s) && !wants_structures(s)) continue;
      const SceneChoice& choice = config_.scenes[s];
      auto loaded = std::make_unique<LoadedScene>();
      loaded->scene = load_choice(plan_, choice, observer_);
      loaded->needs = scene_needs(loaded->scene);
      loaded->resolution = config_.resolution.value_or(loaded->scene.resolution);
      loaded->regions = make_regions(config_.regions, choice.name, loaded->resolution);
      scenes_[s] = std::move(loaded);
    }
    for (const Cell& cell : plan_.cells)
      if (const auto& loaded = scenes_[cell.scene])
        refuse_over_memory(cell.name.key(), loaded->scene, loaded->needs, config_.accels[cell.accel],
                           config_.integrators[cell.integrator], loaded->resolution);
    for (std::size_t s = 0; s < scenes_.size(); ++s) {
      if (!scenes_[s]) continue;
      const SceneChoice& choice = config_.scenes[s];
      directory_.note_scene(choice.name, choice.path, scenes_[s]->scene.hash(), plan_.reading.pixel_filter);
    }
  }

  void make_scene_reference(std::size_t s) {
    LoadedScene& loaded = *scenes_[s];
    const std::string& name = config_.scenes[s].name;
    loaded.reference = make_run_reference(
        directory_,
        {loaded.scene, loaded.needs, name, loaded.resolution, config_.reference.of_scene(s), plan_.threads, &observer_},
        ReferenceCache::standard(config_.path));
  }

  void compare_scene_structures(std::size_t s) {
    const std::string& name = config_.scenes[s].name;
    StructureTiming options = *config_.structures;
    options.threads = plan_.threads;
    options.isas = structure_isas();
    for (const Isa isa : config_.structures->isas)
      if (!is_supported(isa))
        warn_once(fmt::format("structures are not timed with {}, which this machine lacks", isa_name(isa)));
    observer_.narrate(fmt::format("{}: timing {} structures", name, config_.accels.size()));
    const auto status = [&](const std::string& line) { observer_.status(name + ": " + line); };
    std::vector<StructureRecord> records;
    with_threads(plan_.threads, [&] { records = compare_structures(scenes_[s]->scene, config_.accels, options, status); });
    std::vector<std::string> lines;
    for (StructureRecord& record : records) {
      record.scene = name;
      record.manifest = manifest_.id;
      if (!record.fallback.empty()) warn_once(fmt::format("{}: {}: {}", name, record.structure, record.fallback));
      if (!is_third_party(record)) summary_.disagreements += record.disagreements;
      lines.push_back(to_json_line(record));
    }
    directory_.append(lines);
  }

  void warn_once(const std::string& warning) { warn_once(warning, warning); }
  // `of`: what the warning is about, where its figures differ from time to time.
  void warn_once(const std::string& of, const std::string& warning) {
    if (warned_.insert(of).second) observer_.warn(warning);
  }

  void run_one(const Cell& cell, std::size_t position) {
    observer_.cell_started(cell.name, position, pending_.size());
    CellRecord record;
    record.cell = cell.name;
    record.parameters = parameters_of(config_.integrators[cell.integrator]);
    record.accel_parameters = parameters_of(config_.accels[cell.accel]);
    CellResult result;
    const auto failure = failure_of([&] { result = compute(cell); }, observer_);
    record.status = failure ? "failed" : "done";
    if (failure) {
      record.error = *failure;
      ++summary_.failed;
      directory_.append({to_json_line(record)});
      observer_.cell_finished(record, nullptr);
      return;
    }
    fill(record, result);
    if (!record.fallback.empty()) warn_once(fmt::format("{}: {}: {}", cell.name.scene, cell.name.accel, record.fallback));
    for (std::size_t i = 0; i < result.out_of_reach.size(); ++i)  // each seed has another estimate
      warn_once(fmt::format("{} {} {}", cell.name.scene, cell.name.integrator, i),
                fmt::format("{}: {}", cell.name.scene, result.out_of_reach[i]));
    const StoredFile image = directory_.write_image(cell.name, result.image, attributes(cell, result));
    record.image = image.path;
    record.image_stamp = image.stamp;
    if (!result.checkpoint_images.empty()) {
      const StoredFile strip = directory_.write_strip(cell.name, result.checkpoint_images);
      record.strip = strip.path;
      record.strip_stamp = strip.stamp;
    }
    record.checkpoints = result.checkpoints.size();
    std::vector<std::string> lines;
    for (CheckpointRecord& checkpoint : result.checkpoints) {
      checkpoint.cell = cell.name;
      checkpoint.manifest = manifest_.id;
      lines.push_back(to_json_line(checkpoint));
    }
    lines.push_back(to_json_line(record));
    directory_.append(lines);
    ++summary_.done;
    observer_.cell_finished(record, &result.checkpoints.back());
  }

  void log_products() {
    const auto lines = mapped(missing_products(read_resolved_log(plan_.directory)), to_json_line<ProductsRecord>);
    if (!lines.empty()) directory_.append(lines);
  }

  CellResult compute(const Cell& cell) {
    const LoadedScene& loaded = *scenes_[cell.scene];
    if (!loaded.reference.failure.empty()) throw Error(loaded.reference.failure);
    const Budget& budget = config_.budget;
    std::optional<double> error;  // as far as somebody watches it
    CellTask task{loaded.scene,
                  loaded.needs,
                  config_.accels[cell.accel],
                  config_.integrators[cell.integrator],
                  cell.name.seed,
                  loaded.resolution,
                  budget,
                  plan_.threads};
    task.reference = &loaded.reference.rendered.image;
    task.metrics = config_.metrics;
    task.regions = loaded.regions;
    task.keep_images = wants_images(cell.name);
    task.progress = [&](std::uint64_t iterations, double time_s) {
      observer_.cell_progress(budget.progress(iterations, time_s, error), iterations, time_s);
    };
    task.looks_for_left_out = true;
    task.confidence = config_.confidence && loaded.scene.closed_form.has_value();
    if (observer_.watches())
      task.live = [&](const LiveFigures& figures) {
        error = figures.error;
        observer_.cell_live(figures);
      };
    return compute_(task);
  }

  // Bias and variance are found from the images of several seeds.
  bool wants_images(const CellName& cell) const {
    return std::ranges::any_of(config_.predictions, [&](const Prediction& p) {
      return p.needs_images() && (p.scene.empty() || p.scene == cell.scene) && selects(p.method, cell.integrator);
    });
  }

  static void fill(CellRecord& record, const CellResult& result) {
    record.image_hash = fmt::format("{:016x}", result.image_hash);
    record.bias = bias_name(result.expectation.bias);
    record.mse_exponent = result.expectation.mse_exponent;
    record.bias_bound = result.expectation.bias_bound;
    record.note = result.expectation.note;
    record.fallback = result.fallback;
    if (result.chosen) record.chosen = result.chosen->label();
    record.why = result.why;
    if (result.chosen_accel) record.chosen_accel = result.chosen_accel->label();
    record.accel_why = result.accel_why;
    record.out_of_reach = fmt::format("{}", fmt::join(result.out_of_reach, "\n"));
    if (result.non_finite.empty()) return;
    for (const NonFiniteSample& sample : result.non_finite)
      if (record.non_finite_at.size() < 10)
        record.non_finite_at.push_back(
            {static_cast<std::uint32_t>(sample.pixel.x), static_cast<std::uint32_t>(sample.pixel.y), sample.iteration});
    const NonFiniteSample& first = result.non_finite.front();
    record.note +=
        fmt::format("{}{} non-finite samples, the first at pixel ({}, {}), iteration {}", record.note.empty() ? "" : "; ",
                    result.checkpoints.back().non_finite, first.pixel.x, first.pixel.y, first.iteration);
  }

  std::map<std::string, std::string> attributes(const Cell& cell, const CellResult& result) const {
    const LoadedScene& loaded = *scenes_[cell.scene];
    Recipe recipe{config_.scenes[cell.scene].path,
                  loaded.scene.hash(),
                  result.chosen.value_or(config_.integrators[cell.integrator]),
                  result.chosen_accel.value_or(config_.accels[cell.accel]),
                  cell.name.seed,
                  loaded.resolution,
                  result.checkpoints.back().iterations,
                  config_.budget.text()};
    recipe.pixel_filter = plan_.reading.pixel_filter;
    auto attributes = recipe_attributes(recipe, manifest_);
    attributes["etendue_cell"] = cell.name.key();
    attributes["etendue_experiment"] = config_.title;
    attributes["etendue_time_s"] = fmt::format("{}", result.checkpoints.back().time_s);
    return attributes;
  }

  const CellFunction& compute_;
  const RunPlan& plan_;
  const ExperimentConfig& config_;
  RunObserver& observer_;
  ManifestRecord manifest_;
  RunDirectory directory_;
  std::vector<std::unique_ptr<LoadedScene>> scenes_;  // null where nothing is left to do
  std::vector<const Cell*> pending_;
  std::set<std::string> warned_;
  RunSummary summary_;
};

}  // namespace

RunSummary execute_images(const RunPlan& plan, RunObserver& observer, const CellFunction& compute) {
  return Execution(plan, observer, compute).run();
}

}  // namespace etendue
