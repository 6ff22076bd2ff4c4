// The leaves of wide trees: a few triangles side by side, tested together by SIMD instructions (wide_tests.inl).
#pragma once

#include "framework/scene/geometry.h"

#include <cstdint>
#include <span>
#include <vector>

namespace etendue {

// The vertices of a geometry by position: readers of meshes often repeat one where its normal or texture coordinates change.
class VertexIds {
 public:
  explicit VertexIds(const Geometry& geometry);

  // Equal for corners at the same position; an index into Geometry::positions.
  std::uint32_t operator()(std::uint32_t triangle, int corner) const {
    const std::uint32_t vertex = geometry_->triangles[triangle][corner];
    return first_equal_.empty() ? vertex : first_equal_[vertex];
  }
  const Geometry& geometry() const { return *geometry_; }

 private:
  const Geometry* geometry_;
  std::vector<std::uint32_t> first_equal_;  // by vertex; empty where few vertices can be repeated
};

// A leaf of the narrower layouts: triangles by vertex, axis and lane. Unused lanes hold NaN, which nothing hits. Ids ascend.
template <int width>
struct alignas(4 * width) TrianglePack {
  static constexpr int lanes = width;

  float vertices[3][3][width];
  std::uint32_t ids[width];

  TrianglePack();
  static bool fits(const VertexIds&, std::span<const std::uint32_t> triangles) { return triangles.size() <= width; }
  void fill(const VertexIds& vertices, std::span<const std::uint32_t> triangles);
  vec3 vertex(int lane, int corner) const {
    return {vertices[corner][0][lane], vertices[corner][1][lane], vertices[corner][2][lane]};
  }
  unsigned used() const { return ~0u; }
};

// A leaf of `wide16`: up to sixteen triangles over up to sixteen different vertices. Neighbours in a mesh share vertices, so
// each is stored, and moved into the ray's space, once; the triangles pick theirs by a permutation of lanes. Ids ascend.
struct alignas(64) SharedPack {
  static constexpr int lanes = 16, slots = 16;

  float vertices[3][slots];             // by axis
  std::uint8_t corners[3][lanes] = {};  // the slot of each triangle's first, second and third vertex
  std::uint32_t count = 0;
  alignas(64) std::uint32_t ids[lanes];  // a line of its own, read for a hit only

  SharedPack();
  static bool fits(const VertexIds& vertices, std::span<const std::uint32_t> triangles);
  void fill(const VertexIds& vertices, std::span<const std::uint32_t> triangles);
  vec3 vertex(int lane, int corner) const {
    const int slot = corners[corner][lane];
    return {vertices[0][slot], vertices[1][slot], vertices[2][slot]};
  }
  unsigned used() const { return (1u << count) - 1; }
};

}  // namespace etendue
