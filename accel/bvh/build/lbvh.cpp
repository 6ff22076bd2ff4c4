#include "accel/bvh/build/lbvh.h"

#include "accel/bvh/build/link_tree.h"
#include "accel/bvh/build/morton_order.h"
#include "accel/bvh/bvh_entry.h"

namespace etendue {

namespace {

struct HighestBitCuts {
  std::span<const BuildItem> items;
  const MortonOrder& order;
  std::uint32_t leaf_size;

  std::optional<Cut> best(const Run& run) const {
    if (run.size() <= leaf_size) return std::nullopt;
    return Cut{order.cut(run.begin, run.end), 0, 0};
  }
  Cut halve(const Run& run) const { return {run.begin + run.size() / 2, 0, 0}; }
  void settle(const Run&) const {}
  const BuildItem& item(std::uint32_t position) const { return items[position]; }
};

}  // namespace

BinaryTree build_lbvh(BuildItems items, const LbvhParams& limits) {
  if (items.empty()) return {};
  const MortonOrder order = sort_by_morton_code(items);
  HighestBitCuts cuts{items, order, static_cast<std::uint32_t>(limits.leaf_size)};
  return TreeLinker(cuts, static_cast<std::uint32_t>(items.size()), limits).link(0);
}

RayEntry lbvh_entry() {
  return bvh_entry<LbvhParams, build_lbvh>("lbvh", "bounding volume hierarchy, cut by the Morton codes of centres", 60);
}

}  // namespace etendue
