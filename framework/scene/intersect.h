// Ray-primitive tests, shared by every structure so that all of them agree to the bit.
//
// Triangles: the watertight test of [Woop2013], in single precision with its double-precision fall-back for zero edge
// functions; it must be compiled with -ffp-contract=off, which the build sets for the whole project. Where a triangle is long
// and thin, the distance is taken in double precision, too. Ties in t are broken by the caller through `closer`.
#pragma once

#include "framework/scene/geometry.h"

#include <utility>

namespace etendue {

// The part of the watertight test that depends on the ray alone.
struct TriangleRay {
  int kx, ky, kz;
  float sx, sy, sz;

  TriangleRay() = default;
  explicit TriangleRay(const vec3& direction) {
    // Without a branch: which axis is the longest cannot be predicted.
    const vec3 a = glm::abs(direction);
    const int y_beats_x = !(a.x > a.y), z_beats_both = !(std::max(a.y, a.x) > a.z);
    kz = 2 * z_beats_both + (y_beats_x & ~z_beats_both);
    static constexpr int next[] = {1, 2, 0, 1};
    const float along = component(direction, kz);
    const int backwards = along < 0;
    kx = next[kz + backwards];
    ky = next[kz + 1 - backwards];
    sx = component(direction, kx) / along;
    sy = component(direction, ky) / along;
    sz = 1.0f / along;
  }
};

// Can this ray meet anything? False for NaN or infinite components and for a zero direction.
inline bool is_traceable(const Ray& ray) {
  return is_finite(ray.origin) && is_finite(ray.direction) && ray.direction != vec3(0) && ray.t_min <= ray.t_max;
}

// Is a triangle's height less than a 32nd of its extent, or nearly? Rounding its vertices in a ray's space then shifts its
// plane by more than clearance_of allows for: of rays in a box of 100 by 1 by 1, one in 200,000 left it. Where squares of
// metres leave the range of floats, no triangle is one: scenes are larger than that (precision.h) and smaller
// (object_builder.h).
inline bool is_needle(const vec3& p0, const vec3& p1, const vec3& p2) {
  constexpr float least = 1e-18f, most = 1e18f;
  const vec3 e1 = p1 - p0, e2 = p2 - p0;
  const float extent = max_component(glm::max(glm::abs(e1), glm::abs(e2)));
  return 32 * max_component(glm::abs(glm::cross(e1, e2))) < extent * extent && extent > least &&
         std::max(extent, max_component(glm::abs(p0))) < most;
}

// Distance and barycentrics of a needle, in double precision, where the test below tells that the ray's line meets it. That is
// not asked again, so that no ray passes between a needle and its neighbours. False for a ray in the triangle's plane.
bool place_on_needle(const Ray& ray, const TriangleRay& shear, const vec3& p0, const vec3& p1, const vec3& p2, float& t_out,
                     vec2& uv_out);

// Distance and barycentrics of the second and third vertex, if t lies in (t_min, t_max].
inline bool intersect_triangle(const Ray& ray, const TriangleRay& shear, const vec3& p0, const vec3& p1, const vec3& p2,
                               float t_max, float& t_out, vec2& uv_out) {
  const vec3 a = p0 - ray.origin, b = p1 - ray.origin, c = p2 - ray.origin;
  const int kx = shear.kx, ky = shear.ky, kz = shear.kz;
  const float az = component(a, kz), bz = component(b, kz), cz = component(c, kz);
  const float ax = component(a, kx) - shear.sx * az, ay = component(a, ky) - shear.sy * az;
  const float bx = component(b, kx) - shear.sx * bz, by = component(b, ky) - shear.sy * bz;
  const float cx = component(c, kx) - shear.sx * cz, cy = component(c, ky) - shear.sy * cz;
  float u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
  if (u == 0 || v == 0 || w == 0) [[unlikely]] {
    u = static_cast<float>(static_cast<double>(cx) * by - static_cast<double>(cy) * bx);
    v = static_cast<float>(static_cast<double>(ax) * cy - static_cast<double>(ay) * cx);
    w = static_cast<float>(static_cast<double>(bx) * ay - static_cast<double>(by) * ax);
  }
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
  const float det = u + v + w;
  if (!(std::abs(det) > 0)) return false;
  const float reciprocal = 1.0f / det;
  float t = (u * (shear.sz * az) + v * (shear.sz * bz) + w * (shear.sz * cz)) * reciprocal;
  vec2 uv = vec2(v, w) * reciprocal;
  if (is_needle(p0, p1, p2)) [[unlikely]]
    place_on_needle(ray, shear, p0, p1, p2, t, uv);
  if (!(t > ray.t_min && t <= t_max) || t == infinity) return false;  // infinite where 1 / det is
  t_out = t;
  uv_out = uv;
  return true;
}

// As above for a sphere, a cylinder (the tube, then its caps) or a disk. In float with the discriminant of [Haines2019], so
// that distant spheres keep their edge.
bool intersect_quadric(const Ray& ray, const Quadric& quadric, float t_max, float& t_out, vec2& uv_out);

// The rule for ties: a nearer hit wins, then the lower primitive id.
inline bool closer(float t, std::uint32_t primitive, const Hit& best) {
  return t < best.t || (t == best.t && primitive < best.primitive);
}

// One primitive of a geometry, updating `hit` (its t bounds the search; `hit.t` starts at ray.t_max). The instance is the
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

// Reciprocals for slab tests. NaN, which restricts nothing, where that of a subnormal component overflows: the ray does cross
// the slab, though at distances of the order of 1e38 times the slab's, and an infinity would deny it.
inline vec3 slab_reciprocal(const vec3& direction) {
  vec3 reciprocal = 1.0f / direction;
  for (int axis = 0; axis < 3; ++axis)
    if (std::isinf(reciprocal[axis]) && direction[axis] != 0) [[unlikely]]
      reciprocal[axis] = std::numeric_limits<float>::quiet_NaN();
  return reciprocal;
}

// What the slab test needs of a ray. Zero components give reciprocals of infinity with the component's sign; the near and far
// planes of each axis are picked by the sign bit, so -0 is as good as any negative number.
struct SlabRay {
  vec3 origin, reciprocal;
  bool negative[3];

  explicit SlabRay(const Ray& ray)
      : origin(ray.origin),
        reciprocal(slab_reciprocal(ray.direction)),
        negative{std::signbit(ray.direction.x), std::signbit(ray.direction.y), std::signbit(ray.direction.z)} {}
};

// Branch-free slab test ([Williams2005], [Ize2013]): entry distance, or infinity when the box is missed.
//
// Rule for a ray parallel to a slab: outside it one product is the infinity that misses; inside, both are infinities that do
// not restrict; on a face 0 * infinity is NaN, and the comparisons are ordered so that a NaN restricts nothing: faces belong to
// the box. The far distance is padded by 4 epsilon, above the 2 gamma(3) by which rounding can part near from far, so that no
// box is lost whose content is hit.
inline float slab_entry(const SlabRay& ray, const vec3& lower, const vec3& upper, float t_min, float t_max) {
  constexpr float pad = 1.0f + 4 * std::numeric_limits<float>::epsilon();
  float near = t_min, far = t_max;
  for (int axis = 0; axis < 3; ++axis) {
    const float near_plane = ray.negative[axis] ? upper[axis] : lower[axis];
    const float far_plane = ray.negative[axis] ? lower[axis] : upper[axis];
    const float t_near = (near_plane - ray.origin[axis]) * ray.reciprocal[axis];
    const float t_far = (far_plane - ray.origin[axis]) * ray.reciprocal[axis] * pad;
    near = t_near > near ? t_near : near;
    far = t_far < far ? t_far : far;
  }
  return near <= far ? near : infinity;
}

}  // namespace etendue
