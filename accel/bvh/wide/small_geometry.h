// A geometry of tens of triangles as a batch of rays meets it: all of it, with a ray in each SIMD lane (small_geometry.inl).
// That takes less than to find out for each ray which few of the triangles it need be tested against.
#pragma once

#include "framework/scene/geometry.h"

#include <cstdint>
#include <vector>

namespace etendue {

class SmallGeometry {
 public:
  static constexpr std::size_t most_triangles = 64, most_vertices = 96, most_others = 4;

  struct alignas(16) Vertex {
    float coordinates[4];  // x, y, z, and one that does not count
  };
  struct Triangle {
    std::uint32_t id;
    std::uint8_t corners[3];  // among the vertices
  };

  SmallGeometry() = default;
  // Nothing is kept of a larger one.
  explicit SmallGeometry(const Geometry& geometry);

  bool empty() const { return triangles.empty(); }
  std::uint64_t bytes() const {
    return vertices.size() * sizeof(Vertex) + triangles.size() * sizeof(Triangle) + others.size() * 4;
  }

  std::vector<Vertex> vertices;       // each position once
  std::vector<Triangle> triangles;    // by rising id
  std::vector<std::uint32_t> others;  // quadrics, and triangles whose distance takes double precision
};

}  // namespace etendue
