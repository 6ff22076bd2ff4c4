// Points of a triangle, with what rays that start there need to know of rounding errors.
#pragma once

#include "framework/scene/clearance.h"

namespace etendue {

// Normal by the winding, as long as twice the area. In double: thin triangles leave little of the products.
inline dvec3 twice_area(const vec3& p0, const vec3& p1, const vec3& p2) {
  return glm::cross(dvec3(p1) - dvec3(p0), dvec3(p2) - dvec3(p0));
}

// What all points of a triangle have in common, or of one in each lane (lanes.h).
template <class F>
struct TrianglePlaneOf {
  Vec3<F> p0, e1, e2;
  Vec3<F> normal;  // unit, by the winding; 0 where there is no area
  F doubled;       // twice the area, m^2; 0 for what no structure holds
  F extent;        // m, the largest coordinate of an edge
};
struct TrianglePlane : TrianglePlaneOf<float> {
  TrianglePlane() = default;
  TrianglePlane(const vec3& a, const vec3& b, const vec3& c) : TrianglePlaneOf{a, b - a, c - a, vec3(0), 0, 0} {
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

template <class F>
struct TrianglePointOf {
  Vec3<F> position;
  F clearance;  // metres, as SurfacePoint's
};
using TrianglePoint = TrianglePointOf<float>;

// The barycentric weights of the point that lies `distance` metres or more off all edges, for one that lies nearer to some: it
// moves at right angles to them, and towards the middle only in a corner too sharp for that.
vec3 kept_off_edges(const TrianglePlaneOf<float>& t, vec3 weights, float distance);

// `uv`: barycentric weights of the second and third vertex. Points keep off the edges by a few clearances, since another wall
// may begin there.
template <class F>
TrianglePointOf<F> point_of(const TrianglePlaneOf<F>& t, const Vec2<F>& uv) {
  constexpr float clearances_from_edges = 4;
  TrianglePointOf<F> p;
  p.position = t.p0 + (uv.x * t.e1 + uv.y * t.e2);
  p.clearance = clearance_of(p.position, t.extent);
  // The distance from each edge is the weight times the height over it, and the edge at most 2 sqrt(3) times the extent.
  const F distance = clearances_from_edges * p.clearance, b0 = 1 - uv.x - uv.y;
  const Mask<F> far = min(min(uv.x, uv.y), b0) * t.doubled >= 3.5f * distance * t.extent;
  if (all(far)) [[likely]]
    return p;
  for_lanes(!far, [&](int i) {
    const TrianglePlaneOf<float> triangle{lane(t.p0, i),     lane(t.e1, i),      lane(t.e2, i),
                                          lane(t.normal, i), lane(t.doubled, i), lane(t.extent, i)};
    const vec3 kept = kept_off_edges(triangle, {lane(b0, i), lane(uv.x, i), lane(uv.y, i)}, lane(distance, i));
    set_lane(p.position, i, triangle.p0 + (kept.y * triangle.e1 + kept.z * triangle.e2));
  });
  return p;
}
inline TrianglePoint point_of(const TrianglePlane& t, const vec2& uv) { return point_of<float>(t, uv); }

}  // namespace etendue
