// Infinite planes beside any ray structure: they have no box, so they stand outside the tree and are tested first, which
// already shortens the ray. Used only for scenes that have planes.
#pragma once

#include "framework/scene/intersect.h"
#include "framework/scene/scene.h"

namespace etendue {

// Distance at which the ray meets the plane, if it lies in (t_min, t_max]. A ray within the plane misses it.
inline bool intersect_plane(const Ray& ray, const InfinitePlane& plane, float t_max, float& t_out) {
  const float t = glm::dot(plane.point - ray.origin, plane.normal) / glm::dot(ray.direction, plane.normal);
  if (!(t > ray.t_min && t <= t_max && t < infinity)) return false;  // a parallel ray divides by zero
  t_out = t;
  return true;
}

template <RayStructure Inner>
class WithPlanes {
 public:
  WithPlanes(Inner inner, const std::vector<InfinitePlane>& planes) : inner_(std::move(inner)), planes_(planes) {}

  Hit closest(const Ray& ray) const {
    return closest_with(ray, [this](const Ray& r) { return inner_.closest(r); });
  }
  bool occluded(const Ray& ray) const { return meets_plane(ray) || inner_.occluded(ray); }
  Hit closest_counted(const Ray& ray, TraversalCounters& counters) const {
    counters.primitives += planes_.size();
    return closest_with(ray, [&](const Ray& r) { return inner_.closest_counted(r, counters); });
  }
  bool occluded_counted(const Ray& ray, TraversalCounters& counters) const {
    counters.primitives += planes_.size();
    return meets_plane(ray) || inner_.occluded_counted(ray, counters);
  }
  RayStructureStats stats() const {
    RayStructureStats stats = inner_.stats();
    stats.bytes += planes_.size() * sizeof(InfinitePlane);
    return stats;
  }

 private:
  // At equal distance the surface inside the structure wins, as its instance is the lower; so does the lower plane.
  template <class Closest>
  Hit closest_with(const Ray& ray, const Closest& closest) const {
    if (!is_traceable(ray)) return {};
    Hit plane_hit;
    Ray shortened = ray;
    for (std::uint32_t i = 0; i < planes_.size(); ++i) {
      float t;
      if (!intersect_plane(ray, planes_[i], shortened.t_max, t) || (plane_hit && t == plane_hit.t)) continue;
      plane_hit = {t, vec2(0), plane_instance, i};
      shortened.t_max = t;
    }
    const Hit hit = closest(shortened);
    return hit ? hit : plane_hit;
  }

  bool meets_plane(const Ray& ray) const {
    float t;
    return is_traceable(ray) && std::any_of(planes_.begin(), planes_.end(), [&](const InfinitePlane& plane) {
             return intersect_plane(ray, plane, ray.t_max, t);
           });
  }

  Inner inner_;
  std::vector<InfinitePlane> planes_;
};

}  // namespace etendue
