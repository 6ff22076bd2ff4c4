// The cheapest cut of a handful of boxes by the surface area heuristic: every position on three axes, as sah.h, but
// sorted anew by a network ([Batcher1968]) that sorts all three axes at once. Most nodes of a tree hold so few primitives that
// this costs less than clearing bins for them.
#pragma once

#include "accel/bvh/build/binary_tree.h"

namespace etendue {

inline constexpr std::uint32_t small_sweep_size = 12;  // at most 16

struct SmallCut {
  float cost = infinity;   // primitive tests on both sides, weighted by area; not finite: areas beyond the range of float
  std::uint32_t left = 0;  // how many items go left
  std::uint8_t order[small_sweep_size];  // items along the axis of the cut
};

// The cheapest cut of 2 to small_sweep_size items; where several cost the same, the one nearest the middle. Centres equal in
// their upper 20 bits of precision count as equal and keep the order of the items.
SmallCut sweep_small(const BuildItem* items, std::uint32_t count);

}  // namespace etendue
