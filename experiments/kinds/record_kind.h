// Shared by kinds of experiments whose cells end in one record each: the way from plan to log and report.
//
// A record lists its fields as fields.h asks, and names its lines of the log: `static constexpr const char* type`. Its work is
// made of the plan and the observer.
#pragma once

#include "experiments/kind.h"
#include "experiments/log/field_list.h"
#include "experiments/run/run.h"
#include "experiments/run/run_directory.h"
#include "framework/scene/needs.h"

#include <functional>
#include <map>
#include <memory>
#include <optional>

namespace etendue {

// The work of a kind of experiment on its cells. The record's cell, manifest, status and error are the execution's.
class RecordWork {
 public:
  // Tells how far a cell is, from 0 to 1, and how many steps that took.
  using Progress = std::function<void(double share, std::uint64_t steps)>;

  virtual ~RecordWork() = default;
  virtual void remember(const KindRecord&) {}  // done by an earlier run
  // Before any cell runs, of all cells, so that a file that cannot be read is known at once. May throw: nothing runs then.
  virtual void load(const Cell&) {}
  // The scene of a cell that was loaded, whose records count only as long as it stays as it is; nullopt: none, or one that
  // cannot change.
  struct SceneState {
    std::string name, path;
    std::uint64_t hash = 0;
  };
  virtual std::optional<SceneState> scene(const Cell&) { return std::nullopt; }
  // Makes the reference of a scene that an earlier run measured against, and notes it. A kind that has references does.
  virtual void refer(const std::string&, RunDirectory&) {}
  // A record of what is known before the cell runs; it stands in the log whether the cell fails or not.
  virtual std::unique_ptr<KindRecord> begin(const Cell&) = 0;
  // May throw: the cell has failed then.
  virtual void fill(const Cell&, KindRecord&, RunDirectory&, const Progress&) = 0;
  // How often structures disagreed, in what this run filled in.
  virtual std::uint64_t disagreements() const { return 0; }
};

// The manifest names `threads`.
RunSummary execute_records(const RunPlan& plan, int threads, RunObserver& observer, RecordWork& work);

template <class Record, class Work>
class RecordKind : public ExperimentKind {
 public:
  // Such experiments render no images to compare; `also` are further keys that would change nothing, and `used` those of the
  // usual ones that do.
  explicit RecordKind(std::vector<std::string> also, const std::vector<std::string>& used = {})
      : useless_{"integrators", "structures", "reference", "metrics", "confidence", "regions", "predictions", "elsewhere"} {
    useless_.insert(useless_.end(), also.begin(), also.end());
    for (const std::string& key : used) std::erase(useless_, key);
  }

  std::vector<std::string> useless() const override { return useless_; }
  std::string record_type() const override { return Record::type; }
  std::shared_ptr<KindRecord> read_record(const Json& json) const override {
    return std::make_shared<Record>(read_value<Record>(json));
  }
  std::vector<Field> record_fields() const override { return fields_of<Record>(); }
  RunSummary run(const RunPlan& plan, RunObserver& observer, const CellFunction&) const override {
    Work work(plan, observer);
    return execute_records(plan, threads(plan), observer, work);
  }
  virtual int threads(const RunPlan& plan) const { return plan.threads; }

 private:
  std::vector<std::string> useless_;
};

// A scene that was read, and what all work on it starts from.
struct ScenePlace {
  ScenePlace(Scene read, const RunPlan& plan)
      : scene(std::move(read)), needs(scene_needs(scene)), resolution(plan.config.resolution.value_or(scene.resolution)) {}

  Scene scene;
  SceneNeeds needs;
  ivec2 resolution;
};

// Work on an experiment's scenes, of which each is loaded once.
class SceneWork : public RecordWork {
 public:
  SceneWork(const RunPlan& plan, RunObserver& observer) : plan_(plan), observer_(observer) {}

  void load(const Cell& cell) override {
    const auto index = scene_index(cell);
    if (index && !places_.contains(*index))
      places_.try_emplace(*index, load_choice(plan_, plan_.config.scenes[*index], observer_), plan_);
  }
  std::optional<SceneState> scene(const Cell& cell) override {
    const auto index = scene_index(cell);
    if (!index) return std::nullopt;
    const SceneChoice& choice = plan_.config.scenes[*index];
    return SceneState{choice.name, choice.path, places_.at(*index).scene.hash()};
  }
  std::uint64_t disagreements() const override { return disagreements_; }

 protected:
  // Which of the experiment's scenes it is; nullopt: the cell has none.
  virtual std::optional<std::size_t> scene_index(const Cell& cell) const { return cell.scene; }
  const ScenePlace& place(const Cell& cell) const { return places_.at(scene_index(cell).value()); }

  const RunPlan& plan_;
  RunObserver& observer_;
  std::uint64_t disagreements_ = 0;

 private:
  std::map<std::size_t, ScenePlace> places_;
};

}  // namespace etendue
