// The parts of a primitive on either side of an axis-aligned plane, as boxes.
#pragma once

#include "accel/bvh/build/binary_tree.h"

namespace etendue {

struct SplitParts {
  Bounds left, right;
};

// `item.bounds` is the box of the part of the primitive to be split, and straddles the plane; both results lie within it. The
// parts of a triangle are padded by the rounding of its edges' intersections with the plane, so that together they miss none of
// its points. `geometry` null: the item is its box.
SplitParts split_primitive(const Geometry* geometry, const BuildItem& item, int axis, float plane);

}  // namespace etendue
