// What becomes of a tree whose objects move: claims about refitting, on the motions and policies of experiments/dynamic.toml.
#include "accel/bvh/bvh.h"
#include "accel/bvh/dynamic/dynamic_bvh.h"
#include "experiments/kinds/claims/claim_scenes.h"
#include "experiments/kinds/claims/measure_tools.h"
#include "experiments/statistics/statistics.h"
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

ParamMap number_param(const char* key, double value) { return {{key, {value, {}}}}; }

// Time of tracing by the tree that was refitted for all the frames, over that by a tree built anew at the end.
Measured refit_slowdown(const MeasureTask& task, const Scene& scene, const ClaimRays& rays, const char* name,
                        const ParamMap& params, MeasureResult& result) {
  Moving moving(scene, name, params, task.seed);
  DynamicBvh refitted(moving.geometry, moving.build, {ChangePolicy::Kind::refit, {}});
  for (int frame = 1; frame <= frames; ++frame) {
    const std::vector<std::uint32_t> changed = moving.motion->pose(frame, moving.geometry);
    refitted.update(changed);
  }
  const Bvh anew(moving.geometry, moving.build(build_items(moving.geometry)));
  for (const Ray& ray : rays.closest) {
    const Hit a = anew.closest(ray), b = refitted.closest(ray);
    result.disagreements += a.t != b.t || a.primitive != b.primitive;
  }
  const Times times = take_turns(task, {[&] { trace_rays(refitted, rays); }, [&] { trace_rays(anew, rays); }});
  return ratio_of(times[0], times[1]);
}

MeasureResult measure_refit(const MeasureTask& task) {
  const Scene scene = load_claim_scene(task.scene, task.reading);
  const ClaimRays rays = record_claim_rays(scene, std::max(8, task.resolution / 2));
  MeasureResult result;
  result.add("scatter_few", refit_slowdown(task, scene, rays, "scatter", number_param("moving", 0.01), result));
  result.add("scatter", refit_slowdown(task, scene, rays, "scatter", number_param("moving", 0.05), result));
  result.add("twist", refit_slowdown(task, scene, rays, "twist", {}, result));
  result.add("wave", refit_slowdown(task, scene, rays, "wave", {}, result));
  return result;
}

// Seconds of all frames, updating and tracing, by each policy; the policies take turns in each frame.
std::vector<double> policy_seconds(const Scene& scene, const ClaimRays& rays, double moving_share, std::uint64_t seed) {
  using Kind = ChangePolicy::Kind;
  Moving moving(scene, "scatter", number_param("moving", moving_share), seed);
  std::vector<std::unique_ptr<DynamicBvh>> trees;
  for (const Kind kind : {Kind::hybrid, Kind::refit, Kind::rebuild})
    trees.push_back(std::make_unique<DynamicBvh>(moving.geometry, moving.build, ChangePolicy{kind, {}}));
  std::vector<double> seconds(trees.size(), 0);
  for (int frame = 1; frame <= frames; ++frame) {
    const std::vector<std::uint32_t> changed = moving.motion->pose(frame, moving.geometry);
    for (std::size_t i = 0; i < trees.size(); ++i) {
      seconds[i] += seconds_of([&] { trees[i]->update(changed); });
      seconds[i] += seconds_of([&] { trace_rays(*trees[i], rays); });
    }
  }
  return seconds;
}

// The policy over the best of the others, each repetition with other movements.
MeasureResult measure_policy(const MeasureTask& task) {
  const Scene scene = load_claim_scene(task.scene, task.reading);
  const ClaimRays rays = record_claim_rays(scene, std::max(8, task.resolution / 4));
  const int rounds = std::max(1, task.repetitions / 3);
  MeasureResult result;
  for (const auto& [share, name] : {std::pair{0.05, "five"}, std::pair{0.25, "quarter"}}) {
    std::vector<double> refit, rebuild;
    for (int round = 0; round < rounds; ++round) {
      const std::vector<double> s = policy_seconds(scene, rays, share, task.seed + static_cast<std::uint64_t>(round));
      refit.push_back(s[0] / s[1]);
      rebuild.push_back(s[0] / s[2]);
    }
    result.add(fmt::format("{}_over_refit", name).c_str(), summarise(refit));
    result.add(fmt::format("{}_over_rebuild", name).c_str(), summarise(rebuild));
  }
  result.remarks.push_back(
      fmt::format("Frames of {} rays ({} of them), updating and tracing; with more rays a frame a better tree weighs more than "
                  "its update. Our "
                  "hybrid judges subtrees once a tenth of the objects has changed since it last did, in however many frames.",
                  rays.closest.size() + rays.shadow.size(), frames));
  return result;
}

}  // namespace

std::vector<Measurement> change_measurements() {
  constexpr auto factor = FigureKind::factor;
  return {{"refit",
           "time with a tree refitted for a hundred frames over that with one built anew at their end",
           {{"scatter_few", factor, "1 % of the objects put elsewhere each frame"},
            {"scatter", factor, "5 % of the objects put elsewhere each frame"},
            {"twist", factor, "twist"},
            {"wave", factor, "wave"}},
           measure_refit},
          {"policy",
           "time of a hundred frames with the hybrid policy over that with the others",
           {{"five_over_refit", factor, "5 % moved a frame, hybrid over refit alone"},
            {"five_over_rebuild", factor, "5 % moved a frame, hybrid over rebuild"},
            {"quarter_over_refit", factor, "25 % moved a frame, hybrid over refit alone"},
            {"quarter_over_rebuild", factor, "25 % moved a frame, hybrid over rebuild"}},
           measure_policy}};
}

}  // namespace etendue
