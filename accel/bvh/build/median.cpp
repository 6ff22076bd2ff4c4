#include "accel/bvh/build/median.h"

#include "accel/bvh/build/grow_tree.h"
#include "accel/bvh/bvh_entry.h"

namespace etendue {

namespace {

struct MedianSplitter {
  std::span<BuildItem> items;
  std::uint32_t leaf_size;

  std::optional<Split> best(const ItemRange& range) {
    if (range.size() <= leaf_size) return std::nullopt;
    return halve(range);
  }
  Split halve(const ItemRange& range) { return halve_items(items, range); }
  std::uint32_t id(const ItemRange&, std::uint32_t position) const { return items[position].id; }
};

}  // namespace

BinaryTree build_median(BuildItems items, const TreeLimits& limits) {
  MedianSplitter splitter{items, static_cast<std::uint32_t>(limits.leaf_size)};
  return grow_tree(splitter, items, limits);
}

RayEntry median_entry() {
  return bvh_entry<TreeLimits, build_median>("median", "bounding volume hierarchy, halved at the median of centres", 20);
}

}  // namespace etendue
