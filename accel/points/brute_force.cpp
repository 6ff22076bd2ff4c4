#include "accel/points/brute_force.h"

namespace etendue {

static_assert(PointStructure<PointBruteForce>);

void PointBruteForce::within(const vec3& p, float r, Neighbours& out) const {
  out.clear();
  if (!can_find(p, r)) return;
  for (std::uint32_t id = 0; id < points_.size(); ++id) {
    const float d2 = distance_squared(points_[id], p);
    if (d2 <= r * r && is_finite(points_[id])) out.push_back({id, d2});
  }
}

void PointBruteForce::nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const {
  within(p, r_max, out);
  keep_nearest(out, k);
}

}  // namespace etendue
