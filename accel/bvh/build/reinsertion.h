// Optimisation of a finished tree: subtrees are taken out and put back where they cost least ([Bittner2013]), many at a time
// ([Meister2018Reinsertion]).
//
// A pass looks, for each node in parallel, for the place in the whole tree where the node would lower the sum of box areas
// most, by a branch-and-bound search up its ancestors and down into their other sides. Then it applies the moves one after
// another, the greatest gain first, and leaves out those that touch a node already touched. All searches see the same tree and
// the order of moves is fixed, so the result is the same at any thread count. Leaves are moved but never divided or joined. The
// tree may grow deeper than its builder's max_depth.
#pragma once

#include "accel/bvh/build/binary_tree.h"

namespace etendue {

// Stops early after a pass whose gain is not worth its time.
void reinsert_subtrees(BinaryTree& tree, int passes);

}  // namespace etendue
