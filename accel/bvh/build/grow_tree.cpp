#include "accel/bvh/build/grow_tree.h"

#include "accel/kernels/simd_bounds.h"
#include "framework/core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace etendue {

std::vector<TreeNode> without_gaps(const TreeNode* places, const PairMarks& used) {
  std::vector<std::uint32_t> before(used.words());  // pairs before each word
  std::uint32_t pairs = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    before[i] = pairs;
    pairs += static_cast<std::uint32_t>(std::popcount(used.word(i)));
  }
  const auto moved = [&](TreeNode node) {
    if (node.is_leaf()) return node;
    const std::uint32_t pair = node.first / 2;
    const std::uint64_t earlier = used.word(pair / 64) & ((std::uint64_t{1} << pair % 64) - 1);
    node.first = 2 * (before[pair / 64] + static_cast<std::uint32_t>(std::popcount(earlier))) + 1;
    return node;
  };
  std::vector<TreeNode> nodes;
  resize_on_huge_pages(nodes, 2 * std::size_t{pairs} + 1);
  nodes[0] = moved(places[0]);
  parallel_for(before.size(), 64, [&](std::size_t i) {
    if (used.word(i) == 0) return;
    TreeNode* to = &nodes[2 * std::size_t{before[i]} + 1];
    for (std::uint64_t rest = used.word(i); rest != 0; rest &= rest - 1) {
      const TreeNode* const from = &places[2 * (64 * i + static_cast<std::size_t>(std::countr_zero(rest))) + 1];
      *to++ = moved(from[0]);
      *to++ = moved(from[1]);
    }
  });
  return nodes;
}

std::pair<Bounds, Bounds> extents(std::span<const BuildItem> items) {
  using Extents = std::pair<Bounds, Bounds>;
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, items.size(), 1 << 13), Extents(),
      [&](const auto& range, Extents sum) {
        SimdBounds bounds;
        PointBounds centres;
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
          const SimdBounds item(items[i].bounds);
          bounds.extend(item);
          centres.extend(item.centre());
        }
        return Extents(united(bounds.get(), sum.first), united(centres.get(), sum.second));
      },
      [](const Extents& a, const Extents& b) { return Extents(united(a.first, b.first), united(a.second, b.second)); });
}

Split halve_items(std::span<BuildItem> items, const ItemRange& range) {
  Bounds centres;
  for (std::uint32_t i = range.begin; i < range.end; ++i) centres.extend(items[i].bounds.centre());
  const int axis = centres.longest_axis();
  const auto before = [axis](const BuildItem& a, const BuildItem& b) {
    const float ca = 0.5f * a.bounds.lower[axis] + 0.5f * a.bounds.upper[axis];
    const float cb = 0.5f * b.bounds.lower[axis] + 0.5f * b.bounds.upper[axis];
    return ca < cb || (ca == cb && a.id < b.id);
  };
  Split split{range.begin + range.size() / 2, {}, {}};
  std::nth_element(items.begin() + range.begin, items.begin() + split.middle, items.begin() + range.end, before);
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    const Bounds& bounds = items[i].bounds;
    (i < split.middle ? split.left : split.right).extend(bounds);
    (i < split.middle ? split.left_centres : split.right_centres).extend(bounds.centre());
  }
  return split;
}

}  // namespace etendue
