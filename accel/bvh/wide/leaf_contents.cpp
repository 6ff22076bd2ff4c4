#include "accel/bvh/wide/leaf_contents.h"

#include "framework/core/parallel.h"

namespace etendue {

namespace {

// Prefetches what lies behind two primitives that are looked at soon, the first of them later. This is always inlined, since
// GCC leaves out a call that has no other effect.
[[gnu::always_inline]] inline void prefetch(const VertexIds& vertices, std::uint32_t later, std::uint32_t sooner) {
  const Geometry& geometry = vertices.geometry();
  if (geometry.is_triangle(later)) __builtin_prefetch(&geometry.triangles[later]);
  if (!geometry.is_triangle(sooner)) return;
  const uvec3 v = vertices(sooner);
  for (int corner = 0; corner < 3; ++corner) __builtin_prefetch(&geometry.positions[v[corner]]);
}

}  // namespace

LeafContents LeafContents::of(const VertexIds& vertices, const BinaryTree& tree) {
  const Geometry& geometry = vertices.geometry();
  const std::size_t count = tree.primitives.size();
  LeafContents contents{uninitialised_on_huge_pages<uvec3>(count), uninitialised_on_huge_pages<float>(count)};
  const std::size_t last = count - 1;
  parallel_for(count, 1 << 11, [&](std::size_t i) {
    prefetch(vertices, tree.primitives[std::min(i + 24, last)], tree.primitives[std::min(i + 12, last)]);
    const std::uint32_t id = tree.primitives[i];
    if (!geometry.is_triangle(id)) {
      contents.corners[i] = uvec3(0);
      contents.areas[i] = quadric_area(geometry.quadric(id));
      return;
    }
    const uvec3 v = contents.corners[i] = vertices(id);
    const auto& p = geometry.positions;
    contents.areas[i] = 0.5f * glm::length(glm::cross(p[v.y] - p[v.x], p[v.z] - p[v.x]));
  });
  return contents;
}

}  // namespace etendue
