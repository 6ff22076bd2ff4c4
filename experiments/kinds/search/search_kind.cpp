#include "accel/registry.h"
#include "experiments/kinds/record_kind.h"
#include "experiments/kinds/rows.h"
#include "experiments/kinds/search/measure_search.h"
#include "experiments/kinds/search/search_curves.h"

#include <fmt/format.h>

namespace etendue {

void list_fields(auto& f, FieldsOf<SearchFigure> auto& r) {
  FIELDS(structure, measure, parameter);
  f("value", r.value.median);
  f("low", r.value.low);
  f("high", r.value.high);
  f("found", r.found);
}

void list_fields(auto& f, FieldsOf<SearchRecord> auto& r) {
  f.cell(r.cell, "accel", "size");
  list_ending(f, r);
  FIELDS(kind, set, varies, variation, count, checked, disagreements, figures);
}

std::string SearchRecord::line() const { return line_of(type, *this); }

namespace {

// Ascending, each once, where the table has the key.
template <class Number>
void read_ascending(TableReader& reader, const std::string& owner, const char* key, std::vector<Number>& values, double low,
                    double high) {
  const ConfigNode* node = reader.find(key);
  if (!node) return;
  values.clear();
  if (node->array() && node->array()->empty()) return;
  const std::string name = owner + "." + key;
  for (const ConfigNode* element : list_elements(*node, name, "an array of numbers")) {
    Number value;
    if constexpr (std::is_integral_v<Number>)
      value = static_cast<Number>(read_whole(*element, name, static_cast<std::int64_t>(low), static_cast<std::int64_t>(high)));
    else
      value = read_number(*element, name, low, high);
    if (!values.empty() && !(value > values.back()))
      throw Error(element->where, fmt::format("{}: {} behind {}; expected ascending numbers", name, value, values.back()));
    values.push_back(value);
  }
}

}  // namespace

SearchChoice read_search(const ConfigNode& node, bool records) {
  const std::string owner = records ? "records" : "points";
  TableReader reader(node, owner, "a table { structures, counts, … }");
  SearchChoice choice;
  choice.records = records;
  const std::vector<std::string> all = records ? entry_names(record_structures()) : entry_names(point_structures());
  const ConfigNode* wanted = reader.find("structures");
  const bool every = !wanted || (wanted->text() && *wanted->text() == "all");
  choice.structures = every ? all : read_names(*wanted, owner + ".structures", "structure", all);
  choice.counts = {10, 100, 1000, 10000, 100000};
  if (!records) choice.counts.push_back(1000000);
  read_ascending(reader, owner, "counts", choice.counts, 1, 1e8);
  if (choice.counts.empty()) throw Error(node.where, owner + ".counts: none; expected at least one number");
  if (records) {
    choice.variations = {1, 10, 100};
    read_ascending(reader, owner, "spreads", choice.variations, 1, 1e6);
    if (choice.variations.empty()) throw Error(node.where, "records.spreads: none; expected at least one number");
    reader.number("covering", choice.covering, 0.01, 1e6);
  } else {
    choice.neighbours = {1, 10, 50, 500};
    read_ascending(reader, owner, "neighbours", choice.neighbours, 1, 1e6);
    read_ascending(reader, owner, "contrasts", choice.variations, 1, 1e8);
  }
  reader.whole("queries", choice.queries, 1, 10'000'000);
  reader.whole("repetitions", choice.repetitions, 1, 1000);
  reader.finish();
  return choice;
}

std::vector<SearchSet> search_sets(const SearchChoice& choice, const std::vector<std::string>& scenes) {
  std::vector<SearchSet> sets;
  const char* const varies = choice.records ? "spread" : "contrast";
  const auto add_variations = [&](const std::string& name, std::optional<std::size_t> scene) {
    for (const double v : choice.variations)
      sets.push_back({name, fmt::format("{} {}={:g}", name, varies, v), scene, varies, v});
  };
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    if (choice.records)
      add_variations(scenes[s], s);
    else
      sets.push_back({scenes[s], scenes[s], s, "", 0});
  }
  if (!choice.records) add_variations("clustered", std::nullopt);
  return sets;
}

namespace {

std::vector<SearchSet> config_sets(const ExperimentConfig& config) {
  return search_sets(choice_of<SearchChoice>(config), mapped(config.scenes, &SceneChoice::name));
}

class SearchWork final : public SceneWork {
 public:
  SearchWork(const RunPlan& plan, RunObserver& observer) : SceneWork(plan, observer), sets_(config_sets(plan.config)) {}

  std::unique_ptr<KindRecord> begin(const Cell&) override { return std::make_unique<SearchRecord>(); }

  void fill(const Cell& cell, KindRecord& filled, RunDirectory&, const Progress& progress) override {
    auto& record = static_cast<SearchRecord&>(filled);
    const auto& choice = choice_of<SearchChoice>(plan_.config);
    const SearchSet& set = sets_[cell.scene];
    const auto steps = static_cast<std::uint64_t>(choice.repetitions);
    record = measure_search({choice, set, set.scene ? &place(cell).scene : nullptr, choice.counts[cell.integrator],
                             cell.name.seed, [&](double share) { progress(share, steps); }});
    disagreements_ += record.disagreements;
  }

 private:
  std::optional<std::size_t> scene_index(const Cell& cell) const override { return sets_[cell.scene].scene; }

  std::vector<SearchSet> sets_;
};

class SearchKind final : public RecordKind<SearchRecord, SearchWork> {
 public:
  SearchKind() : RecordKind({"accels", "budget", "resolution", "threads"}) {}

  std::vector<std::string> keys() const override { return {"points", "records"}; }
  std::vector<std::string> measures() const override { return measured_code({"experiments/kinds/search"}); }
  std::string beside() const override { return "[points] or [records], which render nothing"; }
  int threads(const RunPlan&) const override { return 1; }

  void read(const ConfigNode& root, ExperimentConfig& config) const override {
    const ConfigNode *points = find_key(root, "points"), *records = find_key(root, "records");
    if (points && records)
      throw Error(records->key_where, fmt::format("records: of no use beside {}; expected only one of them", beside()));
    config.choice = std::make_shared<SearchChoice>(read_search(points ? *points : *records, records != nullptr));
    if (config_sets(config).empty())
      throw Error(Location{config.path}, fmt::format("nothing to search; expected scenes = [\"builtin:cornell-box\", …]{}",
                                                     points ? " or points.contrasts" : ""));
  }

  std::vector<std::string> quick(const ConfigNode& root) const override {
    const ConfigNode* points = find_key(root, "points");
    if (points ? !points->table() : !find_key(root, "records")->table()) return {};
    if (points) return {"points.counts=[10, 1000, 10000]", "points.queries=200", "points.repetitions=3"};
    return {"records.counts=[10, 100, 1000]", "records.queries=200", "records.repetitions=3"};
  }

  // A set's sizes stand together.
  std::vector<Cell> cells(const ExperimentConfig& config) const override {
    const auto& choice = choice_of<SearchChoice>(config);
    const std::vector<SearchSet> sets = config_sets(config);
    std::vector<Cell> cells;
    for (const std::uint64_t seed : config.seeds)
      for (std::size_t s = 0; s < sets.size(); ++s)
        for (std::size_t n = 0; n < choice.counts.size(); ++n)
          cells.push_back({s, 0, n, {sets[s].label, choice.kind(), fmt::format("count={}", choice.counts[n]), seed}});
    return cells;
  }

  std::string effort(const ExperimentConfig& config) const override {
    const auto& choice = choice_of<SearchChoice>(config);
    return fmt::format("{} structures, {} repetitions, at most {} queries a batch", choice.structures.size(),
                       choice.repetitions, choice.queries);
  }

  KindReport report(const RunLog& log) const override { return search_report(log); }
  std::string summary(const RunLog& log) const override { return search_summary(log); }
};

}  // namespace

const ExperimentKind& search_kind() { return the_kind<SearchKind>(); }

}  // namespace etendue
