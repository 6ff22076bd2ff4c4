#include "experiments/kinds/animation/animation_run.h"

#include "experiments/kinds/animation/animation_report.h"
#include "experiments/run/record_run.h"

#include <map>

namespace etendue {

namespace {

class AnimationWork final : public RecordWork<AnimationRecord> {
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

  void fill(const Cell& cell, AnimationRecord& record, RunDirectory&, const Progress& progress) override {
    const AnimationChoice& choice = *plan_.config.animation;
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
  std::string summary(const RunLog& log) const override { return animation_summary(log); }

 private:
  const RunPlan& plan_;
  RunObserver& observer_;
  std::map<std::size_t, Scene> scenes_;
  std::uint64_t disagreements_ = 0;
};

}  // namespace

RunSummary execute_animations(const RunPlan& plan, RunObserver& observer) {
  AnimationWork work(plan, observer);
  return execute_records(plan, plan.threads, observer, work);
}

}  // namespace etendue
