#include "experiments/kinds/claims/claims_run.h"

#include "experiments/kinds/claims/claim_scenes.h"
#include "experiments/kinds/claims/claims_report.h"
#include "experiments/run/record_run.h"
#include "framework/core/check.h"
#include "framework/core/parallel.h"
#include "framework/io/whole_file.h"

#include <map>

namespace etendue {

namespace {

class ClaimsWork final : public RecordWork<ClaimRecord> {
 public:
  explicit ClaimsWork(const RunPlan& plan) : choice_(*plan.config.claims), threads_(plan.threads), reading_{plan.confined} {}

  void remember(const ClaimRecord& record) override {
    MeasureResult& result = results_[{record.cell.accel, record.cell.scene}];
    result = {{}, record.remarks, record.disagreements};
    for (const ClaimFigure& figure : record.figures) result.figures.emplace_back(figure.quantity, figure.value);
  }

  std::optional<SceneState> scene(const Cell& cell) override {
    const std::string& name = choice_.rows[cell.integrator].measures[cell.accel].scenes[cell.scene];
    if (!is_file(name)) return std::nullopt;
    return SceneState{name, name, load_claim_scene(name).hash()};
  }

  void describe(const Cell& cell, ClaimRecord& record) override {
    const Claim& claim = choice_.rows[cell.integrator];
    record.id = claim.id;
    record.claim = claim.claim;
    record.source = claim.source;
    record.claimed = claim.claimed;
    record.reading = claim.reading;
  }

  void fill(const Cell& cell, ClaimRecord& record, RunDirectory&, const Progress& progress) override {
    const ClaimMeasure& measure = choice_.rows[cell.integrator].measures[cell.accel];
    const Measurement& measurement = *measure.measurement;
    const MeasureTask task{measure.scenes[cell.scene],
                           choice_.resolution,
                           choice_.repetitions,
                           threads_,
                           cell.name.seed,
                           [&, steps = std::uint64_t{0}](double share) mutable { progress(share, ++steps); },
                           reading_};
    // What another claim asked of the same scene serves this one as well.
    auto known = results_.find({measurement.name, task.scene});
    if (known == results_.end()) {
      MeasureResult result;
      with_threads(measurement.parallel ? task.threads : 1, [&] { result = measurement.run(task); });
      disagreements_ += result.disagreements;
      known = results_.emplace(std::pair{measurement.name, task.scene}, std::move(result)).first;
    }
    fill(record, measure, known->second);
  }

  std::string summary(const RunLog& log) const override { return claims_summary(log); }
  std::uint64_t disagreements() const override { return disagreements_; }

 private:
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

  const ClaimsChoice& choice_;
  int threads_;
  SceneReading reading_;
  std::uint64_t disagreements_ = 0;                                       // of what this run measured
  std::map<std::pair<std::string, std::string>, MeasureResult> results_;  // by measurement and scene
};

}  // namespace

RunSummary execute_claims(const RunPlan& plan, RunObserver& observer) {
  ClaimsWork work(plan);
  return execute_records(plan, plan.threads, observer, work);
}

}  // namespace etendue
