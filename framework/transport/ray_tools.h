// Rays that leave surfaces, and the queries integrators make with them (counted).
#pragma once

#include "framework/core/counters.h"
#include "framework/integrator.h"
#include "framework/scene/offset.h"

#include <array>

namespace etendue {

// Origin of rays that leave a surface point to the side of `direction`.
inline vec3 ray_origin(const SurfacePoint& point, const vec3& direction) {
  return offset_origin(point.position, glm::dot(direction, point.normal) < 0 ? -point.normal : point.normal);
}

// A ray from a surface point along a unit direction, moved off the surface on the side it leaves to.
inline Ray spawn_ray(const SurfacePoint& point, const vec3& direction, float t_max = infinity) {
  return {.origin = ray_origin(point, direction), .direction = direction, .t_max = t_max};
}

inline Hit trace(const RenderContext& context, const Ray& ray) {
  count(Counter::rays);
  return context.rays.closest(ray);
}

// Many rays at once, which structures may answer faster than one by one. There are as many hits as rays.
inline void trace(const RenderContext& context, std::span<const Ray> rays, std::span<Hit> hits) {
  count(Counter::rays, rays.size());
  context.rays.closest(rays, hits);
}

// From a surface point to a light `distance` away along `wi`. The last 1e-4 of the way is left out: it holds the light itself.
inline Ray shadow_ray(const SurfacePoint& point, const vec3& wi, float distance) {
  return spawn_ray(point, wi, std::isinf(distance) ? infinity : distance * (1 - 1e-4f));
}

inline bool unoccluded(const RenderContext& context, const Ray& shadow_ray) {
  count(Counter::shadow_rays);
  return !context.rays.occluded(shadow_ray);
}

// Can two points see each other? `from` is on a surface, `to` anywhere.
inline bool visible(const RenderContext& context, const SurfacePoint& from, const vec3& to) {
  const vec3 towards = to - from.position;
  const float distance = glm::length(towards);
  return distance > 0 && unoccluded(context, shadow_ray(from, towards / distance, distance));
}

// body(i) for each of the rays that nothing blocks, in their order.
template <class Body>
void for_unoccluded(const RenderContext& context, std::span<const Ray> shadow_rays, const Body& body) {
  count(Counter::shadow_rays, shadow_rays.size());
  std::array<bool, 1024> occluded;
  for (std::size_t first = 0; first < shadow_rays.size(); first += occluded.size()) {
    const std::size_t some = std::min(occluded.size(), shadow_rays.size() - first);
    context.rays.occluded(shadow_rays.subspan(first, some), std::span(occluded).first(some));
    for (std::size_t i = 0; i < some; ++i)
      if (!occluded[i]) body(first + i);
  }
}

}  // namespace etendue
