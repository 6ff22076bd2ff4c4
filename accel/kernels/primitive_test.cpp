#include "accel/kernels/primitive_test.h"

#include "framework/core/arc.h"
#include "framework/scene/clearance.h"

#include <algorithm>
#include <optional>

namespace etendue {

namespace {

struct Quadratic {
  float near, far;
};

// Both roots of |o + t d| = r for o, d in the space where the surface is a sphere (or, projected, a circle) about 0. The
// discriminant is taken from the remainder of o after projecting on d, which keeps it exact for distant origins; the roots
// come from [Haines2019]'s stable form. What rounding leaves of the remainder along d is large beside the radius where an
// instance is flat and o is far away by the measure of its thickness: it is then taken off once more.
std::optional<Quadratic> solve(const vec3& o, const vec3& d, float radius) {
  const float a = glm::dot(d, d);
  if (a == 0) return std::nullopt;
  const float b = -glm::dot(o, d);
  vec3 remainder = o + (b / a) * d;
  if (const float along = glm::dot(remainder, d); square(along) > most_along * a * square(radius)) [[unlikely]]
    remainder -= (along / a) * d;
  const float discriminant = radius * radius - glm::dot(remainder, remainder);
  if (!(discriminant >= 0)) return std::nullopt;
  const float c = glm::dot(o, o) - radius * radius;
  // Where a ray's direction is its whole way, the product may leave the range of floats.
  const float product = a * discriminant;
  const bool in_range = product > 1e-30f && product < infinity;
  const float q = b + std::copysign(in_range ? std::sqrt(product) : std::sqrt(a) * std::sqrt(discriminant), b);
  const float t0 = q == 0 ? 0 : c / q, t1 = q / a;
  return t0 < t1 ? Quadratic{t0, t1} : Quadratic{t1, t0};
}

struct IntersectQuadric {
  const Ray& ray;
  float t_max;
  float& t_out;
  vec2& uv_out;

  bool in_range(float t) const { return t > ray.t_min && t <= t_max; }
  bool accept(float t, const vec2& uv) {
    t_out = t;
    uv_out = uv;
    return true;
  }

  bool operator()(const Sphere& s) {
    const auto roots = solve(ray.origin - s.centre, ray.direction, s.radius);
    if (!roots) return false;
    const float t = in_range(roots->near) ? roots->near : roots->far;
    if (!in_range(t)) return false;
    const vec3 p = (ray.at(t) - s.centre) / s.radius;
    return accept(t, {turn_of(p.x, p.y), 2 * turn_of(p.z, glm::length(vec2(p)))});
  }

  bool operator()(const Disk& d) { return ring({ray.origin - d.centre, d.normal, d.radius, d.inner_radius}, t_max, 0, 1); }

  // A flat ring and the ray's origin, both as seen from the ring's centre.
  struct Ring {
    vec3 origin, normal;
    float radius, inner_radius;
  };
  // v runs over [v_begin, v_end] from the rim to the centre.
  bool ring(const Ring& r, float limit, float v_begin, float v_end) {
    const float cosine = glm::dot(ray.direction, r.normal);
    if (cosine == 0) return false;
    const float t = -glm::dot(r.origin, r.normal) / cosine;
    if (!(t > ray.t_min && t <= limit)) return false;
    vec3 p = r.origin + t * ray.direction;
    if (const float off = glm::dot(p, r.normal); square(off) > most_along * square(r.radius)) [[unlikely]]
      p -= off * r.normal;
    const float distance = std::sqrt(glm::dot(p, p));
    if (distance > r.radius || distance < r.inner_radius) return false;
    const Frame frame = Frame::from_normal(r.normal);
    const float along = (r.radius - distance) / std::max(r.radius - r.inner_radius, std::numeric_limits<float>::min());
    return accept(t, {turn_of(glm::dot(p, frame.tangent), glm::dot(p, frame.bitangent)), glm::mix(v_begin, v_end, along)});
  }

  // The tube, then the caps: v is the height in [0, 1]; caps lie at v = 0 and v = 1 exactly. Where there are caps, both reach
  // beyond the rim by what their tests may be off, so that no ray passes between them.
  bool operator()(const Cylinder& c) {
    bool found = false;
    const vec3 o = ray.origin - c.base;
    const float slack = c.caps ? 16 * unit_roundoff * (max_component(glm::abs(o)) + c.length + c.radius) : 0;
    const float o_along = glm::dot(o, c.axis), d_along = glm::dot(ray.direction, c.axis);
    if (const auto roots = solve(o - o_along * c.axis, ray.direction - d_along * c.axis, c.radius)) {
      for (const float t : {roots->near, roots->far}) {
        const float height = o_along + t * d_along;
        if (found || !in_range(t) || height < -slack || height > c.length + slack) continue;
        const Frame frame = Frame::from_normal(c.axis);
        const vec3 p = o + t * ray.direction;
        const float v = std::clamp(height / c.length, 0x1p-20f, 1 - 0x1p-20f);
        found = accept(t, {turn_of(glm::dot(p, frame.tangent), glm::dot(p, frame.bitangent)), v});
      }
    }
    if (c.caps) {
      if (ring({o, -c.axis, c.radius + slack, 0}, found ? t_out : t_max, 0, 0)) found = true;
      if (ring({o - c.length * c.axis, c.axis, c.radius + slack, 0}, found ? t_out : t_max, 1, 1)) found = true;
    }
    return found;
  }
};

}  // namespace

bool place_on_needle(const Ray& ray, const TriangleRay& shear, const vec3& p0, const vec3& p1, const vec3& p2, float& t_out,
                     vec2& uv_out) {
  const dvec3 origin(ray.origin), direction(ray.direction);
  const double sx = direction[shear.kx] / direction[shear.kz], sy = direction[shear.ky] / direction[shear.kz];
  dvec3 corners[3];  // in the space where the ray is the axis; z in units of t
  for (int i = 0; i < 3; ++i) {
    const dvec3 p = dvec3(i == 0 ? p0 : i == 1 ? p1 : p2) - origin;
    corners[i] = {p[shear.kx] - sx * p[shear.kz], p[shear.ky] - sy * p[shear.kz], p[shear.kz] / direction[shear.kz]};
  }
  const auto [a, b, c] = corners;
  dvec3 weights{c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x};
  const double det = weights.x + weights.y + weights.z;
  if (det == 0) return false;
  // The plane's distance, even if the ray passes the needle by what single precision rounds away, but none beyond its corners.
  const auto [nearest, farthest] = std::minmax({a.z, b.z, c.z});
  const double t = std::clamp((weights.x * a.z + weights.y * b.z + weights.z * c.z) / det, nearest, farthest);
  constexpr double least = 1e-30;  // slab tests of different structures disagree about what is nearer
  t_out = std::abs(t) < least ? 0 : static_cast<float>(t);
  weights = glm::max(weights / det, dvec3(0));
  uv_out = dvec2(weights.y, weights.z) / (weights.x + weights.y + weights.z);
  return true;
}

bool intersect_quadric(const Ray& ray, const Quadric& quadric, float t_max, float& t_out, vec2& uv_out) {
  return std::visit(IntersectQuadric{ray, t_max, t_out, uv_out}, quadric);
}

}  // namespace etendue
