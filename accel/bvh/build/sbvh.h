// Spatial splits builder: SAH over cuts between primitives and over cuts through them ([Stich2009]).
//
// A node is cut between bins of centres, as by the binned builder. Where the two sides then overlap by more than `alpha` of the
// root's area, planes between equal slabs of the node's box are tried as well. There, a primitive on both sides is listed in
// both, with the box of the part that lies there, unless it is cheaper to leave it whole on one side (section 4.3). Triangles
// are chopped exactly, quadrics by their boxes.
//
// A primitive may thus stand in several leaves. `duplication` bounds how often: of the extra references, each subtree owns a
// part in proportion to its size, so what one spends does not depend on the others, and the tree is the same at any thread
// count.
#pragma once

#include "accel/bvh/build/binary_tree.h"
#include "accel/scene/memory_budget.h"

namespace etendue {

struct SbvhParams : SahParams {
  int bins = 32;
  float alpha = 1e-3f;
  float duplication = 0.5f;
  const MemoryWatch* watch = nullptr;       // told of every added reference, counted as
  std::uint64_t bytes_per_reference = 220;  // bytes, the peak of a build in any layout
};

template <class Visitor>
void describe(Visitor& v, SbvhParams& params) {
  describe(v, static_cast<SahParams&>(params));
  v.integer("bins", params.bins, 2, 256, "bins", "equal intervals per axis, between which cuts are tried");
  v.number("alpha", params.alpha, 0, 1, "of the root's area",
           "overlap of two sides above which cuts through primitives are tried");
  v.number("duplication", params.duplication, 0, 16, "references per primitive", "beyond one each, at most");
}

// `items` are primitives of `geometry`. Without one (null) they are boxes, and chopped as such.
BinaryTree build_sbvh(BuildItems items, const SbvhParams& params, const Geometry* geometry);

struct RayEntry sbvh_entry();  // its row of the registry

}  // namespace etendue
