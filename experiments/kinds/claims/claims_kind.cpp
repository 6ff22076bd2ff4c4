#include "experiments/kinds/claims/claims_kind.h"

#include "experiments/kinds/claims/claim_scenes.h"
#include "experiments/kinds/claims/claims_config.h"
#include "experiments/kinds/claims/claims_report.h"
#include "experiments/run/record_run.h"
#include "framework/core/check.h"
#include "framework/core/parallel.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>
#include <map>

namespace etendue {

namespace {

class ClaimsWork final : public RecordWork {
 public:
  explicit ClaimsWork(const RunPlan& plan)
      : choice_(choice_of<ClaimsChoice>(plan.config)), threads_(plan.threads), reading_(plan.reading) {}

  void remember(const KindRecord& remembered) override {
    const auto& record = static_cast<const ClaimRecord&>(remembered);
    MeasureResult& result = results_[{record.cell.accel, record.cell.scene}];
    result = {{}, record.remarks, record.disagreements};
    for (const ClaimFigure& figure : record.figures) result.figures.emplace_back(figure.quantity, figure.value);
  }

  std::optional<SceneState> scene(const Cell& cell) override {
    const std::string& name = choice_.rows[cell.integrator].measures[cell.accel].scenes[cell.scene];
    if (!is_file(name)) return std::nullopt;
    return SceneState{name, name, load_claim_scene(name).hash()};
  }

  std::unique_ptr<KindRecord> begin(const Cell& cell) override {
    const Claim& claim = choice_.rows[cell.integrator];
    auto record = std::make_unique<ClaimRecord>();
    record->id = claim.id;
    record->claim = claim.claim;
    record->source = claim.source;
    record->claimed = claim.claimed;
    record->reading = claim.reading;
    return record;
  }

  void fill(const Cell& cell, KindRecord& record, RunDirectory&, const Progress& progress) override {
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
    fill(static_cast<ClaimRecord&>(record), measure, known->second);
  }

  std::uint64_t disagreements() const override { return disagreements_; }

 private:
  static void fill(ClaimRecord& record, const ClaimMeasure& measure, const MeasureResult& result) {
    for (const auto& [name, value] : result.figures) {
      const Quantity* quantity = measure.measurement->quantity(name);
      CHECK(quantity != nullptr);
      ClaimFigure figure{name, quantity->text, quantity->kind, value};
      if (const auto found = measure.expect.find(name); found != measure.expect.end()) {
        figure.judged = true;
        figure.expected = found->second;
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

class ClaimsKind final : public ExperimentKind {
 public:
  std::vector<std::string> keys() const override { return {"claims"}; }
  std::vector<std::string> companions() const override { return {"timing"}; }
  std::vector<std::string> useless() const override {
    return {"scenes",    "accels",  "integrators", "seeds",      "structures", "budget",
            "reference", "metrics", "confidence",  "resolution", "regions",    "predictions"};
  }
  std::string beside() const override { return "[[claims]], which name what they measure"; }

  void read(const ConfigNode& root, ExperimentConfig& config) const override {
    config.choice = std::make_shared<ClaimsChoice>(read_claims(*find_key(root, "claims"), find_key(root, "timing")));
  }

  std::vector<std::string> quick(const ConfigNode&) const override {
    return {"timing={ resolution = 32, repetitions = 3, large = false }"};
  }

  // A claim's cells stand together: what a claim compares takes turns within a cell. Of a cell, `integrator` is the claim,
  // `accel` its measure, `scene` that measure's.
  std::vector<Cell> cells(const ExperimentConfig& config) const override {
    const auto& choice = choice_of<ClaimsChoice>(config);
    std::vector<Cell> cells;
    for (std::size_t c = 0; c < choice.rows.size(); ++c)
      for (std::size_t m = 0; m < choice.rows[c].measures.size(); ++m) {
        const ClaimMeasure& measure = choice.rows[c].measures[m];
        if (measure.large && !choice.large) continue;
        for (std::size_t s = 0; s < measure.scenes.size(); ++s)
          cells.push_back(
              {s, m, c, {measure.scenes[s], measure.measurement->name, fmt::format("claim-{:02}", choice.rows[c].id), 1}});
      }
    return cells;
  }

  std::string effort(const ExperimentConfig& config) const override {
    const auto& choice = choice_of<ClaimsChoice>(config);
    return fmt::format("{} repetitions, about {}² rays of a kind", choice.repetitions, choice.resolution);
  }

  RunSummary run(const RunPlan& plan, RunObserver& observer, const CellFunction&) const override {
    ClaimsWork work(plan);
    return execute_records(plan, plan.threads, observer, work);
  }

  std::string record_type() const override { return "claim"; }
  std::shared_ptr<KindRecord> read_record(const Json& json) const override {
    return std::make_shared<ClaimRecord>(read_claim_record(json));
  }
  KindReport report(const RunLog& log) const override { return claims_report(log); }
  std::string summary(const RunLog& log) const override { return claims_summary(log); }
};

}  // namespace

const ExperimentKind& claims_kind() {
  static const ClaimsKind kind;
  return kind;
}

}  // namespace etendue
