#include "experiments/config/config_keys.h"
#include "experiments/kinds/animation/animation.h"
#include "experiments/kinds/record_kind.h"

#include <fmt/format.h>

namespace etendue {

void list_fields(auto& f, FieldsOf<PolicyRecord> auto& r) {
  FIELDS(policy, update_s, trace_s, sah_cost, rebuilt, disagreements);
}

void list_fields(auto& f, FieldsOf<AnimationRecord> auto& r) {
  f.cell(r.cell, "accel", "motion");
  list_ending(f, r);
  FIELDS(primitives, rays, changed, rebuilt_sah_cost, policies);
}

std::string AnimationRecord::line() const { return line_of(type, *this); }

namespace {

class AnimationWork final : public SceneWork {
 public:
  using SceneWork::SceneWork;

  std::unique_ptr<KindRecord> begin(const Cell&) override { return std::make_unique<AnimationRecord>(); }

  void fill(const Cell& cell, KindRecord& filled, RunDirectory&, const Progress& progress) override {
    auto& record = static_cast<AnimationRecord&>(filled);
    const auto& choice = choice_of<AnimationChoice>(plan_.config);
    const auto tell = [&](int frame) {
      progress(static_cast<double>(frame) / choice.frames, static_cast<std::uint64_t>(frame));
    };
    record = run_animation({place(cell).scene, plan_.config.accels[cell.accel], choice.motions[cell.integrator], choice,
                            cell.name.seed, plan_.threads, tell});
    for (const PolicyRecord& policy : record.policies) disagreements_ += policy.disagreements;
  }
};

class AnimationKind final : public RecordKind<AnimationRecord, AnimationWork> {
 public:
  AnimationKind() : RecordKind({"budget", "resolution"}) {}

  std::vector<std::string> keys() const override { return {"dynamic"}; }
  std::vector<std::string> measures() const override { return measured_code({"experiments/kinds/animation"}); }
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

  KindReport report(const RunLog& log) const override { return animation_report(log); }
  std::string summary(const RunLog& log) const override { return animation_summary(log); }
};

}  // namespace

const ExperimentKind& animation_kind() { return the_kind<AnimationKind>(); }

}  // namespace etendue
