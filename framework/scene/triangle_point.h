// Points of a triangle, with what rays that start there need to know of rounding errors.
#pragma once

#include "framework/scene/clearance.h"

namespace etendue {

// Normal by the winding, as long as twice the area. In double: thin triangles leave little of the products.
inline dvec3 twice_area(const vec3& p0, const vec3& p1, const vec3& p2) {
  return glm::cross(dvec3(p1) - dvec3(p0), dvec3(p2) - dvec3(p0));
}

// What all points of a triangle have in common.
struct TrianglePlane {
  vec3 p0, e1, e2;
  vec3 normal;    // unit, by the winding; 0 where there is no area
  float doubled;  // twice the area, m^2; 0 for what no structure holds
  float extent;   // m, the largest coordinate of an edge

  TrianglePlane() = default;
  TrianglePlane(const vec3& a, const vec3& b, const vec3& c) : p0(a), e1(b - a), e2(c - a) {
    const dvec3 across = twice_area(a, b, c);
    const vec3 rounded(across);
    const float squared = length_squared(rounded);
    // Elsewhere the square of the area leaves the range of floats.
    const bool in_range = squared > 1e-30f && squared < 1e30f;
    doubled = in_range ? std::sqrt(squared) : static_cast<float>(glm::length(across));
    normal = doubled > 0 ? rounded * (1 / doubled) : vec3(0);
    extent = max_component(glm::max(glm::abs(e1), glm::abs(e2)));
  }
};

struct TrianglePoint {
  vec3 position;
  float clearance;  // metres, as SurfacePoint's
};

// `uv`: barycentric weights of the second and third vertex. Points keep off the edges by a few clearances, since another wall
// may begin there.
inline TrianglePoint point_of(const TrianglePlane& t, const vec2& uv) {
  constexpr float clearances_from_edges = 4;
  TrianglePoint p;
  p.position = t.p0 + (uv.x * t.e1 + uv.y * t.e2);
  p.clearance = clearance_of(p.position, t.extent);
  // The distance from each edge is the weight times the height over it, and the edge at most 2 sqrt(3) times the extent.
  const float margin = clearances_from_edges * 3.5f * p.clearance * t.extent, b0 = 1 - uv.x - uv.y;
  if (std::min(std::min(uv.x, uv.y), b0) * t.doubled >= margin) [[likely]]
    return p;
  const vec3 kept = glm::max(vec3(b0, uv.x, uv.y), vec3(t.doubled > 4 * margin ? margin / t.doubled : 0.25f));
  p.position = t.p0 + (kept.y * t.e1 + kept.z * t.e2) / (kept.x + kept.y + kept.z);
  return p;
}

}  // namespace etendue
