#include "experiments/claims/record_run.h"

#include "experiments/harness/manifest.h"
#include "experiments/harness/report.h"

#include <fmt/format.h>
#include <chrono>
#include <new>
#include <set>

namespace etendue {

namespace {

class RecordExecution {
 public:
  RecordExecution(const RunPlan& plan, RunObserver& observer, RecordWork& work)
      : plan_(plan),
        observer_(observer),
        work_(work),
        manifest_(make_manifest(plan.config.title, plan.config.hash, plan.threads)),
        directory_(plan.directory, manifest_, plan.fresh) {}

  RunSummary run() {
    std::set<CellName> done;
    for (const ClaimRecord& record : directory_.earlier().claims) {
      if (record.status != "done") continue;
      done.insert(record.cell);
      work_.remember(record);
    }
    std::vector<const Cell*> pending;
    for (const Cell& cell : plan_.cells)
      if (!done.contains(cell.name)) pending.push_back(&cell);
    summary_.skipped = plan_.cells.size() - pending.size();
    if (summary_.skipped > 0)
      observer_.narrate(
          fmt::format("{}: {} of {} cells are done already", plan_.directory, summary_.skipped, plan_.cells.size()));
    for (std::size_t i = 0; i < pending.size(); ++i) run_one(*pending[i], i, pending.size());
    summary_.report_files = write_report({plan_.directory}, plan_.directory, {plan_.config.table_formats});
    summary_.table = work_.summary(read_directory_log(plan_.directory));
    return std::move(summary_);
  }

 private:
  void run_one(const Cell& cell, std::size_t position, std::size_t count) {
    observer_.cell_started(cell.name, position, count);
    const auto start = std::chrono::steady_clock::now();
    const auto elapsed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
    ClaimRecord record;
    record.cell = cell.name;
    record.manifest = manifest_.id;
    work_.describe(cell, record);
    std::uint64_t steps = 0;
    try {
      work_.fill(cell, record, directory_, [&](double share) { observer_.cell_progress(share, ++steps, elapsed()); });
      record.status = "done";
    } catch (const std::bad_alloc&) {
      record.error = "out of memory";
    } catch (const std::exception& e) {
      record.error = e.what();
    }
    if (record.status.empty()) record.status = "failed";
    ++(record.status == "done" ? summary_.done : summary_.failed);
    directory_.append({to_json_line(record)});
    CellRecord cell_record;
    cell_record.cell = cell.name;
    cell_record.status = record.status;
    cell_record.error = record.error;
    CheckpointRecord last;
    last.cell = cell.name;
    last.iterations = steps;
    last.time_s = elapsed();
    observer_.cell_finished(cell_record, record.status == "done" ? &last : nullptr);
  }

  const RunPlan& plan_;
  RunObserver& observer_;
  RecordWork& work_;
  ManifestRecord manifest_;
  RunDirectory directory_;
  RunSummary summary_;
};

}  // namespace

RunSummary execute_records(const RunPlan& plan, RunObserver& observer, RecordWork& work) {
  return RecordExecution(plan, observer, work).run();
}

}  // namespace etendue
