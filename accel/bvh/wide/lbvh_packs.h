// The linear BVH of lbvh.h straight down to packs of triangles, for the wide layouts: what a general build goes through
// on the way (a box per primitive, a tree of all of them, their vertices told apart over the whole mesh) is left out.
//
// Triangles are sorted by code with no more than their centres at hand, then visited once in that order, which yields all that
// packs are made of: corners, areas, and which vertices neighbours share (corner_repeats.h). Runs are then cut from the root
// down until a pack takes them; packs filled, and boxes united from them up. Parallel over subtrees (oneTBB), with the same
// tree at any thread count, that of build_lbvh with a PackTest which knows every vertex.
#pragma once

#include "accel/bvh/wide/pack_tree.h"

#include <optional>

namespace etendue {

// Nothing where some leaf would be no pack: with quadrics, or where max_depth ends a run that is too long for one.
template <class Pack>
std::optional<PackTree<Pack>> build_lbvh_packs(const Geometry& geometry, const TreeLimits& limits);

}  // namespace etendue
