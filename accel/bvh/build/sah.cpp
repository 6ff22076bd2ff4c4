#include "accel/bvh/build/sah.h"

#include "accel/bvh/build/grow_tree.h"
#include "accel/bvh/bvh_entry.h"
#include "accel/kernels/simd_bounds.h"

#include <array>

namespace etendue {

namespace {

// Bits that sort as unsigned numbers the way the floats do.
std::uint32_t sortable_bits(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

class SweepSplitter {
 public:
  SweepSplitter(std::span<const BuildItem> items, const SahParams& params)
      : items_(items),
        leaf_size_(static_cast<std::uint32_t>(params.leaf_size)),
        primitive_cost_(params.primitive_cost),
        right_area_(items.size()),
        goes_left_(items.size()),
        moved_(items.size()) {
    std::vector<std::uint64_t> keys(items.size());
    for (int axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < items.size(); ++i)
        keys[i] = std::uint64_t{sortable_bits(items[i].bounds.centre()[axis])} << 32 | i;
      std::sort(keys.begin(), keys.end());
      order_[axis].resize(items.size());
      std::transform(keys.begin(), keys.end(), order_[axis].begin(),
                     [](std::uint64_t k) { return static_cast<std::uint32_t>(k); });
    }
  }

  std::optional<Split> best(const ItemRange& range) {
    Candidate best;
    for (int axis = 0; axis < 3; ++axis) sweep(axis, range, best);
    const float area = range.bounds.half_area(), size = static_cast<float>(range.size());
    const bool splits_cheaper = area + primitive_cost_ * best.cost < primitive_cost_ * area * size;
    if (range.size() <= leaf_size_ && !splits_cheaper) return std::nullopt;
    if (best.axis < 0) return halve(range);  // no finite cost: areas beyond the range of float
    return partition(best.axis, best.middle, range);
  }

  Split halve(const ItemRange& range) {
    Bounds centres;
    for (std::uint32_t i = range.begin; i < range.end; ++i) centres.extend(items_[order_[0][i]].bounds.centre());
    return partition(centres.longest_axis(), range.begin + range.size() / 2, range);
  }

  std::uint32_t id(const ItemRange&, std::uint32_t position) const { return items_[order_[0][position]].id; }

 private:
  struct Candidate {
    float cost = infinity;  // primitive tests on both sides, weighted by area
    int axis = -1;
    std::uint32_t middle = 0, from_centre = 0;
  };

  // Areas of all right sides from the right, then costs from the left.
  void sweep(int axis, const ItemRange& range, Candidate& best) {
    const auto& order = order_[axis];
    SimdBounds right;
    for (std::uint32_t i = range.end - 1; i > range.begin; --i) {
      right.extend(items_[order[i]].bounds);
      right_area_[i] = right.half_area();
    }
    const std::uint32_t centre = range.begin + range.size() / 2;
    SimdBounds left;
    for (std::uint32_t i = range.begin + 1; i < range.end; ++i) {
      left.extend(items_[order[i - 1]].bounds);
      const float cost =
          left.half_area() * static_cast<float>(i - range.begin) + right_area_[i] * static_cast<float>(range.end - i);
      const std::uint32_t from_centre = i < centre ? centre - i : i - centre;
      if (cost < best.cost || (cost == best.cost && cost < infinity && from_centre < best.from_centre))
        best = {cost, axis, i, from_centre};
    }
  }

  // Cuts the order of one axis at `middle` and the two others alike, each side keeping its order.
  Split partition(int axis, std::uint32_t middle, const ItemRange& range) {
    SimdBounds sides[2];
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const std::uint32_t item = order_[axis][i];
      goes_left_[item] = i < middle;
      sides[i >= middle].extend(items_[item].bounds);
    }
    for (int other = 0; other < 3; ++other) {
      if (other == axis) continue;
      auto& order = order_[other];
      std::uint32_t left = range.begin, right = middle;
      for (std::uint32_t i = range.begin; i < range.end; ++i) {
        const bool goes_left = goes_left_[order[i]];
        moved_[goes_left ? left : right] = order[i];
        left += goes_left;
        right += !goes_left;
      }
      std::copy(moved_.begin() + range.begin, moved_.begin() + range.end, order.begin() + range.begin);
    }
    return {middle, sides[0].get(), sides[1].get()};
  }

  std::span<const BuildItem> items_;
  std::uint32_t leaf_size_;
  float primitive_cost_;
  std::array<std::vector<std::uint32_t>, 3> order_;  // items by centre, per axis
  // Working space; a run of items uses its own part, so tasks never meet.
  std::vector<float> right_area_;
  std::vector<std::uint8_t> goes_left_;
  std::vector<std::uint32_t> moved_;
};

}  // namespace

BinaryTree build_sah(BuildItems items, const SahParams& params) {
  SweepSplitter splitter(items, params);
  return grow_tree(splitter, items, params);
}

RayEntry sah_entry() {
  return bvh_entry<SahParams, build_sah>("sah", "bounding volume hierarchy by surface area, every cut tried", 44);
}

}  // namespace etendue
