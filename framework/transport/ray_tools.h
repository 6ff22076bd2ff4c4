// Rays that leave surfaces, and the queries integrators make with them (counted).
#pragma once

#include "framework/core/counters.h"
#include "framework/integrator.h"
#include "framework/scene/clearance.h"

#include <array>

namespace etendue {

// Origin of rays that leave a surface point to the side of `direction`: off the surface. On the side that the point was found
// from it lies on the way to the point, beside it only where that way grazes the surface.
template <class Point, class V>
V ray_origin(const Point& point, const V& direction) {
  using F = LaneOf<V>;
  const Mask<F> below = dot(direction, V(point.normal)) < 0;
  const F along = dot(V(point.retreat), V(point.normal)), height = select(below, -along, along);
  const V on_way = select(height > 0, point.position + point.retreat, V(point.position));
  const F clearance = point.clearance;
  return select(height >= clearance, on_way, on_way + select(below, -clearance, clearance) * point.normal);
}

// A ray from a surface point along a unit direction, moved off the surface on the side it leaves to.
inline Ray spawn_ray(const SurfacePoint& point, const vec3& direction, float t_max = infinity) {
  return {.origin = ray_origin(point, direction), .direction = direction, .t_max = t_max};
}

inline Hit trace(const RenderContext& context, const Ray& ray) {
  count(Counter::rays);
  return context.rays.closest(ray);
}

// Calls visit(point) for each light that a ray passes within `distance`: surfaces that emit and let rays through (Shape::mask).
template <class Visit>
void for_passed_lights(const RenderContext& context, Ray way, float distance, const Visit& visit) {
  if (!context.needs.passed_lights) return;
  way.t_max = distance;
  for (Hit hit = context.rays.passed_light(way); hit; hit = context.rays.passed_light(way)) {
    visit(context.scene.surface_at(way, hit));
    way.t_min = std::max(hit.t, std::nextafter(way.t_min, infinity));
  }
}

// Many rays at once, which structures may answer faster than one by one. There are as many hits as rays.
inline void trace(const RenderContext& context, std::span<const Ray> rays, std::span<Hit> hits) {
  count(Counter::rays, rays.size());
  context.rays.closest(rays, hits);
}

// A ray between two points that are off their surfaces. Its direction is the whole way.
inline Ray segment(const vec3& from, const vec3& to) {
  return {.origin = from, .direction = to - from, .t_max = 1 - 4 * unit_roundoff};
}

// A ray between two surface points that lie in unit direction wi from each other. Both ends are off their surfaces: a ray moved
// off its start alone would meet the other surface too early where it grazes that, as between a wall and a door ajar.
inline Ray segment(const SurfacePoint& from, const SurfacePoint& to, const vec3& wi) {
  const vec3 start = ray_origin(from, wi), end = ray_origin(to, -wi);
  const float afar = clearance_from_afar(glm::length(end - start));
  return segment(start, end + (glm::dot(wi, to.normal) > 0 ? -afar : afar) * to.normal);
}

// Do both points lie in each other's surface, as far as rounding tells? Then so does the way between them, and it tells nothing
// of which sides it leaves and meets. What little light passes there is less than the square of clearance over distance.
inline bool in_one_plane(const SurfacePoint& from, const SurfacePoint& to) {
  const vec3 way = to.position - from.position;
  return std::abs(glm::dot(way, from.normal)) < from.clearance && std::abs(glm::dot(way, to.normal)) < to.clearance;
}

inline Ray shadow_ray(const SurfacePoint& point, const LightSample& light) {
  return std::isinf(light.distance) ? spawn_ray(point, light.wi) : segment(ray_origin(point, light.wi), light.end);
}

inline bool unoccluded(const RenderContext& context, const Ray& shadow_ray) {
  count(Counter::shadow_rays);
  return !context.rays.occluded(shadow_ray);
}

// Does nothing on the way from a point hide what landed at `landed`? A mask that lets a part of the light through does not
// where both lie on one side of it: what landed has come through it already, and would be dimmed twice.
inline bool sees_landed(const RenderContext& context, Ray way, const vec3& landed) {
  if (!context.needs.masks) return unoccluded(context, way);
  for (Hit hit = trace(context, way); hit; hit = trace(context, way)) {
    if (!lets_light_through(context.scene.layer_at(hit))) return false;
    const SurfacePoint sheet = context.scene.surface_at(way, hit);
    const auto height = [&sheet](const vec3& p) { return glm::dot(p - sheet.position, sheet.normal); };
    if (height(way.origin) * height(landed) < 0) return false;
    way.t_min = std::max(hit.t, std::nextafter(way.t_min, infinity));
  }
  return true;
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

// Does a light that is a point, whose ray this is (t_min above 0), lie in the surface that the ray meets, as far as rounding
// tells? What it sends along that surface is rounding.
inline bool meets_own_wall(const Ray& ray, const SurfacePoint& point) {
  return ray.t_min > 0 && std::abs(glm::dot(point.position - ray.origin, point.normal)) < point.clearance;
}

}  // namespace etendue
