#include "experiments/harness/animation_run.h"

#include "experiments/harness/animation_report.h"
#include "experiments/harness/manifest.h"
#include "experiments/harness/report.h"
#include "experiments/harness/run_directory.h"
#include "framework/io/load_scene.h"

#include <fmt/format.h>
#include <chrono>
#include <map>
#include <set>

namespace etendue {

namespace {

class AnimationExecution {
 public:
  AnimationExecution(const RunPlan& plan, RunObserver& observer)
      : plan_(plan),
        observer_(observer),
        manifest_(make_manifest(plan.config.title, plan.config.hash, plan.threads)),
        directory_(plan.directory, manifest_, plan.fresh) {}

  RunSummary run() {
    std::set<CellName> done;
    for (const AnimationRecord& record : directory_.earlier().animations)
      if (record.status == "done") done.insert(record.cell);
    std::vector<const Cell*> pending;
    for (const Cell& cell : plan_.cells)
      if (!done.contains(cell.name)) pending.push_back(&cell);
    summary_.skipped = plan_.cells.size() - pending.size();
    if (summary_.skipped > 0)
      observer_.narrate(
          fmt::format("{}: {} of {} cells are done already", plan_.directory, summary_.skipped, plan_.cells.size()));
    // All of them before anything runs, so that a file that cannot be read is known at once.
    for (const Cell* cell : pending) load(cell->scene);
    for (std::size_t i = 0; i < pending.size(); ++i) run_one(*pending[i], i, pending.size());
    summary_.report_files = write_report({plan_.directory}, plan_.directory, {plan_.config.table_formats});
    summary_.table = animation_summary(read_directory_log(plan_.directory));
    return std::move(summary_);
  }

 private:
  void load(std::size_t s) {
    const SceneChoice& choice = plan_.config.scenes[s];
    const auto [entry, fresh] = scenes_.try_emplace(s);
    if (!fresh) return;
    entry->second = load_scene(choice.path, choice.where);
    for (const std::string& warning : entry->second.warnings) observer_.narrate(choice.name + ": " + warning);
  }

  void run_one(const Cell& cell, std::size_t position, std::size_t count) {
    const AnimationChoice& choice = *plan_.config.animation;
    observer_.cell_started(cell.name, position, count);
    const auto start = std::chrono::steady_clock::now();
    const auto elapsed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
    AnimationRecord record;
    try {
      record = run_animation(
          {scenes_.at(cell.scene), plan_.config.accels[cell.accel], choice.motions[cell.integrator], choice.policies,
           choice.frames, choice.resolution, choice.repetitions, cell.name.seed, plan_.threads, [&](int frame) {
             observer_.cell_progress(static_cast<double>(frame) / choice.frames, static_cast<std::uint64_t>(frame), elapsed());
           }});
      record.status = "done";
    } catch (const std::bad_alloc&) {
      record.error = "out of memory";
    } catch (const std::exception& e) {
      record.error = e.what();
    }
    CellRecord cell_record;
    cell_record.cell = record.cell = cell.name;
    record.manifest = manifest_.id;
    if (record.status.empty()) {
      record.status = "failed";
      ++summary_.failed;
    } else {
      ++summary_.done;
      for (const PolicyRecord& policy : record.policies) summary_.disagreements += policy.disagreements;
    }
    cell_record.status = record.status;
    cell_record.error = record.error;
    directory_.append({to_json_line(record)});
    CheckpointRecord last;
    last.cell = cell.name;
    last.iterations = static_cast<std::uint64_t>(choice.frames);
    last.time_s = elapsed();
    observer_.cell_finished(cell_record, record.status == "done" ? &last : nullptr);
  }

  const RunPlan& plan_;
  RunObserver& observer_;
  ManifestRecord manifest_;
  RunDirectory directory_;
  std::map<std::size_t, Scene> scenes_;
  RunSummary summary_;
};

}  // namespace

RunSummary execute_animations(const RunPlan& plan, RunObserver& observer) { return AnimationExecution(plan, observer).run(); }

}  // namespace etendue
