// Binned SAH builder: as the full sweep, but cuts are tried only between equal bins of the centres' extent, so that a level
// costs a pass over the items and no sorting at all ([Wald2007]).
//
// All three axes are tried. A node uses `bins` bins or, when it holds few primitives, fewer (see bins_for); a handful is swept
// exactly (small_sweep.h). Items change between two arrays at each level, and the boxes of centres that the next level needs
// are taken on the way, so a level reads the items twice and writes them once. Large runs are binned and parted by several
// threads: counts and boxes of bins merge exactly, in any order, and the parting is stable, so the tree is the same at any
// thread count. Items whose centres coincide are halved (grow_tree.h).
#pragma once

#include "accel/bvh/build/binary_tree.h"

namespace etendue {

struct BinnedSahParams : SahParams {
  int bins = 16;
};

template <class Visitor>
void describe(Visitor& v, BinnedSahParams& params) {
  describe(v, static_cast<SahParams&>(params));
  v.integer("bins", params.bins, 2, 256, "bins",
            "equal intervals of the centres' extent per axis, between which cuts are tried");
}

BinaryTree build_binned_sah(BuildItems items, const BinnedSahParams& params);

struct RayEntry binned_sah_entry();  // its row of the registry

}  // namespace etendue
