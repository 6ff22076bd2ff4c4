// A binary tree over packs of triangles: what a builder leaves that makes the packs of a wide layout itself.
#pragma once

#include "accel/ray/binary_tree.h"
#include "framework/core/huge_pages.h"

#include <vector>

namespace etendue {

// Of values that are constructed in place after a resize, by the threads that know them.
template <class T>
struct UnconstructedOnHugePages : HugePageAllocator<T> {
  using value_type = T;

  UnconstructedOnHugePages() = default;
  template <class U>
  UnconstructedOnHugePages(const UnconstructedOnHugePages<U>&) {}

  static void construct(T*) {}
};

template <class T>
using HugePageVector = std::vector<T, UnconstructedOnHugePages<T>>;

template <class Pack>
struct PackTree {
  BinaryTree tree;  // its primitives are packs, one a leaf, from left to right; there is no list of them
  HugePageVector<Pack> packs;
  // By pack: its triangles, and their area.
  UninitialisedArray<std::uint8_t> counts{};
  UninitialisedArray<float> areas{};
};

}  // namespace etendue
