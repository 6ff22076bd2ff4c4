// Points of a triangle, with what rays that start there need to know of rounding errors.
#pragma once

#include "framework/scene/clearance.h"

namespace etendue {

// Normal by the winding, as long as twice the area. It is double, for products cancel in thin triangles.
inline dvec3 twice_area(const vec3& p0, const vec3& p1, const vec3& p2) {
  return glm::cross(dvec3(p1) - dvec3(p0), dvec3(p2) - dvec3(p0));
}
inline vec3 rounded_twice_area(const vec3& p0, const vec3& p1, const vec3& p2) { return twice_area(p0, p1, p2); }

// Holds what all points of a triangle have in common, or of one triangle in each lane (lanes.h).
template <class F>
struct TrianglePlaneOf {
  Vec3<F> p0, e1, e2;
  Vec3<F> normal;  // unit, by the winding; 0 where there is no area
  F doubled;       // twice the area, m^2; 0 for what no structure holds
  F extent;        // m, the largest coordinate of an edge

  TrianglePlaneOf() = default;
  TrianglePlaneOf(const Vec3<F>& a, const Vec3<F>& b, const Vec3<F>& c) : p0(a), e1(b - a), e2(c - a) {
    const Vec3<F> across = rounded_twice_area(a, b, c);
    const F squared = length_squared(across);
    doubled = sqrt(squared);
    const Mask<F> in_range = (squared > 1e-30f) & (squared < 1e30f);
    if (!all(in_range)) [[unlikely]]  // the square of the area leaves the range of floats
      for_lanes(!in_range, [&](int i) {
        set_lane(doubled, i, static_cast<float>(glm::length(twice_area(lane(a, i), lane(b, i), lane(c, i)))));
      });
    normal = select(doubled > 0, across * (1 / doubled), Vec3<F>(0.0f));
    extent = max_component(max(abs(e1), abs(e2)));
  }
};
using TrianglePlane = TrianglePlaneOf<float>;

template <class F>
struct TrianglePointOf {
  Vec3<F> position;
  F clearance;  // metres, as SurfacePoint's
};
using TrianglePoint = TrianglePointOf<float>;

// The barycentric weights of the point that lies `distance` metres or more off all edges, for one that lies nearer to some: it
// moves at right angles to them, and towards the middle only in a corner too sharp for that.
vec3 kept_off_edges(const TrianglePlane& t, vec3 weights, float distance);

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
    TrianglePlane triangle;
    triangle.p0 = lane(t.p0, i);
    triangle.e1 = lane(t.e1, i);
    triangle.e2 = lane(t.e2, i);
    triangle.doubled = lane(t.doubled, i);
    const vec3 kept = kept_off_edges(triangle, {lane(b0, i), lane(uv.x, i), lane(uv.y, i)}, lane(distance, i));
    set_lane(p.position, i, triangle.p0 + (kept.y * triangle.e1 + kept.z * triangle.e2));
  });
  return p;
}

}  // namespace etendue
