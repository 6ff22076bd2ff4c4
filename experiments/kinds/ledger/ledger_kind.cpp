// The ledger: each component of the program switched off where it is on and on where it is off, one at a time, with the change
// of error and of time.
//
// The program's own decision and its opposite are rendered by turns, seed by seed, with the same number of iterations and the
// same seeds, on one thread; what counts is the time of the processor, so that other work on the machine matters little.
//
// The rows of [[ledger]] are components of the program, and how each is switched (docs/experiment-file.md has the keys).
#include "accel/registry.h"
#include "experiments/config/config_keys.h"
#include "experiments/kinds/ledger/ledger.h"
#include "experiments/kinds/ledger/ledger_decisions.h"
#include "experiments/kinds/record_kind.h"
#include "experiments/kinds/rows.h"
#include "experiments/run/recipe.h"
#include "experiments/run/run_cell.h"
#include "experiments/run/run_reference.h"
#include "framework/io/text.h"
#include "integrators/registry.h"

#include <fmt/format.h>
#include <algorithm>
#include <optional>
#include <stdexcept>

namespace etendue {

namespace {

// Keeps each figure of the trials as an array, in the order of the seeds, and the seeds of images that are the same.
struct TrialColumns {
  std::vector<std::uint64_t> seeds, same_images;
  std::vector<double> errors, switched_errors, cpu_s, switched_cpu_s;
};
void list_columns(auto& f, auto& r) {
  FIELDS(seeds, errors, switched_errors, cpu_s, switched_cpu_s);
  f.maybe("same_images", r.same_images);
}
void list_trials(auto& f, const std::vector<LedgerTrial>& trials) {
  TrialColumns columns;
  for (const LedgerTrial& trial : trials) {
    columns.seeds.push_back(trial.seed);
    columns.errors.push_back(trial.error);
    columns.switched_errors.push_back(trial.switched_error);
    columns.cpu_s.push_back(trial.cpu_s);
    columns.switched_cpu_s.push_back(trial.switched_cpu_s);
    if (trial.same_image) columns.same_images.push_back(trial.seed);
  }
  list_columns(f, columns);
}
void list_trials(FieldsIn& f, std::vector<LedgerTrial>& trials) {
  TrialColumns columns;
  list_columns(f, columns);
  for (std::size_t i = 0; i < columns.seeds.size(); ++i) {
    const std::uint64_t seed = columns.seeds[i];
    trials.push_back({seed, columns.errors.at(i), columns.switched_errors.at(i), columns.cpu_s.at(i),
                      columns.switched_cpu_s.at(i), contains(columns.same_images, seed)});
  }
}

}  // namespace

void list_fields(auto& f, FieldsOf<LedgerRecord> auto& r) {
  f.cell(r.cell, "method", "component");
  list_ending(f, r);
  FIELDS(on, why, switched);
  MAYBE_FIELDS(kept, inapplicable);
  FIELDS(reference, iterations, bias, mse_exponent);
  MAYBE_FIELDS(relmse_floor);
  list_trials(f, r.trials);
}

std::string LedgerRecord::line() const { return line_of(type, *this); }

namespace {

struct LedgerRow {
  std::string component, kept;
  Method method, accel;                 // as the program runs them
  std::optional<Method> with, without;  // in the place of the accel where `of_structure`, else of the method; none with an edit
  bool of_structure = false;
  const LedgerEdit* edit = nullptr;
  const LedgerDecision* decision = nullptr;  // null: `always_on` says what is decided
  bool always_on = false;
  std::uint64_t samples = 0;

  // The name that records give to what has the component.
  std::string owner() const { return (of_structure ? accel : method).label(); }
};

struct LedgerChoice final : KindChoice {
  std::vector<LedgerRow> rows;
};

// --- the keys ---

bool same_value(const std::string& a, const std::string& b) {
  const auto x = parse_number(a), y = parse_number(b);
  return a == b || (x && y && *x == *y);
}

// Whether two methods are one and the same once defaults are written out.
bool same_method(const Method& a, const Method& b, const std::vector<ParamInfo>& params) {
  const auto value = [](const Method& method, const ParamInfo& info) {
    const auto found = method.params.find(info.name);
    return found == method.params.end() ? info.default_value : to_text(found->second);
  };
  return a.name == b.name &&
         std::ranges::all_of(params, [&](const ParamInfo& info) { return same_value(value(a, info), value(b, info)); });
}

void read_decision(TableReader& reader, const ConfigNode& node, LedgerRow& row) {
  if (const ConfigNode* decided = reader.find("decided")) {
    row.decision = &find_by_name(ledger_decisions(), "decision", read_text(*decided, "ledger.decided"), decided->where);
    return;
  }
  const Method& own = row.of_structure ? row.accel : row.method;
  const auto& params =
      row.of_structure ? find_ray_structure(own.name, own.where).params : find_integrator(own.name, own.where).params;
  reader.finish();  // a misspelt key is told as one
  row.always_on = same_method(own, *row.with, params);
  if (row.always_on == same_method(own, *row.without, params))
    throw Error(node.where, fmt::format("ledger: {} itself is {} of on = {{ … }} and off = {{ … }}; expected one of them, or "
                                        "decided = the name of a decision",
                                        own.label(), row.always_on ? "both" : "none"));
}

void read_switch(TableReader& reader, const ConfigNode& node, LedgerRow& row) {
  const ConfigNode *method = reader.find("method"), *accel = reader.find("accel"), *edit = reader.find("edit");
  if ((method != nullptr) + (accel != nullptr) + (edit != nullptr) > 1)
    throw Error(node.where, "ledger: expected one of method, accel and edit");
  if (edit != nullptr) {
    row.edit = &find_by_name(ledger_edits(), "edit", read_text(*edit, "ledger.edit"), edit->where);
    row.decision = &find_by_name(ledger_decisions(), "decision", row.edit->decision, edit->where);
    return;
  }
  row.of_structure = accel != nullptr;
  const ConfigNode path{std::string("path"), node.where, node.where};
  const ConfigNode own = method_table(accel != nullptr ? *accel : method != nullptr ? *method : path);
  const auto with = [&](const std::string& key) {
    return read_method(method_table(own, reader.need(key), "ledger." + key), row.of_structure);
  };
  (row.of_structure ? row.accel : row.method) = read_method(own, row.of_structure);
  row.with = with("on");
  row.without = with("off");
  if (row.with->label() == row.without->label())
    throw Error(node.where, "ledger: on and off are the same; expected parameters that differ");
  read_decision(reader, node, row);
}

LedgerRow read_row(const ConfigNode& node, std::uint64_t samples) {
  TableReader reader(node, "ledger", "tables { component, method, on, off, … }");
  LedgerRow row;
  row.component = reader.needed_text("component");
  row.method = {"path", {}, node.where};
  row.accel = default_accel();
  row.samples = samples;
  reader.whole("samples", row.samples, 1, 1'000'000);
  reader.text("kept", row.kept);
  read_switch(reader, node, row);
  reader.finish();
  return row;
}

// `samples`: of the budget.
LedgerChoice read_ledger(const ConfigNode& ledger, std::uint64_t samples) {
  LedgerChoice choice;
  for (const ConfigNode& node : read_tables(ledger, "ledger")) {
    LedgerRow row = read_row(node, samples);
    for (const LedgerRow& other : choice.rows)
      if (other.component == row.component && other.owner() == row.owner())
        throw Error(node.where, fmt::format("ledger: '{}' of {} stands there twice", row.component, row.owner()));
    choice.rows.push_back(std::move(row));
  }
  return choice;
}

// --- the work ---

class LedgerWork final : public SceneWork {
 public:
  LedgerWork(const RunPlan& plan, RunObserver& observer)
      : SceneWork(plan, observer), choice_(choice_of<LedgerChoice>(plan.config)) {}

  std::unique_ptr<KindRecord> begin(const Cell& cell) override {
    const LedgerRow& row = choice_.rows[cell.integrator];
    const ScenePlace& at = place(cell);
    auto record = std::make_unique<LedgerRecord>();
    record->on = row.always_on;
    record->why = row.always_on ? "by default" : "not by default";
    if (row.decision != nullptr) {
      MadeDecision made = row.decision->make({at.scene, at.needs, at.resolution, row.samples});
      record->on = made.on;
      record->why = std::move(made.why);
    }
    record->switched = row.edit != nullptr ? row.edit->name : (record->on ? *row.without : *row.with).label();
    record->kept = row.kept;
    record->iterations = row.samples;
    return record;
  }

  void refer(const std::string& scene, RunDirectory& directory) override {
    for (const Cell& cell : plan_.cells)
      if (cell.name.scene == scene) {
        make_reference_of(cell, directory);
        return;
      }
  }

  void fill(const Cell& cell, KindRecord& filled, RunDirectory& directory, const Progress& progress) override {
    auto& record = static_cast<LedgerRecord&>(filled);
    const LedgerRow& row = choice_.rows[cell.integrator];
    const ScenePlace& at = place(cell);
    std::optional<Scene> edited;
    if (row.edit != nullptr) {
      edited = record.on ? row.edit->without(at.scene) : row.edit->with(at.scene);
      if (!edited) {
        record.inapplicable = "it cannot be taken out of a scene that holds quadrics";
        return;
      }
    }
    const Reference& reference = reference_of(cell, directory);
    record.reference = reference.rendered.source;
    record.relmse_floor = reference.rendered.relmse_floor;
    const SceneNeeds edited_needs = edited ? scene_needs(*edited) : at.needs;
    const Method& switched = record.on || row.edit != nullptr ? row.without.value_or(row.method) : *row.with;
    const Budget budget = Budget::of_iterations(row.samples);
    const auto render = [&](bool flip, std::uint64_t seed) {
      const Method &accel = flip && row.of_structure ? switched : row.accel,
                   &method = flip && !row.of_structure ? switched : row.method;
      CellTask task{
          flip && edited ? *edited : at.scene, flip ? edited_needs : at.needs, accel, method, seed, at.resolution, budget};
      task.reference = &reference.rendered.image;
      task.metrics = {"relmse"};
      return run_cell(task);
    };
    for (std::size_t i = 0; i < plan_.config.seeds.size(); ++i) {
      const std::uint64_t seed = plan_.config.seeds[i];
      const bool first = i % 2 == 1;  // which way goes first alternates, too
      const CellResult a = render(first, seed), b = render(!first, seed);
      const CellResult &own = first ? b : a, &other = first ? a : b;
      record.bias = bias_name(own.expectation.bias);
      record.mse_exponent = own.expectation.mse_exponent;
      const CheckpointRecord &end = own.checkpoints.back(), &other_end = other.checkpoints.back();
      for (const CheckpointRecord* checkpoint : {&end, &other_end})
        if (!checkpoint->metrics.contains("relmse"))
          throw std::runtime_error(fmt::format("the relMSE of seed {} is not finite", seed));
      record.trials.push_back({seed, end.metrics.at("relmse"), other_end.metrics.at("relmse"), end.cpu_s, other_end.cpu_s,
                               own.image_hash == other.image_hash});
      progress((static_cast<double>(i) + 1) / static_cast<double>(plan_.config.seeds.size()), record.iterations);
    }
  }

 private:
  // Cells of a scene follow each other, so that one reference is kept.
  const Reference& reference_of(const Cell& cell, RunDirectory& directory) {
    if (!reference_ || reference_of_ != cell.scene) make_reference_of(cell, directory);
    if (!reference_->failure.empty()) throw Error(reference_->failure);
    return *reference_;
  }

  void make_reference_of(const Cell& cell, RunDirectory& directory) {
    const ScenePlace& at = place(cell);
    reference_ = make_run_reference(directory,
                                    {at.scene, at.needs, cell.name.scene, at.resolution,
                                     plan_.config.reference.of_scene(cell.scene), plan_.threads, &observer_},
                                    ReferenceCache::standard(plan_.config.path));
    reference_of_ = cell.scene;
  }

  const LedgerChoice& choice_;
  std::optional<Reference> reference_;
  std::size_t reference_of_ = 0;
};

class LedgerKind final : public RecordKind<LedgerRecord, LedgerWork> {
 public:
  LedgerKind() : RecordKind({"accels"}, {"reference"}) {}

  std::vector<std::string> keys() const override { return {"ledger"}; }
  std::vector<std::string> measures() const override { return measured_code({"experiments/kinds/ledger"}); }
  std::string beside() const override { return "[[ledger]], whose rows name methods"; }
  int threads(const RunPlan&) const override { return 1; }

  void read(const ConfigNode& root, ExperimentConfig& config) const override {
    const ConfigNode& rows = *find_key(root, "ledger");
    require_scenes(config);
    if (!config.budget.samples || config.budget.time_s || config.budget.error)
      throw Error(rows.key_where, "ledger: expected budget = { samples = N } beside it, and no other limit");
    if (const ConfigNode* ladder = find_key(*find_key(root, "budget"), "checkpoints"))
      throw Error(ladder->key_where, "budget.checkpoints: expected none beside [[ledger]], which measures at the end alone");
    config.choice = std::make_shared<LedgerChoice>(read_ledger(rows, *config.budget.samples));
  }

  std::vector<std::string> quick(const ConfigNode&) const override { return {"seeds=3", "resolution=[16, 16]"}; }

  std::vector<Cell> cells(const ExperimentConfig& config) const override {
    const auto& rows = choice_of<LedgerChoice>(config).rows;
    std::vector<Cell> cells;
    for (std::size_t s = 0; s < config.scenes.size(); ++s)
      for (std::size_t i = 0; i < rows.size(); ++i)
        cells.push_back({s, 0, i, {config.scenes[s].name, rows[i].owner(), rows[i].component, 1}});
    return cells;
  }

  std::vector<std::string> resolved(const ExperimentConfig& config) const override {
    std::vector<std::string> texts;
    for (const LedgerRow& row : choice_of<LedgerChoice>(config).rows) {
      texts.insert(texts.end(), {resolved_integrator(row.method), resolved_accel(row.accel)});
      for (const std::optional<Method>& method : {row.with, row.without})
        if (method) texts.push_back(row.of_structure ? resolved_accel(*method) : resolved_integrator(*method));
    }
    return texts;
  }

  std::string effort(const ExperimentConfig& config) const override {
    return fmt::format("a component as it is and switched, under {} seeds", config.seeds.size());
  }

  KindReport report(const RunLog& log) const override { return ledger_report(log); }
  std::string summary(const RunLog& log) const override { return ledger_summary(log); }
};

}  // namespace

const ExperimentKind& ledger_kind() { return the_kind<LedgerKind>(); }

}  // namespace etendue
