#include "experiments/run/record_run.h"

#include "experiments/kind.h"
#include "experiments/log/trust.h"

#include <fmt/format.h>
#include <set>

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
    std::set<CellName> done;
    for (const auto& record : directory_.earlier().records) {
      if (!record->done() || !is_whole(*record)) continue;
      done.insert(record->cell);
      work_.remember(*record);
    }
    std::vector<const Cell*> pending;
    for (const Cell& cell : plan_.cells)
      if (!done.contains(cell.name)) pending.push_back(&cell);
    summary_.skipped = plan_.cells.size() - pending.size();
    narrate_skipped(plan_, summary_.skipped, observer_);
    for (std::size_t i = 0; i < pending.size(); ++i) run_one(*pending[i], i, pending.size());
    directory_.finish();
    summary_.disagreements = work_.disagreements();
    report_run(plan_, summary_);
    return std::move(summary_);
  }

 private:
  bool is_whole(KindRecord& record) {
    const std::string wrong = damage(record, plan_.directory);
    if (!wrong.empty()) observer_.warn(fmt::format("{}: {}; it runs again", record.cell.key(), wrong));
    return wrong.empty();
  }

  void run_one(const Cell& cell, std::size_t position, std::size_t count) {
    observer_.cell_started(cell.name, position, count);
    const auto elapsed = [start = now_s()] { return now_s() - start; };
    std::unique_ptr<KindRecord> record = work_.begin(cell);
    CheckpointRecord last;
    last.cell = cell.name;
    CellRecord cell_record;
    cell_record.cell = cell.name;
    const auto fill = [&] {
      record = work_.begin(cell);
      work_.fill(cell, *record, directory_, [&](double share, std::uint64_t steps) {
        last.iterations = steps;
        observer_.cell_progress(share, steps, elapsed());
      });
    };
    const auto failure = failure_of(fill, observer_);
    cell_record.status = failure ? "failed" : "done";
    cell_record.error = failure.value_or("");
    ++(failure ? summary_.failed : summary_.done);
    record->cell = cell.name;
    record->manifest = manifest_.id;
    record->status = cell_record.status;
    record->error = cell_record.error;
    directory_.append({record->line()});
    last.time_s = elapsed();
    observer_.cell_finished(cell_record, record->done() ? &last : nullptr);
  }

  const RunPlan& plan_;
  RunObserver& observer_;
  RecordWork& work_;
  ManifestRecord manifest_;
  RunDirectory directory_;
  RunSummary summary_;
};

}  // namespace

RunSummary execute_records(const RunPlan& plan, int threads, RunObserver& observer, RecordWork& work) {
  return RecordExecution(plan, threads, observer, work).run();
}

}  // namespace etendue
