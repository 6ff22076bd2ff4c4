// Halves in the order of the file: programs write neighbours one after another, so that a tree may do without any sorting.
//
// Limits: as good as that order. A shuffled mesh makes a tree of boxes that all overlap.
#pragma once

#include "accel/bvh/build/grow_tree.h"
#include "accel/bvh/bvh_entry.h"

namespace etendue {

struct InOrderSplitter {
  std::span<const BuildItem> items;
  std::uint32_t leaf_size;

  std::optional<Split> best(const ItemRange& range) const {
    if (range.size() <= leaf_size) return std::nullopt;
    return halve(range);
  }
  Split halve(const ItemRange& range) const {
    const std::uint32_t middle = range.begin + range.size() / 2;
    const auto [left, left_centres] = extents(items.subspan(range.begin, middle - range.begin));
    const auto [right, right_centres] = extents(items.subspan(middle, range.end - middle));
    return {middle, left, right, left_centres, right_centres};
  }
  std::uint32_t id(const ItemRange&, std::uint32_t position) const { return items[position].id; }
};

inline BinaryTree build_in_order(BuildItems items, const TreeLimits& limits) {
  InOrderSplitter splitter{items, static_cast<std::uint32_t>(limits.leaf_size)};
  return grow_tree(splitter, items, limits);
}

inline RayEntry in_order_entry() {
  return bvh_entry<TreeLimits, build_in_order>("in-order", "halves in the order of the file", 20);
}

}  // namespace etendue
