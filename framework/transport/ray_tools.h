// Rays that leave surfaces, and the queries integrators make with them (counted).
#pragma once

#include "framework/core/counters.h"
#include "framework/integrator.h"
#include "framework/scene/offset.h"

namespace etendue {

// Where rays that leave a surface point to the side of `direction` start.
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

// Does light from `distance` away along `wi` arrive at the point? The last 1e-4 of the way is left out: it holds the light
// itself.
inline bool unoccluded(const RenderContext& context, const SurfacePoint& point, const vec3& wi, float distance) {
  count(Counter::shadow_rays);
  return !context.rays.occluded(spawn_ray(point, wi, std::isinf(distance) ? infinity : distance * (1 - 1e-4f)));
}

// Can two points see each other? `from` is on a surface, `to` anywhere.
inline bool visible(const RenderContext& context, const SurfacePoint& from, const vec3& to) {
  const vec3 towards = to - from.position;
  const float distance = glm::length(towards);
  return distance > 0 && unoccluded(context, from, towards / distance, distance);
}

}  // namespace etendue
