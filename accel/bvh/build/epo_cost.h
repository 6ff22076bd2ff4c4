// End-point overlap of a tree: the work of rays that end on a surface, where the surface area heuristic thinks of rays that
// pass through everything ([Aila2013]).
//
//   EPO = sum over nodes n of C_n A((S \ Q(n)) within n) / A(S)
//
// S is all surfaces, Q(n) those in n's subtree, A their area: the nodes whose box holds a surface that is none of theirs are
// visited for nothing by every ray that ends there. C_n is as in BinaryTree::sah_cost: 1 for an inner node, the count of
// primitives for a leaf. Boxes are closed, so a triangle that lies in a face of a box counts. The paper's blend of EPO with SAH
// has a weight fitted to each scene, so that the two are given apart.
//
// Only triangles count as surfaces; each is clipped to the boxes on its way down the tree in double precision.
#pragma once

#include "accel/bvh/build/binary_tree.h"

#include <cstdint>

namespace etendue {

struct EpoCost {
  double value = 0;
  std::uint32_t triangles = 0;  // that it was computed from
  bool sampled = false;         // not from all
};

// Exact where the tree holds at most `most_triangles`; above that estimated from as many, drawn in proportion to their area
// (systematically, from one seeded offset), so that the estimate is unbiased and always the same. 0 over no area.
EpoCost epo_cost(const BinaryTree& tree, const Geometry& geometry, std::uint32_t most_triangles);

}  // namespace etendue
