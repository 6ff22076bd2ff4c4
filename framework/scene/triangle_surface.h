// The surface point of a ray that met a triangle of the world, or of one in each lane (lanes.h).
#pragma once

#include "framework/scene/scene.h"
#include "framework/scene/triangle_point.h"

namespace etendue {

template <class F>
struct SurfaceOf {
  Vec3<F> position, normal, shading_normal, tangent, retreat;
  Vec2<F> uv;
  F clearance;
};

// Holds what rays meet: the corners in the world, and the place in the triangle.
template <class F>
struct TriangleHit {
  Vec3<F> p0, p1, p2;
  Vec2<F> uv;  // barycentric weights of the second and third corner
  F t;
  Vec3<F> direction;  // of the ray
  Mask<F> flip_normal;
};

// Holds what a file gives at the corners.
template <class F>
struct CornerValues {
  Mask<F> have_normals, have_uvs;
  Vec3<F> n0, n1, n2;
  Vec2<F> uv0, uv1, uv2;
};

// How far a ray that met a surface at `t` steps back.
template <class V>
V retreat_of(const V& direction, LaneOf<V> t, LaneOf<V> clearance) {
  // A point retreats by so many clearances, and by no more than this share of the way it was found by.
  constexpr float most_clearances = 16, most_of_way = 0.125f;
  return min(most_clearances * clearance, most_of_way * t) * -direction;
}

template <class V>
V normalised_or(const V& v, const V& fallback) {
  const auto far = length(v);
  return select((far > 0) & (far < infinity), v / far, fallback);
}

// dp/du from the texture coordinates of the corners; any perpendicular direction where they are degenerate.
template <class V, class V2>
V triangle_tangent(const V& e1, const V& e2, const V2& d1, const V2& d2, const V& normal) {
  const auto determinant = d1.x * d2.y - d1.y * d2.x;
  return select(abs(determinant) < 1e-12f, FrameOf<V>::from_normal(normal).tangent, (d2.y * e1 - d1.y * e2) / determinant);
}

template <class F>
SurfaceOf<F> triangle_surface(const TriangleHit<F>& hit, const CornerValues<F>* corners = nullptr) {
  SurfaceOf<F> s;
  const TrianglePlaneOf<F> triangle(hit.p0, hit.p1, hit.p2);
  const TrianglePointOf<F> point = point_of<F>(triangle, hit.uv);
  s.position = point.position;
  s.clearance = point.clearance;
  s.normal = select(hit.flip_normal, -triangle.normal, triangle.normal);
  s.shading_normal = s.normal;
  s.uv = {hit.uv.x + hit.uv.y, hit.uv.y};  // (0, 0), (1, 0), (1, 1)
  s.tangent = triangle.e1;
  s.retreat = retreat_of(hit.direction, hit.t, s.clearance);
  if (!corners) return s;
  const F b1 = hit.uv.x, b2 = hit.uv.y, b0 = 1 - b1 - b2;
  if (any(corners->have_normals)) {
    const Vec3<F> shading = normalised_or(b0 * corners->n0 + b1 * corners->n1 + b2 * corners->n2, s.normal);
    s.shading_normal = select(corners->have_normals, shading, s.normal);
    s.normal = select(corners->have_normals & (dot(s.normal, shading) < 0), -s.normal, s.normal);
  }
  if (any(corners->have_uvs)) {
    const Vec2<F>&t0 = corners->uv0, &t1 = corners->uv1, &t2 = corners->uv2;
    s.uv.x = select(corners->have_uvs, b0 * t0.x + b1 * t1.x + b2 * t2.x, s.uv.x);
    s.uv.y = select(corners->have_uvs, b0 * t0.y + b1 * t1.y + b2 * t2.y, s.uv.y);
    const Vec2<F> d1{t1.x - t0.x, t1.y - t0.y}, d2{t2.x - t0.x, t2.y - t0.y};
    s.tangent = select(corners->have_uvs, triangle_tangent(triangle.e1, triangle.e2, d1, d2, s.normal), s.tangent);
  }
  return s;
}

}  // namespace etendue
