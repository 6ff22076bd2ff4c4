#include "accel/ray/grow_tree.h"

#include "accel/ray/simd_bounds.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace etendue {

std::vector<TreeNode> without_gaps(const TreeNode* places, std::uint32_t used) {
  std::vector<TreeNode> nodes;
  nodes.reserve(used);
  nodes.push_back(places[0]);
  std::vector<std::uint32_t> parents{0};  // in `nodes`, their children still in `places`
  if (places[0].is_leaf()) parents.clear();
  while (!parents.empty()) {
    TreeNode& parent = nodes[parents.back()];
    parents.pop_back();
    const auto first = static_cast<std::uint32_t>(nodes.size());
    const std::uint32_t place = std::exchange(parent.first, first);
    for (std::uint32_t i = 0; i < 2; ++i) nodes.push_back(places[place + i]);
    for (std::uint32_t i = 2; i-- > 0;)
      if (!nodes[first + i].is_leaf()) parents.push_back(first + i);
  }
  return nodes;
}

std::pair<Bounds, Bounds> extents(std::span<const BuildItem> items) {
  using Extents = std::pair<Bounds, Bounds>;
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, items.size(), 1 << 13), Extents(),
      [&](const auto& range, Extents sum) {
        SimdBounds bounds(sum.first), centres(sum.second);
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
          const vec3 centre = items[i].bounds.centre();
          bounds.extend(items[i].bounds);
          centres.extend(Bounds{centre, centre});
        }
        return Extents(bounds.get(), centres.get());
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
