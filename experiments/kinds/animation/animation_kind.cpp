#include "experiments/kinds/animation/animation_kind.h"

#include "experiments/config/config_keys.h"
#include "experiments/kinds/animation/animation.h"
#include "experiments/kinds/animation/animation_report.h"
#include "experiments/run/record_run.h"

#include <fmt/format.h>
#include <map>

namespace etendue {

namespace {

class AnimationWork final : public RecordWork {
 public:
  AnimationWork(const RunPlan& plan, RunObserver& observer) : plan_(plan), observer_(observer) {}

  void load(const Cell& cell) override {
    if (!scenes_.contains(cell.scene))
      scenes_.emplace(cell.scene, load_choice(plan_, plan_.config.scenes[cell.scene], observer_));
  }

  std::optional<SceneState> scene(const Cell& cell) override {
    const SceneChoice& choice = plan_.config.scenes[cell.scene];
    return SceneState{choice.name, choice.path, scenes_.at(cell.scene).hash()};
  }

  std::unique_ptr<KindRecord> begin(const Cell&) override { return std::make_unique<AnimationRecord>(); }

  void fill(const Cell& cell, KindRecord& filled, RunDirectory&, const Progress& progress) override {
    auto& record = static_cast<AnimationRecord&>(filled);
    const auto& choice = choice_of<AnimationChoice>(plan_.config);
    const AnimationTask task{
        scenes_.at(cell.scene),
        plan_.config.accels[cell.accel],
        choice.motions[cell.integrator],
        choice.policies,
        choice.frames,
        choice.resolution,
        choice.repetitions,
        cell.name.seed,
        plan_.threads,
        [&](int frame) { progress(static_cast<double>(frame) / choice.frames, static_cast<std::uint64_t>(frame)); }};
    record = run_animation(task);
    for (const PolicyRecord& policy : record.policies) disagreements_ += policy.disagreements;
  }

  std::uint64_t disagreements() const override { return disagreements_; }

 private:
  const RunPlan& plan_;
  RunObserver& observer_;
  std::map<std::size_t, Scene> scenes_;
  std::uint64_t disagreements_ = 0;
};

class AnimationKind final : public ExperimentKind {
 public:
  std::vector<std::string> keys() const override { return {"dynamic"}; }
  std::vector<std::string> useless() const override {
    return {"integrators", "structures", "budget",  "reference",  "metrics",
            "confidence",  "resolution", "regions", "predictions"};
  }
  std::string beside() const override { return "[dynamic], which renders nothing"; }

  void read(const ConfigNode& root, ExperimentConfig& config) const override {
    config.choice = std::make_shared<AnimationChoice>(read_animation(*find_key(root, "dynamic")));
    config.accels = read_builders(find_key(root, "accels"));
    require_scenes(config);
  }

  std::vector<std::string> quick(const ConfigNode& root) const override {
    if (!find_key(root, "dynamic")->table()) return {};
    return {"seeds=1", "dynamic.frames=10", "dynamic.resolution=32", "dynamic.repetitions=1"};
  }

  std::vector<Cell> cells(const ExperimentConfig& config) const override {
    return make_matrix(config, choice_of<AnimationChoice>(config).motions);
  }

  std::string effort(const ExperimentConfig& config) const override {
    const auto& choice = choice_of<AnimationChoice>(config);
    return fmt::format("{} frames under {} policies, {}² pixels traced {} times", choice.frames, choice.policies.size(),
                       choice.resolution, choice.repetitions);
  }

  RunSummary run(const RunPlan& plan, RunObserver& observer, const CellFunction&) const override {
    AnimationWork work(plan, observer);
    return execute_records(plan, plan.threads, observer, work);
  }

  std::string record_type() const override { return "animation"; }
  std::shared_ptr<KindRecord> read_record(const Json& json) const override {
    return std::make_shared<AnimationRecord>(read_animation_record(json));
  }
  KindReport report(const RunLog& log) const override { return animation_report(log); }
  std::string summary(const RunLog& log) const override { return animation_summary(log); }
};

}  // namespace

const ExperimentKind& animation_kind() {
  static const AnimationKind kind;
  return kind;
}

}  // namespace etendue
