#include "accel/exact/exact_primitives.h"

#include <algorithm>

namespace etendue {

namespace {

// `rim`: how far outside, in barycentric weight, still counts as inside.
std::optional<ExactCrossing> cross_triangle(const ExactRay& ray, const dvec3& p0, const dvec3& p1, const dvec3& p2,
                                            double rim) {
  const dvec3 a = p0 - ray.origin, b = p1 - ray.origin, c = p2 - ray.origin;
  const double u = glm::dot(glm::cross(c, b), ray.direction), v = glm::dot(glm::cross(a, c), ray.direction),
               w = glm::dot(glm::cross(b, a), ray.direction);
  const double sum = u + v + w, sign = sum < 0 ? -1 : 1;
  if (sum == 0 || std::min({sign * u, sign * v, sign * w}) < -rim * sign * sum) return std::nullopt;
  const dvec3 normal = glm::cross(p1 - p0, p2 - p0);
  const double t = glm::dot(a, normal) / glm::dot(ray.direction, normal);
  if (!ray.in_range(t)) return std::nullopt;
  return ExactCrossing{t, normal};
}

// The two roots of |o + t d| = radius, in order; none where the line passes by.
std::optional<dvec2> roots(const dvec3& o, const dvec3& d, double radius) {
  const double a = glm::dot(d, d), b = -glm::dot(o, d);
  if (a == 0) return std::nullopt;
  const dvec3 remainder = o + (b / a) * d;
  const double discriminant = radius * radius - glm::dot(remainder, remainder);
  if (discriminant < 0) return std::nullopt;
  const double half = std::sqrt(discriminant / a);
  return dvec2(b / a - half, b / a + half);
}

struct CrossQuadric {
  const ExactRay& ray;
  double rim;
  std::optional<ExactCrossing> nearest;

  void offer(double t, const dvec3& normal) {
    if (ray.in_range(t) && (!nearest || t < nearest->t)) nearest = ExactCrossing{t, normal};
  }
  void operator()(const Sphere& s) {
    const dvec3 centre(s.centre);
    const double radius = s.radius * (1 + rim);
    if (const auto t = roots(ray.origin - centre, ray.direction, radius))
      for (int i = 0; i < 2; ++i) offer((*t)[i], ray.at((*t)[i]) - centre);
  }
  void operator()(const Disk& d) { disk(dvec3(d.centre), dvec3(d.normal), d.radius, d.inner_radius); }
  void operator()(const Cylinder& c) {
    const dvec3 axis = glm::normalize(dvec3(c.axis)), base(c.base), o = ray.origin - base;
    const auto across = [&](const dvec3& v) { return v - glm::dot(v, axis) * axis; };
    if (const auto t = roots(across(o), across(ray.direction), c.radius * (1 + rim)))
      for (int i = 0; i < 2; ++i) {
        const dvec3 p = ray.at((*t)[i]) - base;
        const double height = glm::dot(p, axis), slack = rim * c.length;
        if (height >= -slack && height <= c.length + slack) offer((*t)[i], across(p));
      }
    if (!c.caps) return;
    disk(base, axis, c.radius, 0);
    disk(base + static_cast<double>(c.length) * axis, axis, c.radius, 0);
  }
  void disk(const dvec3& centre, const dvec3& normal, double radius, double inner_radius) {
    const double cosine = glm::dot(ray.direction, normal);
    if (cosine == 0) return;
    const double t = glm::dot(centre - ray.origin, normal) / cosine, distance = glm::length(ray.at(t) - centre);
    if (distance <= radius * (1 + rim) && distance >= inner_radius * (1 - rim)) offer(t, normal);
  }
};

}  // namespace

std::optional<ExactCrossing> cross(const InfinitePlane& plane, const ExactRay& ray) {
  const dvec3 normal(plane.normal);
  const double t = glm::dot(dvec3(plane.point) - ray.origin, normal) / glm::dot(ray.direction, normal);
  if (!ray.in_range(t) || !std::isfinite(t)) return std::nullopt;
  return ExactCrossing{t, normal};
}

std::optional<ExactCrossing> cross(const Geometry& geometry, std::uint32_t primitive, const ExactLocalRay& local, double rim) {
  if (geometry.is_triangle(primitive)) {
    const uvec3 v = geometry.triangles[primitive];
    const auto& p = geometry.positions;
    return cross_triangle(local.ray, local.vertex(p[v.x]), local.vertex(p[v.y]), local.vertex(p[v.z]), rim);
  }
  CrossQuadric visitor{local.ray, rim, {}};
  std::visit(visitor, geometry.quadric(primitive));
  return visitor.nearest;
}

double distance_to_segment(const dvec3& p, const dvec3& a, const dvec3& b) {
  const dvec3 ab = b - a;
  const double square = glm::dot(ab, ab), t = square > 0 ? std::clamp(glm::dot(p - a, ab) / square, 0.0, 1.0) : 0;
  return glm::distance(p, a + t * ab);
}

double distance_to_triangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
  const dvec3 normal = glm::cross(b - a, c - a);
  const auto inside = [&](const dvec3& from, const dvec3& to) {
    return glm::dot(glm::cross(to - from, p - from), normal) >= 0;
  };
  if (inside(a, b) && inside(b, c) && inside(c, a)) return std::abs(glm::dot(p - a, glm::normalize(normal)));
  return std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
}

}  // namespace etendue
