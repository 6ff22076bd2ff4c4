// Experiments on change over time, [dynamic]: scenes that move, and what keeps a ray structure up to date while they do
// (docs/experiment-file.md has the keys; motions are framework/scene/motion.h's, policies accel/bvh/dynamic/change_policy.h's).
// A cell is one (scene, builder, motion, seed). Its policies take turns in each frame, so that a machine that slows down slows
// all of them.
#pragma once

#include "experiments/config/config.h"
#include "experiments/report/kind_report.h"
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

// Figures of each frame, from the rest position (frame 0, for which every tree is built) to the last.
struct PolicyRecord {
  std::string policy;
  std::vector<double> update_s;  // to bring the structure up to date; at frame 0, to build it
  std::vector<double> trace_s;   // of all rays of the frame, the median of its repetitions
  std::vector<double> sah_cost;
  std::vector<double> rebuilt;      // subtrees and primitives that went to the builder, in primitives of the scene
  std::uint64_t disagreements = 0;  // rays whose hits differ from those of a tree built anew
};

// One line of the log for each cell, with all policies: its "integrator" is the motion, its "accel" the builder.
struct AnimationRecord final : KindRecord {
  static constexpr const char* type = "animation";

  std::uint64_t primitives = 0;
  std::vector<double> rays;              // of each frame
  std::vector<double> changed;           // primitives that moved since the frame before, in primitives of the scene
  std::vector<double> rebuilt_sah_cost;  // of a tree built anew, beside all policies
  std::vector<PolicyRecord> policies;

  std::string line() const override;
};

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

// Time per frame, quality of the tree and speed of tracing, by policy.
KindReport animation_report(const RunLog& log);
std::string animation_summary(const RunLog& log);  // what `etendue run` prints at its end

}  // namespace etendue
