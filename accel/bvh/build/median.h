// Median builder: every cut halves the number of primitives, at the median of their centres on the axis where the centres
// spread most ([Kay1986], with the axis chosen by extent). The depth is ceil(log2(n / leaf_size)), the build O(n log n) with
// nth_element at each level; it knows nothing of surface areas.
#pragma once

#include "accel/bvh/build/binary_tree.h"

namespace etendue {

BinaryTree build_median(BuildItems items, const TreeLimits& limits);

struct RayEntry median_entry();  // its row of the registry

}  // namespace etendue
