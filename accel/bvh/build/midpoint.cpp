#include "accel/bvh/build/midpoint.h"

#include "accel/bvh/build/grow_tree.h"
#include "accel/bvh/bvh_entry.h"
#include "accel/kernels/simd_bounds.h"

#include <array>

namespace etendue {

namespace {

class MidpointSplitter {
 public:
  MidpointSplitter(std::span<BuildItem> items, const TreeLimits& limits)
      : items_(items), leaf_size_(static_cast<std::uint32_t>(limits.leaf_size)), moved_(items.size()) {}

  std::optional<Split> best(const ItemRange& range) {
    if (range.size() <= leaf_size_) return std::nullopt;
    // Half the edges, whose lengths are finite where the edges' own are not.
    const vec3 edges = 0.5f * range.bounds.upper - 0.5f * range.bounds.lower, middle = range.bounds.centre();
    std::array<int, 3> axes{0, 1, 2};
    std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return edges[a] > edges[b]; });
    for (const int axis : axes)
      if (const auto split = partition(range, axis, middle[axis])) return split;
    return halve(range);
  }
  Split halve(const ItemRange& range) { return halve_items(items_, range); }
  std::uint32_t id(const ItemRange&, std::uint32_t position) const { return items_[position].id; }

 private:
  // A stable partition, or none when a side stays empty. It has no branch to mispredict: each item is written to both sides,
  // only one of which moves on.
  std::optional<Split> partition(const ItemRange& range, int axis, float middle) {
    std::uint32_t left = range.begin, right = range.begin;
    SimdBounds sides[2];
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const BuildItem item = items_[i];
      const bool goes_left = 0.5f * item.bounds.lower[axis] + 0.5f * item.bounds.upper[axis] < middle;
      sides[!goes_left].extend(item.bounds);
      items_[left] = item;
      moved_[right] = item;
      left += goes_left;
      right += !goes_left;
    }
    std::copy(moved_.begin() + range.begin, moved_.begin() + right, items_.begin() + left);
    if (left == range.begin || left == range.end) return std::nullopt;
    return Split{left, sides[0].get(), sides[1].get()};
  }

  std::span<BuildItem> items_;
  std::uint32_t leaf_size_;
  BuildItems moved_;  // working space; a run of items uses its own part, so tasks never meet
};

}  // namespace

BinaryTree build_midpoint(BuildItems items, const TreeLimits& limits) {
  MidpointSplitter splitter(items, limits);
  return grow_tree(splitter, items, limits);
}

RayEntry midpoint_entry() {
  return bvh_entry<TreeLimits, build_midpoint>("midpoint", "bounding volume hierarchy, cut at the middle of the longest edge",
                                               64);
}

}  // namespace etendue
