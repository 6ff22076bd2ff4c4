// Midpoint builder: every cut is at the middle of the longest edge of the node's box, the cheapest rule that looks at space at
// all ([Waechter2006] cuts its hierarchies there too).
//
// Exactly: a primitive goes left when the centre of its box lies below the middle of the node's box on the axis of the node's
// longest edge. Such a cut is undone when a side stays empty; then the next longest edge is tried, then the shortest, and when
// all three fail the run is halved at the median of the centres (grow_tree.h). A run of at most `leaf_size` is a leaf. A level
// costs a pass over the items; a level of an uneven scene may part off a single one, so the depth is bounded only by
// max_depth, near which runs are halved.
#pragma once

#include "accel/bvh/build/binary_tree.h"

namespace etendue {

BinaryTree build_midpoint(BuildItems items, const TreeLimits& limits);

struct RayEntry midpoint_entry();  // its row of the registry

}  // namespace etendue
