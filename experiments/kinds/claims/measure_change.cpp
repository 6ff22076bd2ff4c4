// Trees whose objects move: claims about refitting, on the motions and policies of experiments/dynamic.toml.
#include "accel/bvh/bvh.h"
#include "accel/bvh/dynamic/dynamic_bvh.h"
#include "experiments/kinds/claims/measurement.h"
#include "framework/scene/motion.h"

#include <fmt/format.h>

namespace etendue {

namespace {

constexpr int frames = 100;

struct Moving {
  Moving(const Scene& scene, const char* motion_name, const ParamMap& params, std::uint64_t seed)
      : motion(find_motion(motion_name, {}).make({scene.objects[0].geometry, frames, seed}, params)),
        geometry(motion->rest()),
        build(find_ray_structure("binned-sah", {}).builder({})) {}

  std::unique_ptr<Motion> motion;
  Geometry geometry;
  TreeBuilder build;
};

// Tracing by the tree that was refitted for all the frames, and by one built anew at the end.
void race_refitted(Trial& t, const TrialRays& rays, const std::string& name, const char* motion, const ParamMap& params) {
  Moving moving(t.scene, motion, params, t.task.seed);
  DynamicBvh refitted(moving.geometry, moving.build, {ChangePolicy::Kind::refit, {}});
  for (int frame = 1; frame <= frames; ++frame) refitted.update(moving.motion->pose(frame, moving.geometry));
  const Bvh anew(moving.geometry, moving.build(build_items(moving.geometry)));
  for (const Ray& ray : rays.closest) {
    const Hit a = anew.closest(ray), b = refitted.closest(ray);
    t.disagree(a.t != b.t || a.primitive != b.primitive);
  }
  t.race({{name + " refitted", tracing_all(refitted, rays)}, {name + " anew", tracing_all(anew, rays)}});
}

void measure_refit(Trial& t) {
  const TrialRays rays = t.record_rays(std::max(8, t.task.resolution / 2));
  race_refitted(t, rays, "scatter few", "scatter", params_of("moving=0.01"));
  race_refitted(t, rays, "scatter", "scatter", params_of("moving=0.05"));
  race_refitted(t, rays, "twist", "twist", {});
  race_refitted(t, rays, "wave", "wave", {});
}

// All frames, updating and tracing, by each policy; the policies take turns in each frame.
void time_policies(Trial& t, const TrialRays& rays, const std::string& name, double moving_share, std::uint64_t seed) {
  using Kind = ChangePolicy::Kind;
  Moving moving(t.scene, "scatter", params_of(fmt::format("moving={}", moving_share)), seed);
  struct Policy {
    std::string name;
    DynamicBvh tree;
    double seconds = 0;
  };
  std::deque<Policy> policies;
  for (const auto& [policy, kind] : {std::pair{" hybrid", Kind::hybrid}, {" refit", Kind::refit}, {" rebuild", Kind::rebuild}})
    policies.push_back({name + policy, DynamicBvh(moving.geometry, moving.build, ChangePolicy{kind, {}})});
  for (int frame = 1; frame <= frames; ++frame) {
    const std::vector<std::uint32_t> changed = moving.motion->pose(frame, moving.geometry);
    for (Policy& policy : policies) {
      policy.seconds += seconds_of([&] { policy.tree.update(changed); });
      policy.seconds += seconds_of([&] { trace_rays(policy.tree, rays); });
    }
  }
  for (const Policy& policy : policies) t.add_time(policy.name, policy.seconds);
}

// Each repetition has other movements.
void measure_policy(Trial& t) {
  const TrialRays rays = t.record_rays(std::max(8, t.task.resolution / 4));
  for (const auto& [name, share] : {std::pair{"five", 0.05}, {"quarter", 0.25}})
    for (int round = 0; round < std::max(1, t.task.repetitions / 3); ++round)
      time_policies(t, rays, name, share, t.task.seed + static_cast<std::uint64_t>(round));
  t.remark(
      fmt::format("Frames of {} rays ({} of them), updating and tracing; with more rays a frame a better tree weighs more "
                  "than its update. Our hybrid judges subtrees once a tenth of the objects has changed since it last did, in "
                  "however many frames.",
                  rays.size(), frames));
}

}  // namespace

std::vector<Measurement> change_measurements() {
  constexpr auto factor = FigureKind::factor;
  return {{"refit",
           "time with a tree refitted for a hundred frames over that with one built anew at their end",
           {{"scatter_few", factor, "1 % of the objects put elsewhere each frame", "scatter few refitted", "scatter few anew"},
            {"scatter", factor, "5 % of the objects put elsewhere each frame", "scatter refitted", "scatter anew"},
            {"twist", factor, "twist", "twist refitted", "twist anew"},
            {"wave", factor, "wave", "wave refitted", "wave anew"}},
           measure_refit},
          {"policy",
           "time of a hundred frames with the hybrid policy over that with the others",
           {{"five_over_refit", factor, "5 % moved a frame, hybrid over refit alone", "five hybrid", "five refit"},
            {"five_over_rebuild", factor, "5 % moved a frame, hybrid over rebuild", "five hybrid", "five rebuild"},
            {"quarter_over_refit", factor, "25 % moved a frame, hybrid over refit alone", "quarter hybrid", "quarter refit"},
            {"quarter_over_rebuild", factor, "25 % moved a frame, hybrid over rebuild", "quarter hybrid", "quarter rebuild"}},
           measure_policy}};
}

}  // namespace etendue
