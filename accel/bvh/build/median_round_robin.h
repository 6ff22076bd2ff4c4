// Round-robin median builder, as teaching notes have it: at depth d the primitives are sorted by the centre of their boxes
// along axis d mod 3, and the run is cut in half ([Kay1986]; the order is that of the first k-d trees, [Bentley1975]).
//
// A run of at most `triangle_threshold` primitives is a leaf, and so is a node at `max_depth`, whatever it holds. Both hold for
// each tree, of which a scene has one per object: where meshes are objects, one per mesh. Sorting anew at every node costs
// O(n log^2 n), and an axis along which the primitives hardly spread is cut all the same: both belong to the method. Equal
// centres go by id.
#pragma once

#include "accel/bvh/build/binary_tree.h"

namespace etendue {

struct MedianRoundRobinParams : TreeLimits {};  // leaf_size is the notes' triangle_threshold

template <class Visitor>
void describe(Visitor& v, MedianRoundRobinParams& params) {
  v.integer(
      "triangle_threshold", params.leaf_size, 0, 64, "primitives",
      "a run of at most so many is a leaf; 0, and in wide layouts at most: 4 in the binary layout, a pack in the wide ones");
  describe_max_depth(v, params);
}

BinaryTree build_median_round_robin(BuildItems items, const MedianRoundRobinParams& params);

struct RayEntry median_round_robin_entry();  // its row of the registry

}  // namespace etendue
