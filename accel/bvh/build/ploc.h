// PLOC: parallel locally-ordered clustering ([Meister2018]). Primitives lie along the Morton curve; each cluster looks for the
// neighbour, at most `search_radius` places away, whose union with it has the least surface area, and those that chose each
// other merge, over and over, until one is left.
//
// Equally near neighbours go to the lowest place: then the first cluster of those that have the least distance of all is chosen
// back by the one it chooses, so every round merges a pair at least. A round that merges too few (coincident boxes, boxes that
// grow geometrically) merges places 2k and 2k + 1 instead, so the rounds stay O(log n) on any input. Subtrees that are dearer
// than a leaf of their primitives become one, as in the paper. Where a subtree is deeper than max_depth allows, its lower parts
// are replaced by halves in the order of the curve (link_tree.h). Distances are exact, and places follow from counts alone, so
// the tree is the same at any thread count.
#pragma once

#include "accel/bvh/build/binary_tree.h"

namespace etendue {

struct PlocParams : SahParams {
  int search_radius = 16;
};

template <class Visitor>
void describe(Visitor& v, PlocParams& params) {
  describe(v, static_cast<SahParams&>(params));
  v.integer("search_radius", params.search_radius, 1, 256, "places",
            "how far along the Morton curve a cluster looks for its neighbour");
}

BinaryTree build_ploc(BuildItems items, const PlocParams& params);

struct RayEntry ploc_entry();  // its row of the registry

}  // namespace etendue
