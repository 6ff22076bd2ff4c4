// A binary tree over packs of triangles: what a builder leaves that makes the packs of a wide layout itself.
#pragma once

#include "accel/bvh/build/binary_tree.h"
#include "framework/core/huge_pages.h"

namespace etendue {

template <class Pack>
struct PackTree {
  BinaryTree tree;  // its primitives are packs, one a leaf, from left to right; there is no list of them
  HugePageVector<Pack> packs;
  // Each pack has the number of its triangles here, and their area.
  UninitialisedArray<std::uint8_t> counts{};
  UninitialisedArray<float> areas{};
};

}  // namespace etendue
