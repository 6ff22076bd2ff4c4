// A scene with all that a RenderContext refers to, for tests of an integrator's parts.
#pragma once

#include "accel/registry.h"
#include "framework/core/parallel.h"
#include "framework/integrator.h"

namespace etendue::testing {

class SceneContext {
 public:
  explicit SceneContext(Scene owned, ivec2 resolution = {8, 8}, std::uint64_t seed = 5)
      : scene(std::move(owned)),
        needs_(scene_needs(scene)),
        lights_(scene),
        rays_(find_ray_structure("binned-sah", {}).make(scene, {})),
        context{
            .scene = scene,
            .needs = needs_,
            .rays = *rays_,
            .lights = lights_,
            .seed = seed,
            .resolution = resolution,
            .phases = phases_,
            .make_points = [](const std::string& name) { return find_point_structure(name, {}).make(); },
            .make_records = [](const std::string& name, const Bounds& b) { return find_record_structure(name, {}).make(b); }} {}
  SceneContext(const SceneContext&) = delete;
  SceneContext& operator=(const SceneContext&) = delete;

  const Scene scene;

 private:
  SceneNeeds needs_;
  LightSampler lights_;
  std::unique_ptr<RayQuery> rays_;
  PhaseTimes phases_;

 public:
  RenderContext context;
};

}  // namespace etendue::testing
