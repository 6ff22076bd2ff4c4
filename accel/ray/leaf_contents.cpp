#include "accel/ray/leaf_contents.h"

#include "framework/core/parallel.h"

namespace etendue {

LeafContents LeafContents::of(const VertexIds& vertices, const BinaryTree& tree) {
  const Geometry& geometry = vertices.geometry();
  LeafContents contents = uninitialised(tree.primitives.size());
  parallel_for(tree.primitives.size(), 1 << 13, [&](std::size_t i) {
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
