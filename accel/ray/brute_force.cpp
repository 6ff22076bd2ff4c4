#include "accel/ray/brute_force.h"

namespace etendue {

static_assert(RayStructure<BruteForce>);

BruteForce::BruteForce(const Geometry& geometry) : blocks_(geometry), all_(blocks_.add(geometry.valid_primitives())) {}

RayStructureStats BruteForce::stats() const {
  return {blocks_.bytes(), 0, 0, blocks_.references(), static_cast<double>(blocks_.references())};
}

}  // namespace etendue
