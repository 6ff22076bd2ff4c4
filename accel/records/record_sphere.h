// A sphere as the structures hold it, and the rule by which it covers a point.
#pragma once

#include "accel/points/neighbourhood.h"

namespace etendue {

struct RecordSphere {
  vec3 centre;
  float radius;
  std::uint32_t id;
};

// Spheres with a centre that is not finite, or a negative or NaN radius, cover nothing and are not kept. An infinite radius
// covers everything.
inline bool is_record_sphere(const vec3& centre, float radius) { return is_finite(centre) && radius >= 0; }

inline void add_if_covering(const RecordSphere& sphere, const vec3& p, Neighbours& out) {
  const float d2 = distance_squared(sphere.centre, p);
  if (d2 <= sphere.radius * sphere.radius && is_finite(p)) out.push_back({sphere.id, d2});
}

inline void sort_by_id(Neighbours& found) {
  std::sort(found.begin(), found.end(), [](const Neighbour& a, const Neighbour& b) { return a.id < b.id; });
}

}  // namespace etendue
