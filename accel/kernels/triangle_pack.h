// A leaf of the narrower layouts: a few triangles side by side, by vertex, axis and lane, tested together by SIMD instructions
// (pack_query.h). Unused lanes hold NaN, which nothing hits. Ids ascend. A needle has its first corner in place of all three:
// its edge functions are then zero for every ray, as where a ray meets an edge, and the scalar test is asked.
#pragma once

#include "accel/kernels/triangle_test.h"
#include "framework/scene/geometry.h"

#include <cstdint>
#include <span>

namespace etendue {

template <int width>
struct alignas(4 * width) TrianglePack {
  static constexpr int lanes = width;

  float vertices[3][3][width];
  std::uint32_t ids[width];

  TrianglePack();
  static bool fits(std::span<const uvec3> triangles) { return triangles.size() <= width; }
  void fill(const Geometry& geometry, std::span<const std::uint32_t> ids, std::span<const uvec3> triangles);
  void set(std::size_t lane, const vec3& a, const vec3& b, const vec3& c) {
    const bool needle = is_needle(a, b, c);
    place(lane, a, needle ? a : b, needle ? a : c);
  }
  // Does not ask whether it is a needle.
  void place(std::size_t lane, const vec3& a, const vec3& b, const vec3& c) {
    for (int axis = 0; axis < 3; ++axis) {
      vertices[0][axis][lane] = a[axis];
      vertices[1][axis][lane] = b[axis];
      vertices[2][axis][lane] = c[axis];
    }
  }
  vec3 vertex(int lane, int i) const { return {vertices[i][0][lane], vertices[i][1][lane], vertices[i][2][lane]}; }
  unsigned used() const { return ~0u; }
  unsigned needles() const { return 0; }  // none that is not on an edge
};

}  // namespace etendue
