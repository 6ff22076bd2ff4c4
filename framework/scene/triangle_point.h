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

// The barycentric weights of the point that lies `distance` metres or more off all edges, for one that lies nearer to some: it
// moves at right angles to them, and towards the middle only in a corner too sharp for that.
[[gnu::noinline]] inline vec3 kept_off_edges(const TrianglePlane& t, vec3 weights, float distance) {
  const vec3 corners[3] = {vec3(0), t.e1, t.e2};
  vec3 least;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const vec3 edge = corners[k] - corners[j];
    const float length2 = length_squared(edge);
    least[i] = std::min(distance * std::sqrt(length2) / t.doubled, 0.25f);
    if (!(weights[i] < least[i])) continue;
    const float foot = glm::dot(corners[i] - corners[j], edge) / length2, missing = least[i] - weights[i];
    weights[i] += missing;
    weights[j] -= missing * (1 - foot);
    weights[k] -= missing * foot;
  }
  weights = glm::max(weights, least);
  return weights / (weights.x + weights.y + weights.z);
}

// `uv`: barycentric weights of the second and third vertex. Points keep off the edges by a few clearances, since another wall
// may begin there.
inline TrianglePoint point_of(const TrianglePlane& t, const vec2& uv) {
  constexpr float clearances_from_edges = 4;
  TrianglePoint p;
  p.position = t.p0 + (uv.x * t.e1 + uv.y * t.e2);
  p.clearance = clearance_of(p.position, t.extent);
  // The distance from each edge is the weight times the height over it, and the edge at most 2 sqrt(3) times the extent.
  const float distance = clearances_from_edges * p.clearance, b0 = 1 - uv.x - uv.y;
  if (std::min(std::min(uv.x, uv.y), b0) * t.doubled >= 3.5f * distance * t.extent) [[likely]]
    return p;
  const vec3 kept = kept_off_edges(t, {b0, uv.x, uv.y}, distance);
  p.position = t.p0 + (kept.y * t.e1 + kept.z * t.e2);
  return p;
}

}  // namespace etendue
