// One ray against one primitive, shared by every structure so that all of them agree to the bit. Ties in t are broken by the
// caller through `closer`.
#pragma once

#include "accel/kernels/triangle_test.h"
#include "framework/scene/geometry.h"

namespace etendue {

// Can this ray meet anything? False for NaN or infinite components and for a zero direction.
inline bool is_traceable(const Ray& ray) {
  return is_finite(ray.origin) && is_finite(ray.direction) && ray.direction != vec3(0) && ray.t_min <= ray.t_max;
}

// No hit is farther: t is infinite where 1 / det is.
inline float farthest_hit(const Ray& ray) { return std::min(ray.t_max, std::numeric_limits<float>::max()); }

// The share of a radius, squared, that rounding may leave of a vector along a line to which it is at right angles.
inline constexpr float most_along = 1e-6f;

// A sphere, a cylinder (the tube, then its caps) or a disk. The discriminant is that of [Haines2019], with which distant
// spheres keep their edge in float.
bool intersect_quadric(const Ray& ray, const Quadric& quadric, float t_max, float& t_out, vec2& uv_out);

// The rule for ties: a nearer hit wins, then the lower primitive id.
inline bool closer(float t, std::uint32_t primitive, const Hit& best) {
  return t < best.t || (t == best.t && primitive < best.primitive);
}

// One primitive of a geometry, updating `hit` (its t bounds the search; `hit.t` starts at farthest_hit). The instance is the
// caller's.
inline bool intersect_primitive(const Geometry& geometry, std::uint32_t primitive, const Ray& ray, const TriangleRay& shear,
                                Hit& hit) {
  float t;
  vec2 uv;
  if (geometry.is_triangle(primitive)) {
    const uvec3 v = geometry.triangles[primitive];
    const auto& p = geometry.positions;
    if (!intersect_triangle(ray, shear, p[v.x], p[v.y], p[v.z], hit.t, t, uv)) return false;
  } else if (!intersect_quadric(ray, geometry.quadric(primitive), hit.t, t, uv)) {
    return false;
  }
  if (!closer(t, primitive, hit)) return false;
  hit.t = t;
  hit.uv = uv;
  hit.primitive = primitive;
  return true;
}

// The hit as the caller of a structure over one geometry gets it: in the first instance, or none.
inline Hit placed(const Hit& hit) { return hit ? Hit{hit.t, hit.uv, 0, hit.primitive} : Hit{}; }

}  // namespace etendue
