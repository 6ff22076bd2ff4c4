#include "accel/spatial/brute_in_place.h"

namespace etendue {

static_assert(RayStructure<BruteInPlace>);

BruteInPlace::BruteInPlace(const Geometry& geometry) : geometry_(&geometry) {
  for (std::uint32_t id = 0; id < geometry.primitive_count(); ++id)
    if (!geometry.is_valid(id)) invalid_.push_back(id);
  invalid_.shrink_to_fit();
}

RayStructureStats BruteInPlace::stats() const {
  const std::uint64_t references = geometry_->primitive_count() - invalid_.size();
  return {invalid_.size() * sizeof(std::uint32_t), 0, 0, references, static_cast<double>(references)};
}

}  // namespace etendue
