#include "accel/ray/build_binned_sah.h"

#include "accel/ray/grow_tree.h"
#include "accel/ray/simd_bounds.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <array>

namespace etendue {

namespace {

constexpr std::uint32_t max_bins = 256;
constexpr std::uint32_t parallel_size = 1 << 16;  // runs at least this long are binned in parallel
constexpr std::uint32_t parallel_grain = 1 << 13;

struct Bin {
  SimdBounds bounds;
  std::uint32_t count = 0;

  void merge(const Bin& other) {
    bounds.extend(other.bounds);
    count += other.count;
  }
};

// The sums that a cut is chosen from, over a run of items. Both merge exactly and in any order.
struct CentreBounds {
  Bounds bounds;

  void add(const BuildItem& item) { bounds.extend(item.bounds.centre()); }
  void merge(const CentreBounds& other) { bounds.extend(other.bounds); }
};

class Bins {
 public:
  Bins(const Bounds& centres, std::uint32_t count) : count_(count), lower_(centres.lower), bins_(3 * count) {
    // A little below count / extent, so that the upper end falls into the last bin. An axis whose extent is zero, or too small
    // or too large to divide by, has no cut: 0 and 0 send everything into bin 0.
    for (int axis = 0; axis < 3; ++axis) {
      scale_[axis] = static_cast<float>(count) * (1 - 1e-6f) / (centres.upper[axis] - centres.lower[axis]);
      if (!(scale_[axis] > 0 && scale_[axis] < infinity)) scale_[axis] = lower_[axis] = 0;
    }
  }

  std::uint32_t bin(const BuildItem& item, int axis) const {
    const float centre = 0.5f * item.bounds.lower[axis] + 0.5f * item.bounds.upper[axis];
    return std::min(static_cast<std::uint32_t>((centre - lower_[axis]) * scale_[axis]), count_ - 1);
  }
  std::span<const Bin> axis(int axis) const { return std::span(bins_).subspan(axis * count_, count_); }

  void add(const BuildItem& item) {
    for (int axis = 0; axis < 3; ++axis) {
      Bin& bin_of_item = bins_[axis * count_ + bin(item, axis)];
      bin_of_item.bounds.extend(item.bounds);
      ++bin_of_item.count;
    }
  }
  void merge(const Bins& other) {
    for (std::size_t i = 0; i < bins_.size(); ++i) bins_[i].merge(other.bins_[i]);
  }

 private:
  std::uint32_t count_;
  vec3 lower_, scale_;
  std::vector<Bin> bins_;  // by axis
};

template <class Sum>
Sum sum(std::span<const BuildItem> items, const Sum& zero) {
  const auto add = [&](Sum part, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) part.add(items[i]);
    return part;
  };
  if (items.size() < parallel_size) return add(zero, 0, items.size());
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, items.size(), parallel_grain), zero,
      [&](const auto& range, Sum part) { return add(std::move(part), range.begin(), range.end()); },
      [](Sum a, const Sum& b) {
        a.merge(b);
        return a;
      });
}

struct Cut {
  float cost = infinity;  // primitive tests on both sides, weighted by area
  int axis = -1;
  std::uint32_t bin = 0;  // where the right side begins
};

// The cheapest cut between two bins of an axis.
void sweep(std::span<const Bin> bins, int axis, Cut& best) {
  std::array<float, max_bins> right_cost;
  Bin right;
  for (std::size_t i = bins.size() - 1; i > 0; --i) {
    right.merge(bins[i]);
    right_cost[i] = right.bounds.half_area() * static_cast<float>(right.count);
  }
  Bin left;
  const std::uint32_t total = right.count + bins[0].count;
  for (std::size_t i = 1; i < bins.size(); ++i) {
    left.merge(bins[i - 1]);
    if (left.count == 0 || left.count == total) continue;
    const float cost = left.bounds.half_area() * static_cast<float>(left.count) + right_cost[i];
    if (cost < best.cost) best = {cost, axis, static_cast<std::uint32_t>(i)};
  }
}

class BinnedSplitter {
 public:
  BinnedSplitter(std::span<BuildItem> items, const BinnedSahParams& params)
      : items_(items), params_(params), moved_(items.size()) {}

  std::optional<Split> best(const ItemRange& range) {
    const std::span run = items_.subspan(range.begin, range.size());
    const Bins bins = sum(run, Bins(sum(run, CentreBounds()).bounds, bins_for(range.size())));
    Cut cut;
    for (int axis = 0; axis < 3; ++axis) sweep(bins.axis(axis), axis, cut);
    const float area = range.bounds.half_area(), size = static_cast<float>(range.size());
    const bool splits_cheaper = area + params_.primitive_cost * cut.cost < params_.primitive_cost * area * size;
    if (size <= static_cast<float>(params_.leaf_size) && !splits_cheaper) return std::nullopt;
    if (cut.axis < 0) return halve(range);  // coincident centres, or areas beyond the range of float
    return partition(range, bins, cut);
  }

  Split halve(const ItemRange& range) { return halve_items(items_, range); }
  std::uint32_t id(const ItemRange&, std::uint32_t position) const { return items_[position].id; }

 private:
  // A small node gains nothing from many bins, and empty bins cost as much as full ones.
  std::uint32_t bins_for(std::uint32_t size) const { return std::min(static_cast<std::uint32_t>(params_.bins), 4 + size / 8); }

  // Stable and without a branch to mispredict: each item is written to both sides, only one of which moves on.
  Split partition(const ItemRange& range, const Bins& bins, const Cut& cut) {
    std::uint32_t left = range.begin, right = range.begin;
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const BuildItem item = items_[i];
      const bool goes_left = bins.bin(item, cut.axis) < cut.bin;
      items_[left] = item;
      moved_[right] = item;
      left += goes_left;
      right += !goes_left;
    }
    std::copy(moved_.begin() + range.begin, moved_.begin() + right, items_.begin() + left);
    Bin sides[2];
    const auto bins_of_axis = bins.axis(cut.axis);
    for (std::uint32_t i = 0; i < bins_of_axis.size(); ++i) sides[i >= cut.bin].merge(bins_of_axis[i]);
    return {left, sides[0].bounds.get(), sides[1].bounds.get()};
  }

  std::span<BuildItem> items_;
  BinnedSahParams params_;
  std::vector<BuildItem> moved_;  // working space; a run of items uses its own part, so tasks never meet
};

}  // namespace

BinaryTree build_binned_sah(std::vector<BuildItem> items, const BinnedSahParams& params) {
  BinnedSplitter splitter(items, params);
  return grow_tree(splitter, items, params);
}

}  // namespace etendue
