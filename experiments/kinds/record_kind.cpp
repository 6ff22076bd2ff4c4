#include "experiments/kinds/record_kind.h"

#include "experiments/log/trust.h"

#include <fmt/format.h>
#include <set>
#include <utility>

namespace etendue {

RunSummary execute_records(const RunPlan& plan, int threads, RunObserver& observer, RecordWork& work) {
  const ManifestRecord manifest = plan_manifest(plan, threads);
  RunDirectory directory(plan.directory, manifest, plan_record(plan, manifest), plan.fresh, observer);
  for (const Cell& cell : plan.cells) work.load(cell);
  for (const Cell& cell : plan.cells)
    if (const auto scene = work.scene(cell))
      directory.note_scene(scene->name, scene->path, scene->hash, plan.reading.pixel_filter);

  std::set<CellName> done;
  for (const auto& record : directory.earlier().records) {
    if (!record->done()) continue;
    if (const std::string wrong = damage(*record, plan.directory); !wrong.empty()) {
      observer.warn(fmt::format("{}: {}; it runs again", record->cell.key(), wrong));
      continue;
    }
    done.insert(record->cell);
    work.remember(*record);
  }
  std::vector<const Cell*> pending;
  for (const Cell& cell : plan.cells)
    if (!done.contains(cell.name)) pending.push_back(&cell);
  RunSummary summary;
  summary.skipped = plan.cells.size() - pending.size();
  narrate_skipped(plan, summary.skipped, observer);

  for (std::size_t i = 0; i < pending.size(); ++i) {
    const Cell& cell = *pending[i];
    observer.cell_started(cell.name, i, pending.size());
    const double start = now_s();
    std::unique_ptr<KindRecord> record = work.begin(cell);
    CheckpointRecord last;
    last.cell = cell.name;
    bool again = false;
    const auto fill = [&] {
      if (std::exchange(again, true)) record = work.begin(cell);
      work.fill(cell, *record, directory, [&](double share, std::uint64_t steps) {
        last.iterations = steps;
        observer.cell_progress(share, steps, now_s() - start);
      });
    };
    const auto failure = failure_of(fill, observer);
    ++(failure ? summary.failed : summary.done);
    record->cell = cell.name;
    record->manifest = manifest.id;
    record->status = failure ? "failed" : "done";
    record->error = failure.value_or("");
    directory.append({record->line()});
    CellRecord ended;
    ended.cell = cell.name;
    ended.status = record->status;
    ended.error = record->error;
    last.time_s = now_s() - start;
    observer.cell_finished(ended, failure ? nullptr : &last);
  }
  directory.finish();
  summary.disagreements = work.disagreements();
  report_run(plan, summary);
  return summary;
}

}  // namespace etendue
