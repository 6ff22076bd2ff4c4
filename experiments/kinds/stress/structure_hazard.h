// The cost of a scene to a ray structure, in counts that no clock disturbs, and whether its answers are right.
#pragma once

#include "experiments/config/method.h"
#include "framework/scene/scene.h"

#include <cstdint>

namespace etendue {

struct StructureHazard {
  double nodes_per_ray = 0, tests_per_ray = 0;  // visited, and primitives tested
  std::uint64_t bytes = 0;                      // of the structure, beyond the geometry
  double bytes_per_primitive = 0;
  std::uint64_t wrong_answers = 0;  // beside those in double precision (accel_check.h)

  double work_per_ray() const { return nodes_per_ray + tests_per_ray; }
};

// Builds the structure and asks it for 4,096 camera rays and a diffuse ray from where each of them hits; of as many rays aimed
// at edges, vertices and at random the answers alone count. Trees lie in the binary layout unless the method states another, so
// that machines count alike. Throws Error on a structure of that name that is not there.
StructureHazard measure_structure_hazard(const Scene& scene, const Method& structure, std::uint64_t seed);

}  // namespace etendue
