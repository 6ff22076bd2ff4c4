// The comparison of ray structures over one scene: `etendue accel` and the charts of structures.
#pragma once

#include "accel/registry.h"
#include "experiments/log/log.h"
#include "framework/core/isa.h"

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
  std::uint64_t check_rays = 0;  // further rays, aimed at vertices and edges, in four scales and offsets
  double budget_s = 10;          // for each structure, without checks: beyond it fewer rays and repetitions, or none
  std::vector<Isa> isas = {};    // each structure with each, named where there are several; empty: the chosen one alone
};

// Records the rays of a render once, then measures in rounds. Every repetition builds each structure, on all threads and on
// one, traces the same rays through it on one thread, ray by ray and in batches, and frees it, so that only one structure is in
// memory at a time; quick builds are timed three times a round, of which the shortest counts. In the first round the answers
// are checked in double precision (accel_check.h).
//
// There is a record for each instruction set and choice, in order; ratios to Embree are to Embree with the same instruction
// set. What exceeds the budget (brute force on large meshes; a builder that proves too slow in a trial on 1/32 of the
// triangles) is measured on fewer rays or not at all, and its note says so. Embree is always measured too, in both modes and
// with both kinds of streams, for the ratios to it. `progress` gets a line per step.
std::vector<StructureRecord> compare_structures(const Scene& scene, const std::vector<StructureChoice>& choices,
                                                const ComparisonOptions& options,
                                                const std::function<void(const std::string&)>& progress);

// Does the structure belong to another library, so that its misses are reported but do not fail a run? Embree's default mode
// misses rays at edges in exchange for speed, and CGAL's kernel does not compute exactly.
bool is_third_party(const StructureRecord& record);

}  // namespace etendue
