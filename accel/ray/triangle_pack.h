// The leaves of wide trees: a few triangles side by side, tested together by SIMD instructions (wide_tests.inl).
#pragma once

#include "framework/scene/geometry.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace etendue {

// The vertices of a geometry by position: readers of meshes often repeat one where its normal or texture coordinates change.
class VertexIds {
 public:
  explicit VertexIds(const Geometry& geometry);

  // A triangle's corners as indices into Geometry::positions, equal at the same position.
  uvec3 operator()(std::uint32_t triangle) const {
    const uvec3& v = geometry_->triangles[triangle];
    return first_equal_.empty() ? v : uvec3(first_equal_[v.x], first_equal_[v.y], first_equal_[v.z]);
  }
  // Of each primitive in turn; of a quadric, nothing. In the order of a tree's leaves, what is next needed then lies next: to
  // look triangles up one by one costs more than all else in making packs of them.
  std::vector<uvec3> in_order(std::span<const std::uint32_t> primitives) const;
  const Geometry& geometry() const { return *geometry_; }

 private:
  const Geometry* geometry_;
  std::vector<std::uint32_t> first_equal_;  // by vertex; empty where few vertices can be repeated
};

// Tells builders which runs of primitives a pack takes, so that they need not cut these only for a collapse to join them again.
class PackTest {
 public:
  template <class Pack>
  static PackTest of(const VertexIds& vertices) {
    return {vertices, Pack::lanes, Pack::fits};
  }

  std::uint32_t lanes() const { return lanes_; }
  // `id(i)` for i < count: the run.
  template <class Id>
  bool takes(std::uint32_t count, const Id& id) const {
    if (count > lanes_) return false;
    std::array<uvec3, max_lanes> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!vertices_->geometry().is_triangle(id(i))) return false;
      triangles[i] = (*vertices_)(id(i));
    }
    return fits_(std::span(triangles).first(count));
  }

 private:
  using Fits = bool (*)(std::span<const uvec3>);
  static constexpr std::uint32_t max_lanes = 16;

  PackTest(const VertexIds& vertices, std::uint32_t lanes, Fits fits) : vertices_(&vertices), lanes_(lanes), fits_(fits) {}

  const VertexIds* vertices_;
  std::uint32_t lanes_;
  Fits fits_;
};

// A leaf of the narrower layouts: triangles by vertex, axis and lane. Unused lanes hold NaN, which nothing hits. Ids ascend.
template <int width>
struct alignas(4 * width) TrianglePack {
  static constexpr int lanes = width;

  float vertices[3][3][width];
  std::uint32_t ids[width];

  TrianglePack();
  static bool fits(std::span<const uvec3> triangles) { return triangles.size() <= width; }
  void fill(const Geometry& geometry, std::span<const std::uint32_t> ids, std::span<const uvec3> triangles);
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
  static bool fits(std::span<const uvec3> triangles);
  void fill(const Geometry& geometry, std::span<const std::uint32_t> ids, std::span<const uvec3> triangles);
  vec3 vertex(int lane, int corner) const {
    const int slot = corners[corner][lane];
    return {vertices[0][slot], vertices[1][slot], vertices[2][slot]};
  }
  unsigned used() const { return (1u << count) - 1; }
};

}  // namespace etendue
