#include "accel/scene/with_planes.h"

#include "accel/kernels/queries.h"

#include <vector>

namespace etendue {

namespace {

// Distance at which the ray meets the plane, if it lies in (t_min, t_max]. A ray within the plane misses it.
bool intersect_plane(const Ray& ray, const InfinitePlane& plane, float t_max, float& t_out) {
  const float t = glm::dot(plane.point - ray.origin, plane.normal) / glm::dot(ray.direction, plane.normal);
  if (!(t > ray.t_min && t <= t_max && t < infinity)) return false;  // a parallel ray divides by zero
  t_out = t;
  return true;
}

class WithPlanes : public Queries<WithPlanes> {
 public:
  WithPlanes(std::unique_ptr<RayQuery> inner, const std::vector<InfinitePlane>& planes)
      : inner_(std::move(inner)), planes_(planes) {}

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
    const Hit hit = count.template trace<any_hit>(*inner_, shortened);
    return hit ? hit : plane_hit;
  }
  RayStructureStats stats() const {
    RayStructureStats stats = inner_->stats();
    stats.bytes += planes_.size() * sizeof(InfinitePlane);
    return stats;
  }

 private:
  std::unique_ptr<RayQuery> inner_;
  std::vector<InfinitePlane> planes_;
};

}  // namespace

std::unique_ptr<RayQuery> with_planes(std::unique_ptr<RayQuery> structure, const Scene& scene) {
  if (scene.planes.empty()) return structure;
  const std::string fallback = structure->fallback;
  auto with = std::make_unique<RayAdapter<WithPlanes>>(WithPlanes(std::move(structure), scene.planes));
  with->fallback = fallback;
  return with;
}

}  // namespace etendue
