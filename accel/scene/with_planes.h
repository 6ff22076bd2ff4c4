// Infinite planes beside any ray structure: they have no box, so they stand outside the tree and are tested first, which
// already shortens the ray. They are asked only in scenes that have planes.
#pragma once

#include "accel/kernels/queries.h"
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
class WithPlanes : public Queries<WithPlanes<Inner>> {
 public:
  WithPlanes(Inner inner, const std::vector<InfinitePlane>& planes) : inner_(std::move(inner)), planes_(planes) {}

  // At equal distance the surface inside the structure wins, as its instance is the lower; so does the lower plane.
  template <bool any_hit, class Count>
  Hit trace(const Ray& ray, Count count) const {
    if (!is_traceable(ray)) return {};
    count.primitives(static_cast<std::uint32_t>(planes_.size()));
    Hit plane_hit;
    Ray shortened = ray;
    for (std::uint32_t i = 0; i < planes_.size(); ++i) {
      float t;
      if (!intersect_plane(ray, planes_[i], shortened.t_max, t) || (plane_hit && t == plane_hit.t)) continue;
      plane_hit = {t, vec2(0), plane_instance, i};
      if (any_hit) return plane_hit;
      shortened.t_max = t;
    }
    const Hit hit = count.template trace<any_hit>(inner_, shortened);
    return hit ? hit : plane_hit;
  }
  RayStructureStats stats() const {
    RayStructureStats stats = inner_.stats();
    stats.bytes += planes_.size() * sizeof(InfinitePlane);
    return stats;
  }

 private:
  Inner inner_;
  std::vector<InfinitePlane> planes_;
};

}  // namespace etendue
