// What the log holds of an animation: one line per cell, with all policies, which take turns in each frame.
#pragma once

#include "experiments/log/log.h"

#include <cstdint>
#include <string>
#include <vector>

namespace etendue {

// Figures of each frame, from the rest position (frame 0, for which every tree is built) to the last.
struct PolicyRecord {
  std::string policy;
  std::vector<double> update_s;  // to bring the structure up to date; at frame 0, to build it
  std::vector<double> trace_s;   // of all rays of the frame, the median of its repetitions
  std::vector<double> sah_cost;
  std::vector<double> rebuilt;      // subtrees and primitives that went to the builder, in primitives of the scene
  std::uint64_t disagreements = 0;  // rays whose hits differ from those of a tree built anew
};

// The cell's "integrator" is the motion, its "accel" the builder.
struct AnimationRecord final : KindRecord {
  static constexpr const char* type = "animation";

  std::uint64_t primitives = 0;
  std::vector<double> rays;              // of each frame
  std::vector<double> changed;           // primitives that moved since the frame before, in primitives of the scene
  std::vector<double> rebuilt_sah_cost;  // of a tree built anew, beside all policies
  std::vector<PolicyRecord> policies;

  std::string line() const override;
};

}  // namespace etendue
