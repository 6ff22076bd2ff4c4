// Compares ray structures over one scene, for `etendue accel` and the charts of structures.
#pragma once

#include "experiments/config/config.h"
#include "experiments/log/log.h"
#include "framework/scene/scene.h"

#include <functional>
#include <string>
#include <vector>

namespace etendue {

// Records the rays of a render once, then measures in rounds. Every repetition builds each structure, on all threads and on
// one, traces the same rays through it on one thread, ray by ray and in batches, and frees it, so that only one structure is in
// memory at a time; quick builds are timed three times a round, of which the shortest counts. In the first round the answers
// are checked in double precision (accel_check.h).
//
// There is a record for each instruction set and choice, in order; ratios to Embree are to Embree with the same instruction
// set. What exceeds the budget (brute force on large meshes; a builder that proves too slow in a trial on 1/32 of the
// triangles) is measured on fewer rays or not at all, and its note says so. Embree is always measured too, in both modes and
// with both kinds of streams, for the ratios to it. `progress` gets a line per step.
std::vector<StructureRecord> compare_structures(const Scene& scene, const std::vector<Method>& choices,
                                                const StructureTiming& options,
                                                const std::function<void(const std::string&)>& progress);

// Does the structure belong to another library, so that its misses are reported but do not fail a run? Embree's default mode
// misses rays at edges in exchange for speed, and CGAL's kernel does not compute exactly.
bool is_third_party(const StructureRecord& record);

}  // namespace etendue
