#include "experiments/run/run.h"

#include "experiments/kind.h"
#include "experiments/report/report.h"
#include "experiments/report/report_text.h"
#include "experiments/run/recipe.h"
#include "experiments/run/suspension.h"
#include "framework/core/parallel.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <new>

namespace etendue {

namespace {

namespace fs = std::filesystem;

std::string typed_options(const RunOptions& options) {
  std::string text = options.quick ? "--quick" : "";
  for (const std::string& assignment : options.overrides) text += (text.empty() ? "-o " : " -o ") + shell_word(assignment);
  if (const std::string& filter = options.reading.pixel_filter; !filter.empty())
    text += (text.empty() ? "--pixel-filter " : " --pixel-filter ") + shell_word(filter);
  return text;
}

// Writes the path as typed from here; "" where only this machine has such a path.
std::string shown_file(const fs::path& path) {
  const fs::path shown = path.is_absolute() ? path.lexically_proximate(fs::current_path()) : path;
  return path.is_absolute() && (shown.is_absolute() || *shown.begin() == "..") ? "" : shown.string();
}

}  // namespace

RunPlan plan_run(const RunOptions& options) {
  RunPlan plan;
  plan.config = load_config(options.experiment, {options.quick, options.overrides});
  plan.threads = options.threads.value_or(plan.config.threads.value_or(hardware_threads()));
  plan.fresh = options.fresh;
  plan.reading = options.reading;
  plan.filter = options.filter;
  plan.options = typed_options(options);
  if (!options.shard.empty())
    plan.shard = Shard::parse(options.shard);
  else
    plan.shard = Shard::from_slurm().value_or(Shard{});
  plan.cells = make_cells(plan.config);
  if (!options.filter.empty()) plan.cells = filter_cells(plan.cells, options.filter);
  plan.all_cells = plan.cells.size();
  plan.cells = shard_cells(plan.cells, plan.shard);
  plan.directory = options.out;
  if (plan.directory.empty()) {
    std::string name = fs::path(options.experiment).stem().string() + (options.quick ? "-quick" : "");
    if (plan.shard.count > 1) name += fmt::format("-shard-{}-of-{}", plan.shard.index, plan.shard.count);
    plan.directory = (fs::path("out") / name).string();
  }
  refuse_changed_sources(plan.directory, make_manifest("", "", 1).commit);
  return plan;
}

void refuse_changed_sources(const std::string& directory, const std::string& commit) {
  const fs::path path = fs::path(directory).lexically_normal();
  if (commit.ends_with("-dirty") && std::find(path.begin(), path.end(), fs::path("results")) != path.end())
    throw Error(Location{directory},
                fmt::format("the program was built from sources that differ from their commit ({}); expected "
                            "a clean tree: nobody could repeat what stands under results/",
                            commit));
}

ManifestRecord plan_manifest(const RunPlan& plan, int threads) {
  const ExperimentConfig& config = plan.config;
  // The hash is over every parameter that the file leaves at its default: a program with other defaults runs another
  // experiment.
  std::string resolved = config.hash;
  for (const Method& accel : config.accels) resolved += "\n" + resolved_accel(accel);
  for (const Method& integrator : config.integrators) resolved += "\n" + resolved_integrator(integrator);
  if (config.kind)
    for (const std::string& text : config.kind->resolved(config)) resolved += "\n" + text;
  ManifestRecord manifest = make_manifest(config.title, hash_text(resolved), threads);
  manifest.file = shown_file(config.path);
  manifest.options = plan.options;
  manifest.experiment = config.text;
  // A cell that iterations or an error ended could have gone on; one that time ended has its last image until then.
  if (config.budget.time_s && !config.budget.samples && !config.budget.error) manifest.budget_s = *config.budget.time_s;
  return manifest;
}

PlanRecord plan_record(const RunPlan& plan, const ManifestRecord& manifest) {
  return {manifest.experiment_hash, plan.filter, plan.shard.index, plan.shard.count, plan.cells.size(), plan.all_cells};
}

Scene load_choice(const RunPlan& plan, const SceneChoice& choice, RunObserver& observer) {
  Scene scene = load_scene(choice.path, choice.where, plan.reading);
  for (const std::string& warning : scene.warnings) {
    const bool named = warning.starts_with(choice.name + ":");
    observer.warn(named ? warning : choice.name + ": " + warning);
  }
  return scene;
}

void narrate_skipped(const RunPlan& plan, std::size_t skipped, RunObserver& observer) {
  if (skipped > 0)
    observer.narrate(fmt::format("{}: {} of {} cells are done already", plan.directory, skipped, plan.cells.size()));
}

void report_run(const RunPlan& plan, RunSummary& summary) {
  Report report =
      write_report({plan.directory}, plan.directory, {.table_formats = plan.config.table_formats, .of_a_run = true});
  summary.report_files = std::move(report.files);
  summary.findings = std::move(report.findings);
  summary.notes = std::move(report.notes);
  summary.table = plan.config.kind->summary(read_resolved_log(plan.directory));
  if (summary.table.empty()) summary.table = "The log holds no finished cell.\n";
}

std::optional<std::string> failure_of(const std::function<void()>& work, RunObserver& observer) {
  constexpr int most_times = 3;
  try {
    for (int i = 0; i < most_times; ++i) {
      if (i > 0) observer.warn("the process was suspended while the cell's clock ran: the cell runs again");
      const int before = suspensions();
      work();
      if (suspensions() == before) return std::nullopt;
    }
    return fmt::format("suspended each of the {} times that it ran, while its clock ran on; expected a process that is not",
                       most_times);
  } catch (const std::bad_alloc&) {
    return "out of memory";
  } catch (const std::exception& e) {
    return e.what();
  }
}

RunSummary execute_run(const RunPlan& plan, RunObserver& observer, const CellFunction& compute) {
  count_suspensions();  // whoever runs it: the program, or Python
  return plan.config.kind->run(plan, observer, compute);
}

}  // namespace etendue
