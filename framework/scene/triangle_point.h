// A point of a triangle, with what rays that start there need to know of rounding errors.
#pragma once

#include "framework/scene/clearance.h"

namespace etendue {

struct TrianglePoint {
  vec3 position;
  vec3 normal;      // unit, by the winding
  float clearance;  // metres, as SurfacePoint's
  double area;      // m^2; 0 for what no structure holds
};

// `uv`: barycentric weights of the second and third vertex. In double, so that the position is rounded once and triangles of
// any size have a normal. Points keep off the edges by a few clearances, since another wall may begin there.
inline TrianglePoint triangle_point(const vec3& p0, const vec3& p1, const vec3& p2, const vec2& uv) {
  constexpr double most_magnified = 64;  // of the errors of tests, in slivers: by their extent over their height
  constexpr float clearances_from_edges = 4;
  const dvec3 e1 = dvec3(p1) - dvec3(p0), e2 = dvec3(p2) - dvec3(p0), across = glm::cross(e1, e2);
  const double twice_area = glm::length(across);
  TrianglePoint p;
  p.area = 0.5 * twice_area;
  p.normal = twice_area > 0 ? vec3(across * (1 / twice_area)) : vec3(0, 0, 1);
  const double extent = max_component(glm::max(glm::abs(vec3(e1)), glm::abs(vec3(e2))));
  const double extent_over_height = twice_area > 0 ? extent * extent / twice_area : most_magnified;
  p.position = vec3(dvec3(p0) + static_cast<double>(uv.x) * e1 + static_cast<double>(uv.y) * e2);
  p.clearance = clearance_of(p.position, p.normal, static_cast<float>(extent * std::min(extent_over_height, most_magnified)));
  // As a share of the height over each edge. The longest edge is at most 2 sqrt(3) times the extent.
  const float margin = clearances_from_edges * 3.5f * p.clearance * static_cast<float>(extent_over_height / extent);
  const float b0 = 1 - uv.x - uv.y;
  if (std::min(std::min(uv.x, uv.y), b0) >= margin) [[likely]]
    return p;
  const dvec3 kept = glm::max(dvec3(b0, uv.x, uv.y), dvec3(std::min(margin, 0.25f)));
  p.position = vec3(dvec3(p0) + (kept.y * e1 + kept.z * e2) / (kept.x + kept.y + kept.z));
  return p;
}

}  // namespace etendue
