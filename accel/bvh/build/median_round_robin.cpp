#include "accel/bvh/build/median_round_robin.h"

#include "accel/bvh/build/grow_tree.h"
#include "accel/bvh/bvh_entry.h"
#include "accel/kernels/simd_bounds.h"

namespace etendue {

namespace {

struct RoundRobinSplitter {
  std::span<BuildItem> items;
  std::uint32_t triangle_threshold;

  std::optional<Split> best(const ItemRange& range) {
    if (range.size() <= triangle_threshold) return std::nullopt;
    return halve(range);
  }

  Split halve(const ItemRange& range) {
    const int axis = static_cast<int>(range.depth % 3);
    const auto centre = [axis](const BuildItem& item) {
      return 0.5f * item.bounds.lower[axis] + 0.5f * item.bounds.upper[axis];
    };
    std::sort(items.begin() + range.begin, items.begin() + range.end, [&](const BuildItem& a, const BuildItem& b) {
      const float ca = centre(a), cb = centre(b);
      return ca < cb || (ca == cb && a.id < b.id);
    });
    const std::uint32_t middle = range.begin + range.size() / 2;
    SimdBounds sides[2];
    for (std::uint32_t i = range.begin; i < range.end; ++i) sides[i >= middle].extend(items[i].bounds);
    return {middle, sides[0].get(), sides[1].get()};
  }

  std::uint32_t id(const ItemRange&, std::uint32_t position) const { return items[position].id; }
};

}  // namespace

BinaryTree build_median_round_robin(BuildItems items, const MedianRoundRobinParams& params) {
  RoundRobinSplitter splitter{items, static_cast<std::uint32_t>(params.leaf_size)};
  return grow_tree(splitter, items, params);
}

RayEntry median_round_robin_entry() {
  return bvh_entry<MedianRoundRobinParams, build_median_round_robin>(
      "median-round-robin", "bounding volume hierarchy, sorted and halved along x, y, z in turn", 44);
}

}  // namespace etendue
