#include "experiments/kinds/record_kind.h"

#include "experiments/log/trust.h"

#include <fmt/format.h>
#include <set>
#include <utility>

namespace etendue {

namespace {

class RecordExecution {
 public:
  RecordExecution(const RunPlan& plan, int threads, RunObserver& observer, RecordWork& work)
      : plan_(plan),
        observer_(observer),
        work_(work),
        manifest_(plan_manifest(plan, threads)),
        directory_(plan.directory, manifest_, plan_record(plan, manifest_), plan.fresh, observer) {}

  RunSummary run() {
    for (const Cell& cell : plan_.cells) work_.load(cell);
    for (const Cell& cell : plan_.cells)
      if (const auto scene = work_.scene(cell))
        directory_.note_scene(scene->name, scene->path, scene->hash, plan_.reading.pixel_filter);
    check_references();
    const std::set<CellName> done = directory_.believed_cells();
    for (const auto& record : directory_.earlier().records)
      if (done.contains(record->cell)) work_.remember(*record);
    std::vector<const Cell*> pending;
    for (const Cell& cell : plan_.cells)
      if (!done.contains(cell.name)) pending.push_back(&cell);
    narrate_skipped(plan_, plan_.cells.size() - pending.size(), observer_);
    run_all(pending);
    run_all(dropped_cells());
    directory_.finish();
    RunSummary summary;
    for (const auto& [cell, failed] : failed_) ++(failed ? summary.failed : summary.done);
    summary.skipped = plan_.cells.size() - failed_.size();
    summary.disagreements = work_.disagreements();
    report_run(plan_, summary);
    return summary;
  }

 private:
  // Makes those anew that are damaged or may be others by now.
  void check_references() {
    const bool is_file = plan_.config.reference.kind == ReferenceChoice::Kind::file;
    const std::vector<ReferenceRecord> known = directory_.earlier().references;
    for (const ReferenceRecord& reference : known)
      if (is_file || !damage(reference, plan_.directory).empty()) work_.refer(reference.scene, directory_);
  }

  // Those whose records a reference that turned out to be another took out of the log.
  std::vector<const Cell*> dropped_cells() {
    directory_.read_again();
    std::set<CellName> logged;
    for (const auto& record : directory_.earlier().records) logged.insert(record->cell);
    std::vector<const Cell*> dropped;
    for (const Cell& cell : plan_.cells)
      if (!logged.contains(cell.name)) dropped.push_back(&cell);
    return dropped;
  }

  void run_all(const std::vector<const Cell*>& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      observer_.cell_started(cells[i]->name, i, cells.size());
      run_one(*cells[i]);
    }
  }

  void run_one(const Cell& cell) {
    const double start = now_s();
    std::unique_ptr<KindRecord> record = work_.begin(cell);
    CheckpointRecord last;
    last.cell = cell.name;
    bool again = false;
    const auto fill = [&] {
      if (std::exchange(again, true)) record = work_.begin(cell);
      work_.fill(cell, *record, directory_, [&](double share, std::uint64_t steps) {
        last.iterations = steps;
        observer_.cell_progress(share, steps, now_s() - start);
      });
    };
    const auto failure = failure_of(fill, observer_);
    failed_[cell.name] = failure.has_value();
    record->cell = cell.name;
    record->manifest = manifest_.id;
    record->status = failure ? "failed" : "done";
    record->error = failure.value_or("");
    directory_.append({record->line()});
    CellRecord ended;
    ended.cell = cell.name;
    ended.status = record->status;
    ended.error = record->error;
    last.time_s = now_s() - start;
    observer_.cell_finished(ended, failure ? nullptr : &last);
  }

  const RunPlan& plan_;
  RunObserver& observer_;
  RecordWork& work_;
  const ManifestRecord manifest_;
  RunDirectory directory_;
  std::map<CellName, bool> failed_;  // of the cells that ran
};

}  // namespace

RunSummary execute_records(const RunPlan& plan, int threads, RunObserver& observer, RecordWork& work) {
  return RecordExecution(plan, threads, observer, work).run();
}

}  // namespace etendue
