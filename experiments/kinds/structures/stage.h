// A scene with all that an integrator, or a part of one, needs to work on it without the harness.
#pragma once

#include "experiments/run/run_cell.h"

namespace etendue {

class Stage {
 public:
  // Scene and structure must outlive this.
  Stage(const Scene& scene, const RayQuery& rays, ivec2 resolution, std::uint64_t seed)
      : needs_(scene_needs(scene)),
        lights_(scene),
        context_(context_of(scene, needs_, rays, lights_, seed, resolution, phases_)) {}
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  RenderContext& context() { return context_; }
  const RenderContext& context() const { return context_; }

 private:
  SceneNeeds needs_;
  LightSampler lights_;
  PhaseTimes phases_;
  RenderContext context_;
};

}  // namespace etendue
