#include "experiments/kinds/search/search_run.h"

#include "experiments/kinds/search/measure_search.h"
#include "experiments/kinds/search/search_report.h"
#include "experiments/run/record_run.h"

#include <map>

namespace etendue {

namespace {

class SearchWork final : public RecordWork<SearchRecord> {
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

  void fill(const Cell& cell, SearchRecord& record, RunDirectory&, const Progress& progress) override {
    const SearchChoice& choice = *plan_.config.search;
    const SearchSet& set = sets_[cell.scene];
    const auto steps = static_cast<std::uint64_t>(choice.repetitions);
    record = measure_search({choice, set, set.scene ? &scenes_.at(*set.scene) : nullptr, choice.counts[cell.integrator],
                             cell.name.seed, [&](double share) { progress(share, steps); }});
    disagreements_ += record.disagreements;
  }

  std::uint64_t disagreements() const override { return disagreements_; }
  std::string summary(const RunLog& log) const override { return search_summary(log); }

 private:
  const RunPlan& plan_;
  RunObserver& observer_;
  std::vector<SearchSet> sets_;
  std::map<std::size_t, Scene> scenes_;
  std::uint64_t disagreements_ = 0;
};

}  // namespace

RunSummary execute_search(const RunPlan& plan, RunObserver& observer) {
  SearchWork work(plan, observer);
  return execute_records(plan, 1, observer, work);
}

}  // namespace etendue
