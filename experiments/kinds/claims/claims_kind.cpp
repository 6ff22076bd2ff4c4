#include "experiments/kinds/claims/claim_scenes.h"
#include "experiments/kinds/claims/claims.h"
#include "experiments/kinds/record_kind.h"
#include "experiments/kinds/rows.h"
#include "experiments/log/fields.h"
#include "framework/core/parallel.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>
#include <algorithm>

namespace etendue {

constexpr const char* figure_kinds[] = {"factor", "time", "plain", "share", "exponent"};

void list_fields(auto& f, FieldsOf<ClaimFigure> auto& r) {
  FIELDS(quantity, text);
  f.choice("kind", r.kind, figure_kinds);
  f("median", r.value.median);
  f("low", r.value.low);
  f("high", r.value.high);
  f("judged", r.judged);
  if (!r.judged) return;
  f.end("expected_low", r.expected.low, -endless);
  f.end("expected_high", r.expected.high, endless);
}

void list_fields(auto& f, FieldsOf<ClaimRecord> auto& r) {
  f("id", r.id);
  f.cell(r.cell, "measure", "cell");
  list_ending(f, r);
  FIELDS(claim, source, claimed, reading, figures, remarks, disagreements);
}

std::string ClaimRecord::line() const { return line_of(type, *this); }

namespace {

ClaimMeasure read_measure(const ConfigNode& node) {
  TableReader row(node, "claims.measures");
  ClaimMeasure measure;
  measure.measurement = &find_measurement(row.needed_text("name"), row.need("name").where);
  for (const ConfigNode* scene : list_elements(row.need("scenes"), "scenes", "an array of scenes")) {
    measure.scenes.push_back(read_text(*scene, "scenes", "names or paths in quotes"));
    check_claim_scene(measure.scenes.back(), scene->where);
    if (std::ranges::count(measure.scenes, measure.scenes.back()) > 1)
      throw Error(scene->where, fmt::format("scene '{}' stands there twice", measure.scenes.back()));
  }
  if (const ConfigNode* expect = row.find("expect")) {
    const Measurement& measurement = *measure.measurement;
    measure.expect = read_expectations(*expect, measurement.name + ": expect", entry_names(measurement.quantities));
  }
  row.flag("large", measure.large);
  row.finish();
  return measure;
}

Claim read_claim(const ConfigNode& node) {
  TableReader row(node, "claims");
  Claim claim{{.id = static_cast<int>(row.needed_whole("id", 1, 9999)),
               .claim = row.needed_text("claim"),
               .source = row.needed_text("source"),
               .claimed = row.needed_text("claimed")}};
  row.text("reading", claim.reading);
  bool judged = false;
  for (const ConfigNode& measure : read_tables(row.need("measures"), "claims.measures")) {
    claim.measures.push_back(read_measure(measure));
    judged = judged || !claim.measures.back().expect.empty();
    const auto same = [&](const ClaimMeasure& other) { return other.measurement == claim.measures.back().measurement; };
    if (std::ranges::count_if(claim.measures, same) > 1)
      throw Error(measure.where, fmt::format("claims: '{}' stands there twice in claim {}",
                                             claim.measures.back().measurement->name, claim.id));
  }
  if (!judged)
    throw Error(node.where, fmt::format("claims: nothing judges claim {}; expected expect = {{ … }} in a measure", claim.id));
  row.finish();
  return claim;
}

}  // namespace

ClaimsChoice read_claims(const ConfigNode& claims, const ConfigNode* timing) {
  ClaimsChoice choice;
  if (timing) {
    TableReader reader(*timing, "timing");
    reader.whole("resolution", choice.resolution, 8, 4096);
    reader.whole("repetitions", choice.repetitions, 1, 1000);
    reader.flag("large", choice.large);
    reader.finish();
  }
  choice.rows = read_rows<Claim>(claims, "claims", read_claim);
  return choice;
}

namespace {

class ClaimsWork final : public RecordWork {
 public:
  ClaimsWork(const RunPlan& plan, RunObserver&)
      : choice_(choice_of<ClaimsChoice>(plan.config)), threads_(plan.threads), reading_(plan.reading) {}

  void remember(const KindRecord& remembered) override {
    const auto& record = static_cast<const ClaimRecord&>(remembered);
    MeasureResult& result = results_[{record.cell.accel, record.cell.scene}];
    result = {{}, record.remarks, record.disagreements};
    for (const ClaimFigure& figure : record.figures) result.figures.emplace_back(figure.quantity, figure.value);
  }

  std::optional<SceneState> scene(const Cell& cell) override {
    const std::string& name = measure_of(cell).scenes[cell.scene];
    if (!is_file(name)) return std::nullopt;
    return SceneState{name, name, load_claim_scene(name, reading_).hash()};
  }

  std::unique_ptr<KindRecord> begin(const Cell& cell) override {
    auto record = std::make_unique<ClaimRecord>();
    static_cast<ClaimStatement&>(*record) = choice_.rows[cell.integrator];
    return record;
  }

  void fill(const Cell& cell, KindRecord& filled, RunDirectory&, const Progress& progress) override {
    const ClaimMeasure& measure = measure_of(cell);
    const Measurement& measurement = *measure.measurement;
    const auto tell = [&, steps = std::uint64_t{0}](double share) mutable { progress(share, ++steps); };
    const MeasureTask task{
        measure.scenes[cell.scene], choice_.resolution, choice_.repetitions, threads_, cell.name.seed, tell, reading_};
    // A measurement that another claim asked of the same scene serves this one as well.
    auto known = results_.find({measurement.name, task.scene});
    if (known == results_.end()) {
      MeasureResult result;
      with_threads(measurement.parallel ? task.threads : 1, [&] { result = measurement.run(task); });
      disagreements_ += result.disagreements;
      known = results_.emplace(std::pair{measurement.name, task.scene}, std::move(result)).first;
    }
    auto& record = static_cast<ClaimRecord&>(filled);
    record.remarks = known->second.remarks;
    record.disagreements = known->second.disagreements;
    for (const auto& [name, value] : known->second.figures) {
      const Quantity& quantity = *measurement.quantity(name);
      const auto expected = measure.expect.find(name);
      const bool judged = expected != measure.expect.end();
      record.figures.push_back({name, quantity.text, quantity.kind, value, judged, judged ? expected->second : Expected{}});
    }
  }

  std::uint64_t disagreements() const override { return disagreements_; }

 private:
  const ClaimMeasure& measure_of(const Cell& cell) const { return choice_.rows[cell.integrator].measures[cell.accel]; }

  const ClaimsChoice& choice_;
  int threads_;
  SceneReading reading_;
  std::uint64_t disagreements_ = 0;                                       // of what this run measured
  std::map<std::pair<std::string, std::string>, MeasureResult> results_;  // by measurement and scene
};

class ClaimsKind final : public RecordKind<ClaimRecord, ClaimsWork> {
 public:
  ClaimsKind() : RecordKind({"scenes", "accels", "seeds", "budget", "resolution"}) {}

  std::vector<std::string> keys() const override { return {"claims"}; }
  std::vector<std::string> measures() const override { return measured_code({"experiments/kinds/claims"}); }
  std::vector<std::string> companions() const override { return {"timing"}; }
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

  KindReport report(const RunLog& log) const override { return claims_report(log); }
  std::string summary(const RunLog& log) const override { return claims_summary(log); }
};

}  // namespace

const ExperimentKind& claims_kind() { return the_kind<ClaimsKind>(); }

}  // namespace etendue
