#include "experiments/claims/claims_run.h"

#include "experiments/claims/claims_report.h"
#include "experiments/harness/manifest.h"
#include "experiments/harness/report.h"
#include "experiments/harness/run_directory.h"
#include "framework/core/check.h"
#include "framework/core/parallel.h"

#include <fmt/format.h>
#include <chrono>
#include <map>
#include <set>

namespace etendue {

namespace {

class ClaimsExecution {
 public:
  ClaimsExecution(const RunPlan& plan, RunObserver& observer)
      : plan_(plan),
        observer_(observer),
        manifest_(make_manifest(plan.config.title, plan.config.hash, plan.threads)),
        directory_(plan.directory, manifest_, plan.fresh) {}

  RunSummary run() {
    std::set<CellName> done;
    for (const ClaimRecord& record : directory_.earlier().claims) {
      if (record.status != "done") continue;
      done.insert(record.cell);
      remember(record);
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
    summary_.table = claims_summary(read_directory_log(plan_.directory));
    return std::move(summary_);
  }

 private:
  void run_one(const Cell& cell, std::size_t position, std::size_t count) {
    observer_.cell_started(cell.name, position, count);
    const auto start = std::chrono::steady_clock::now();
    const auto elapsed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
    const ClaimsChoice& choice = *plan_.config.claims;
    const Claim& claim = choice.rows[cell.integrator];
    const ClaimMeasure& measure = claim.measures[cell.accel];
    ClaimRecord record;
    record.cell = cell.name;
    record.manifest = manifest_.id;
    record.id = claim.id;
    record.claim = claim.claim;
    record.source = claim.source;
    record.claimed = claim.claimed;
    record.reading = claim.reading;
    std::uint64_t steps = 0;
    const Measurement& measurement = *measure.measurement;
    const MeasureTask task{
        measure.scenes[cell.scene], choice.resolution, choice.repetitions, plan_.threads, cell.name.seed, [&](double share) {
          observer_.cell_progress(share, ++steps, elapsed());
        }};
    try {
      // What another claim asked of the same scene serves this one as well.
      auto known = results_.find({measurement.name, task.scene});
      if (known == results_.end()) {
        MeasureResult result;
        with_threads(measurement.parallel ? task.threads : 1, [&] { result = measurement.run(task); });
        summary_.disagreements += result.disagreements;
        known = results_.emplace(std::pair{measurement.name, task.scene}, std::move(result)).first;
      }
      fill(record, measure, known->second);
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

  void remember(const ClaimRecord& record) {
    MeasureResult& result = results_[{record.cell.accel, record.cell.scene}];
    result = {{}, record.remarks, record.disagreements};
    for (const ClaimFigure& figure : record.figures) result.figures.emplace_back(figure.quantity, figure.value);
  }

  static void fill(ClaimRecord& record, const ClaimMeasure& measure, const MeasureResult& result) {
    for (const auto& [name, value] : result.figures) {
      const Quantity* quantity = measure.measurement->quantity(name);
      CHECK(quantity != nullptr);
      ClaimFigure figure{name, quantity->text, quantity->kind, value};
      if (const auto found = measure.expect.find(name); found != measure.expect.end()) {
        figure.judged = true;
        figure.expected_low = found->second.low;
        figure.expected_high = found->second.high;
      }
      record.figures.push_back(std::move(figure));
    }
    record.remarks = result.remarks;
    record.disagreements = result.disagreements;
  }

  const RunPlan& plan_;
  RunObserver& observer_;
  ManifestRecord manifest_;
  RunDirectory directory_;
  std::map<std::pair<std::string, std::string>, MeasureResult> results_;  // by measurement and scene
  RunSummary summary_;
};

}  // namespace

RunSummary execute_claims(const RunPlan& plan, RunObserver& observer) { return ClaimsExecution(plan, observer).run(); }

}  // namespace etendue
