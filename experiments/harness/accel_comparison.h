// The comparison of ray structures over one scene: `etendue accel` and the charts of structures.
#pragma once

#include "accel/registry.h"
#include "experiments/harness/log.h"

#include <functional>
#include <string>
#include <vector>

namespace etendue {

struct StructureChoice {
  std::string name;
  ParamMap params;
};

struct ComparisonOptions {
  int resolution = 256;          // about resolution^2 rays of each kind
  int repetitions = 3;           // interleaved; medians and quartiles are reported
  int threads = 1;               // of the parallel build
  std::uint64_t check_rays = 0;  // aimed at vertices and edges, over four scales and offsets; beside the recorded rays
  double budget_s = 10;          // for each structure, its checks left aside: beyond it fewer rays and repetitions, or none
};

// Records the rays of a render once, then goes round: every repetition builds each structure, on all threads and on one, traces
// the same rays through it on one thread, ray by ray and in batches, and lets it go, so that only one structure is in memory at
// a time. In the first round the answers are judged in double precision (accel_check.h).
//
// There is a record for each choice, in order. What would not fit the budget (brute force on large meshes; a builder that a
// trial on a thirty-second of the triangles shows to be too slow) is measured on fewer rays or not at all, and its note says
// so. Embree is measured along, in both modes and with both kinds of streams, for the ratios to it. `progress` gets a line per
// step.
std::vector<StructureRecord> compare_structures(const Scene& scene, const std::vector<StructureChoice>& choices,
                                                const ComparisonOptions& options,
                                                const std::function<void(const std::string&)>& progress);

// Is a structure somebody else's, whose own misses are reported and held against nobody? Embree's default mode gives up rays
// at edges for speed, CGAL's kernel rounds as it will.
bool is_foreign(const StructureRecord& record);

}  // namespace etendue
