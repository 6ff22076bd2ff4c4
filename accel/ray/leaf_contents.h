// The vertices behind the primitives of a tree, copied in the order of its leaves: packs are then made from consecutive memory.
// Looking triangles up one by one would cost more than everything else in making packs.
#pragma once

#include "accel/ray/binary_tree.h"
#include "accel/ray/corner_repeats.h"
#include "accel/ray/vertex_ids.h"

namespace etendue {

struct LeafContents {
  UninitialisedArray<uvec3> corners;  // of triangles: vertices, equal at the same position, unless there are repeats
  UninitialisedArray<float> areas;
  CornerRepeats repeats{};  // or none

  static LeafContents uninitialised(std::size_t primitives) {
    return {uninitialised_on_huge_pages<uvec3>(primitives), uninitialised_on_huge_pages<float>(primitives)};
  }
  static LeafContents of(const VertexIds& vertices, const BinaryTree& tree);
};

}  // namespace etendue
