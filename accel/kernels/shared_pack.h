// A leaf of `bvh16`: up to sixteen triangles over up to sixteen different vertices, tested together by SIMD instructions
// (pack_query.h). Neighbours in a mesh share vertices, so each is stored, and moved into the ray's space, once; the triangles
// pick theirs by a permutation of lanes. Ids ascend. A bit marks each needle: only where a ray meets one is the scalar
// test asked.
#pragma once

#include "framework/scene/geometry.h"

#include <cstdint>
#include <span>

namespace etendue {

struct alignas(64) SharedPack {
  static constexpr int lanes = 16, slots = 16;

  float vertices[3][slots];             // by axis
  std::uint8_t corners[3][lanes] = {};  // the slot of each triangle's first, second and third vertex
  std::uint32_t count = 0, needle_bits = 0;
  alignas(64) std::uint32_t ids[lanes];  // a line of its own, read for a hit only

  SharedPack();
  static bool fits(std::span<const uvec3> triangles);
  void fill(const Geometry& geometry, std::span<const std::uint32_t> ids, std::span<const uvec3> triangles);
  vec3 vertex(int lane, int corner) const {
    const int slot = corners[corner][lane];
    return {vertices[0][slot], vertices[1][slot], vertices[2][slot]};
  }
  void find_needles();  // when it is filled
  unsigned used() const { return (1u << count) - 1; }
  unsigned needles() const { return needle_bits; }
};

}  // namespace etendue
