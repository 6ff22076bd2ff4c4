// A leaf of the narrower wide layouts: a few triangles side by side, by vertex, axis and lane, tested together by SIMD
// instructions (wide_tests.inl). Unused lanes hold NaN, which nothing hits. Ids ascend. Of a needle, each corner is the first
// one: its edge functions are then zero for every ray, as where a ray meets an edge, and the scalar test is asked.
#pragma once

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
  unsigned used() const { return ~0u; }
};

}  // namespace etendue
