// The boxes of a mesh's triangles one after the other, where builders begin.
#pragma once

#include "accel/kernels/simd_bounds.h"
#include "framework/scene/geometry.h"

#include <algorithm>

namespace etendue {

struct TriangleBox {
  FourFloats lower, upper;  // without negative zeros, so that no tree depends on the order of a minimum
  bool is_valid;            // Geometry::is_valid

  Bounds bounds() const { return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}}; }
};

// Prefetches the vertices of a triangle to which a loop along them comes soon.
inline TriangleBox triangle_box(const Geometry& geometry, std::uint32_t triangle) {
  const uvec3 soon = geometry.triangles[std::min<std::size_t>(triangle + 16, geometry.triangles.size() - 1)];
  for (int corner = 0; corner < 3; ++corner) __builtin_prefetch(&geometry.positions[soon[corner]]);
  const uvec3 v = geometry.triangles[triangle];
  const FourFloats a = four(geometry.positions[v.x]), b = four(geometry.positions[v.y]), c = four(geometry.positions[v.z]);
  const FourFloats lower = smaller(smaller(a, b), c) + 0.0f, upper = larger(larger(a, b), c) + 0.0f;
  // Single precision tells what is clearly finite and not empty.
  const FourFloats ab = b - a, ac = c - a, normal = cross(ab, ac);
  const float square = dot(normal, normal);
  const bool is_plain = square > 1e-30f && square < infinity && square > 1e-10f * dot(ab, ab) * dot(ac, ac);
  return {lower, upper, is_plain || geometry.is_valid(triangle)};
}

}  // namespace etendue
