// Experiments on change over time, [dynamic]: scenes that move, and what keeps a ray structure up to date while they do
// (docs/experiment-file.md has the keys; motions are framework/scene/motion.h's, policies accel/bvh/dynamic/change_policy.h's).
// A cell is one (scene, builder, motion, seed). Its policies take turns in each frame, so that a machine that slows down slows
// all of them.
#pragma once

#include "experiments/config/config.h"
#include "experiments/kinds/animation/animation_record.h"
#include "framework/scene/scene.h"

#include <functional>
#include <string>
#include <vector>

namespace etendue {

struct AnimationChoice final : KindChoice {
  int frames = 100, resolution = 128, repetitions = 3;
  std::vector<Method> motions, policies;
};

// Reads the value of the key `dynamic`. Throws Error.
AnimationChoice read_animation(const ConfigNode& node);
// The `accels` of such an experiment: "all" is every builder. Throws Error where one cannot build for change.
std::vector<Method> read_builders(const ConfigNode* node);

struct AnimationTask {
  const Scene& scene;
  const Method& builder;
  const Method& motion;
  const AnimationChoice& choice;
  std::uint64_t seed = 1;
  int threads = 1;  // that update and trace
  std::function<void(int frame)> progress = {};
};

// `cell`, `manifest` and `status` are the caller's to fill. Throws Error for a scene with instances, or with nothing to move.
AnimationRecord run_animation(const AnimationTask& task);

}  // namespace etendue
