// The geometry that a bottom-level ray structure is built over: triangles and quadrics in one space, without materials or
// lights.
//
// Primitive ids run over the triangles first, then over the quadrics. A geometry of triangles only holds no quadric, and
// structures ask for that (`quadrics.empty()`) to take the triangle-only leaf.
#pragma once

#include "framework/core/vec.h"
#include "framework/query.h"

#include <cstdint>
#include <variant>
#include <vector>

namespace etendue {

struct Sphere {
  vec3 centre;
  float radius;
};

// The tube of points at `radius` from the segment base .. base + length * axis (axis unit), with flat caps if `caps`.
struct Cylinder {
  vec3 base;
  float radius;
  vec3 axis;
  float length;
  bool caps;
};

// Flat, facing `normal` (unit).
struct Disk {
  vec3 centre;
  float radius;
  vec3 normal;
  float inner_radius = 0;
};

using Quadric = std::variant<Sphere, Cylinder, Disk>;

Bounds quadric_bounds(const Quadric& quadric);
float quadric_area(const Quadric& quadric);
float quadric_extent(const Quadric& quadric);  // as clearance_of's

struct Geometry {
  std::vector<vec3> positions;
  std::vector<uvec3> triangles;
  std::vector<Quadric> quadrics;

  std::uint32_t primitive_count() const { return static_cast<std::uint32_t>(triangles.size() + quadrics.size()); }
  bool is_triangle(std::uint32_t primitive) const { return primitive < triangles.size(); }
  const Quadric& quadric(std::uint32_t primitive) const { return quadrics[primitive - triangles.size()]; }
  Bounds primitive_bounds(std::uint32_t primitive) const;
  // False for what no structure may hold: non-finite vertices, triangles of zero area, quadrics of zero size.
  bool is_valid(std::uint32_t primitive) const;
  // Ids of the valid primitives, ascending.
  std::vector<std::uint32_t> valid_primitives() const;
};

}  // namespace etendue
