// The vertices behind the primitives of a tree, copied in the order of its leaves: packs are then made from consecutive memory.
// Looking triangles up one by one would cost more than everything else in making packs.
#pragma once

#include "accel/bvh/build/binary_tree.h"
#include "accel/bvh/build/vertex_ids.h"
#include "framework/core/huge_pages.h"

namespace etendue {

struct LeafContents {
  UninitialisedArray<uvec3> corners;  // of triangles: vertices, equal at the same position
  UninitialisedArray<float> areas;

  static LeafContents of(const VertexIds& vertices, const BinaryTree& tree);
};

}  // namespace etendue
