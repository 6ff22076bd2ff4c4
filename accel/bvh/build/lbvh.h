// Linear BVH: the primitives sorted by the Morton codes of their centres (morton_order.h), and cut where the highest bit in
// which the codes of a run differ changes ([Lauterbach2009]; the hierarchy is that of [Karras2012], found from the root down).
// Each cut is thus the middle of a cell of an octree, one axis after the other. It ignores surface areas, and builds in the
// least time of all (results/meshes).
//
// Deviations: runs of equal codes are halved, so that coincident centres cost no depth; a run of at most `leaf_size` is a leaf.
// The depth is at most 63 and that of the halves, and never above max_depth, near which runs are halved.
#pragma once

#include "accel/bvh/build/binary_tree.h"

namespace etendue {

struct LbvhParams : TreeLimits {
  static constexpr bool sorts_to_packs = true;  // lbvh_packs.h makes the same trees over triangles
};

BinaryTree build_lbvh(BuildItems items, const LbvhParams& limits);

struct RayEntry lbvh_entry();  // its row of the registry

}  // namespace etendue
