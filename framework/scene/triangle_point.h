// A point of a triangle, with what rays that start there need to know of rounding errors.
#pragma once

#include "framework/scene/clearance.h"

namespace etendue {

struct TrianglePoint {
  vec3 position;
  vec3 normal;      // unit, by the winding
  float clearance;  // metres, as SurfacePoint's
  float area;       // m^2; 0 for what no structure holds
};

// Normal by the winding, as long as twice the area. In double: thin triangles leave little of the products.
inline dvec3 twice_area(const vec3& p0, const vec3& p1, const vec3& p2) {
  return glm::cross(dvec3(p1) - dvec3(p0), dvec3(p2) - dvec3(p0));
}

// `uv`: barycentric weights of the second and third vertex. Points keep off the edges by a few clearances, since another wall
// may begin there.
[[gnu::always_inline]] inline TrianglePoint triangle_point(const vec3& p0, const vec3& p1, const vec3& p2, const vec2& uv) {
  constexpr float clearances_from_edges = 4;
  const vec3 e1 = p1 - p0, e2 = p2 - p0;
  const dvec3 across = twice_area(p0, p1, p2);
  const vec3 rounded(across);
  float doubled = length_squared(rounded);
  // Elsewhere the square of the area leaves the range of floats.
  const bool in_range = doubled > 1e-30f && doubled < 1e30f;
  doubled = in_range ? std::sqrt(doubled) : static_cast<float>(glm::length(across));
  TrianglePoint p;
  p.area = 0.5f * doubled;
  p.normal = doubled > 0 ? rounded * (1 / doubled) : vec3(0);
  p.position = p0 + (uv.x * e1 + uv.y * e2);
  const float extent = max_component(glm::max(glm::abs(e1), glm::abs(e2)));
  p.clearance = clearance_of(p.position, extent);
  // The distance from each edge is the weight times the height over it, and the edge at most 2 sqrt(3) times the extent.
  const float margin = clearances_from_edges * 3.5f * p.clearance * extent, b0 = 1 - uv.x - uv.y;
  if (std::min(std::min(uv.x, uv.y), b0) * doubled >= margin) [[likely]]
    return p;
  const vec3 kept = glm::max(vec3(b0, uv.x, uv.y), vec3(doubled > 4 * margin ? margin / doubled : 0.25f));
  p.position = p0 + (kept.y * e1 + kept.z * e2) / (kept.x + kept.y + kept.z);
  return p;
}

}  // namespace etendue
