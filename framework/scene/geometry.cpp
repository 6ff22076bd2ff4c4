#include "framework/scene/geometry.h"

#include <type_traits>

namespace etendue {

namespace {

// Extent of a disk of unit radius along each axis: sqrt(1 - n_i^2), but by the other two components, lest rounding lose a small
// tilt.
vec3 disk_extent(const vec3& n) {
  return {glm::length(vec2(n.y, n.z)), glm::length(vec2(n.z, n.x)), glm::length(vec2(n.x, n.y))};
}

// Rounding in the extent must not cut off the surface: two ulp of the largest coordinate.
Bounds padded(Bounds b) {
  const vec3 largest = glm::max(glm::abs(b.lower), glm::abs(b.upper));
  const vec3 pad = largest * (4 * std::numeric_limits<float>::epsilon());
  return {b.lower - pad, b.upper + pad};
}

struct QuadricBounds {
  Bounds operator()(const Sphere& s) const { return padded({s.centre - s.radius, s.centre + s.radius}); }
  Bounds operator()(const Cylinder& c) const {
    const vec3 extent = c.radius * disk_extent(c.axis), top = c.base + c.length * c.axis;
    return padded({glm::min(c.base, top) - extent, glm::max(c.base, top) + extent});
  }
  Bounds operator()(const Disk& d) const {
    const vec3 extent = d.radius * disk_extent(d.normal);
    return padded({d.centre - extent, d.centre + extent});
  }
};

struct QuadricArea {
  float operator()(const Sphere& s) const { return 4 * pi * s.radius * s.radius; }
  float operator()(const Cylinder& c) const { return 2 * pi * c.radius * (c.length + (c.caps ? c.radius : 0)); }
  float operator()(const Disk& d) const { return pi * (d.radius * d.radius - d.inner_radius * d.inner_radius); }
};

// A quadratic equation's terms are squares of the radius: its roots are off by a few roundings of that.
struct QuadricExtent {
  float operator()(const Sphere& s) const { return 4 * s.radius; }
  float operator()(const Cylinder& c) const { return c.length + 4 * c.radius; }
  float operator()(const Disk& d) const { return d.radius; }
};

}  // namespace

Bounds quadric_bounds(const Quadric& quadric) { return std::visit(QuadricBounds{}, quadric); }

float quadric_area(const Quadric& quadric) { return std::visit(QuadricArea{}, quadric); }

float quadric_extent(const Quadric& quadric) { return std::visit(QuadricExtent{}, quadric); }

Bounds Geometry::primitive_bounds(std::uint32_t primitive) const {
  if (!is_triangle(primitive)) return quadric_bounds(quadric(primitive));
  Bounds b;
  for (int i = 0; i < 3; ++i) b.extend(positions[triangles[primitive][i]]);
  return b;
}

bool Geometry::is_valid(std::uint32_t primitive) const {
  if (!is_triangle(primitive)) {
    const Bounds b = quadric_bounds(quadric(primitive));
    const float area = quadric_area(quadric(primitive));
    return is_finite(b.lower) && is_finite(b.upper) && !b.empty() && area > 0 && std::isfinite(area);
  }
  const uvec3 v = triangles[primitive];
  const vec3 &p0 = positions[v.x], &p1 = positions[v.y], &p2 = positions[v.z];
  if (!is_finite(p0) || !is_finite(p1) || !is_finite(p2)) return false;
  // Double precision keeps small triangles from being taken for empty ones.
  const dvec3 cross = glm::cross(dvec3(p1) - dvec3(p0), dvec3(p2) - dvec3(p0));
  return glm::dot(cross, cross) > 0;
}

std::vector<std::uint32_t> Geometry::valid_primitives() const {
  std::vector<std::uint32_t> valid;
  valid.reserve(primitive_count());
  for (std::uint32_t i = 0; i < primitive_count(); ++i)
    if (is_valid(i)) valid.push_back(i);
  return valid;
}

}  // namespace etendue
