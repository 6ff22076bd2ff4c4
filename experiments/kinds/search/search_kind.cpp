#include "experiments/kinds/search/search_kind.h"

#include "experiments/kinds/search/measure_search.h"
#include "experiments/kinds/search/search_report.h"
#include "experiments/run/record_run.h"

#include <fmt/format.h>
#include <map>

namespace etendue {

namespace {

std::vector<SearchSet> config_sets(const ExperimentConfig& config) {
  std::vector<std::string> names;
  for (const SceneChoice& scene : config.scenes) names.push_back(scene.name);
  return search_sets(choice_of<SearchChoice>(config), names);
}

class SearchWork final : public RecordWork {
 public:
  SearchWork(const RunPlan& plan, RunObserver& observer) : plan_(plan), observer_(observer), sets_(config_sets(plan.config)) {}

  void load(const Cell& cell) override {
    const auto scene = sets_[cell.scene].scene;
    if (scene && !scenes_.contains(*scene)) scenes_.emplace(*scene, load_choice(plan_, plan_.config.scenes[*scene], observer_));
  }

  std::optional<SceneState> scene(const Cell& cell) override {
    const auto scene = sets_[cell.scene].scene;
    if (!scene) return std::nullopt;
    const SceneChoice& choice = plan_.config.scenes[*scene];
    return SceneState{choice.name, choice.path, scenes_.at(*scene).hash()};
  }

  std::unique_ptr<KindRecord> begin(const Cell&) override { return std::make_unique<SearchRecord>(); }

  void fill(const Cell& cell, KindRecord& filled, RunDirectory&, const Progress& progress) override {
    auto& record = static_cast<SearchRecord&>(filled);
    const auto& choice = choice_of<SearchChoice>(plan_.config);
    const SearchSet& set = sets_[cell.scene];
    const auto steps = static_cast<std::uint64_t>(choice.repetitions);
    record = measure_search({choice, set, set.scene ? &scenes_.at(*set.scene) : nullptr, choice.counts[cell.integrator],
                             cell.name.seed, [&](double share) { progress(share, steps); }});
    disagreements_ += record.disagreements;
  }

  std::uint64_t disagreements() const override { return disagreements_; }

 private:
  const RunPlan& plan_;
  RunObserver& observer_;
  std::vector<SearchSet> sets_;
  std::map<std::size_t, Scene> scenes_;
  std::uint64_t disagreements_ = 0;
};

class SearchKind final : public ExperimentKind {
 public:
  std::vector<std::string> keys() const override { return {"points", "records"}; }
  std::vector<std::string> useless() const override {
    return {"integrators", "accels",     "structures", "budget",  "reference",  "metrics",
            "confidence",  "resolution", "threads",    "regions", "predictions"};
  }
  std::string beside() const override { return "[points] or [records], which render nothing"; }

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

  RunSummary run(const RunPlan& plan, RunObserver& observer, const CellFunction&) const override {
    SearchWork work(plan, observer);
    return execute_records(plan, 1, observer, work);
  }

  std::string record_type() const override { return "search"; }
  std::shared_ptr<KindRecord> read_record(const Json& json) const override {
    return std::make_shared<SearchRecord>(read_search_record(json));
  }
  KindReport report(const RunLog& log) const override { return search_report(log); }
  std::string summary(const RunLog& log) const override { return search_summary(log); }
};

}  // namespace

const ExperimentKind& search_kind() {
  static const SearchKind kind;
  return kind;
}

}  // namespace etendue
