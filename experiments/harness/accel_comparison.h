// The comparison of ray structures over one scene: `etendue accel` and the structures chart.
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
  int resolution = 512;            // primary rays: resolution^2 from the scene's camera
  int repetitions = 3;             // interleaved; medians are reported
  std::size_t brute_force_rays = 2000;  // of each kind, checked against brute force
};

// Builds every structure, records primary, diffuse-bounce and shadow rays of the scene once, times each structure on the same
// rays on one thread (interleaved repetitions) and compares every hit: distances with Embree's where available and with brute
// force on a sample. `progress` gets a line per step.
std::vector<StructureRecord> compare_structures(const Scene& scene, const std::vector<StructureChoice>& choices,
                                                const ComparisonOptions& options,
                                                const std::function<void(const std::string&)>& progress);

}  // namespace etendue
