// Full-sweep SAH builder: every cut is the cheapest by the surface area heuristic among all n - 1 positions on each of three
// axes, in the order of the primitives' centres ([MacDonald1990]; the sweep over boxes is that of [Wald2007]).
//
// The centres are sorted once per axis; each cut then keeps the three orders by stable partitions. So a level costs O(n) and
// the tree O(n log n). Cuts of equal cost go to the one nearest the middle, which balances piles of equal boxes; the depth
// stays within max_depth by halving (grow_tree.h).
#pragma once

#include "accel/bvh/build/binary_tree.h"

namespace etendue {

BinaryTree build_sah(BuildItems items, const SahParams& params);

struct RayEntry sah_entry();  // its row of the registry

}  // namespace etendue
