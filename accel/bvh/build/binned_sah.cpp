#include "accel/bvh/build/binned_sah.h"

#include "accel/bvh/build/binned_kernels.h"
#include "accel/bvh/build/grow_tree.h"
#include "accel/bvh/build/small_sweep.h"
#include "accel/bvh/bvh_entry.h"
#include "framework/core/huge_pages.h"
#include "framework/core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <array>
#include <bit>

namespace etendue {

namespace {

constexpr std::uint32_t parallel_size = 1 << 15;  // runs at least this long may be binned and parted in parallel
constexpr std::uint32_t parallel_grain = 1 << 11;

BinGrid grid_over(const Bounds& centres, std::uint32_t count) {
  BinGrid grid{{}, {}, FourInts{} + static_cast<std::int32_t>(count - 1)};
  // A little below count / extent, so that the upper end falls into the last bin. An axis whose extent is zero, or too small
  // or too large to divide by, has no cut: 0 and 0 send everything into bin 0.
  for (int axis = 0; axis < 3; ++axis) {
    grid.lower[axis] = centres.lower[axis];
    grid.scale[axis] = static_cast<float>(count) * (1 - 1e-6f) / (centres.upper[axis] - centres.lower[axis]);
    if (!(grid.scale[axis] > 0 && grid.scale[axis] < infinity)) grid.scale[axis] = grid.lower[axis] = 0;
  }
  return grid;
}

// Counts and boxes of the items in each bin of each axis. Two merge exactly and in any order.
template <std::uint32_t capacity>
class Bins {
 public:
  Bins(const BinGrid& grid, std::uint32_t count) : grid_(grid), count_(count) {
    if constexpr (capacity > max_on_stack) bins_.resize(3 * capacity);
    for (std::uint32_t axis = 0; axis < 3; ++axis) std::fill_n(&bins_[axis * capacity], size(axis), Bin::empty());
  }

  void add(const BinnedKernels& kernels, const BuildItem* begin, const BuildItem* end) {
    kernels.add(grid_, bins_.data(), capacity, begin, end);
  }
  void merge(const Bins& other) {
    for (std::uint32_t axis = 0; axis < 3; ++axis)
      for (std::uint32_t i = axis * capacity; i < axis * capacity + size(axis); ++i) bins_[i].merge(other.bins_[i]);
  }

  struct Cut {
    float cost = infinity;  // primitive tests on both sides, weighted by area
    int axis = -1;
    std::uint32_t bin = 0;   // where the right side begins
    std::uint32_t left = 0;  // how many items go left
  };

  Cut best() const {
    std::uint64_t best = ~std::uint64_t{0};
    for (std::uint32_t axis = 0; axis < 3; ++axis) best = sweep(axis, best);
    Cut cut;
    const float cost = std::bit_cast<float>(static_cast<std::uint32_t>(best >> 32));
    if (!(cost < infinity)) return cut;
    cut = {cost, static_cast<int>(best >> 16 & 3), static_cast<std::uint32_t>(best & 0xffff), 0};
    for (std::uint32_t i = 0; i < cut.bin; ++i) cut.left += bins_[static_cast<std::uint32_t>(cut.axis) * capacity + i].count;
    return cut;
  }
  Bounds bounds(int axis, std::uint32_t begin, std::uint32_t end) const {
    Bin sum = Bin::empty();
    for (std::uint32_t i = begin; i < end; ++i) sum.merge(bins_[axis * capacity + i]);
    return sum.bounds();
  }
  // An axis without a cut has one bin, as often in flat parts of a scene.
  std::uint32_t size(std::uint32_t axis) const { return grid_.scale[axis] > 0 ? count_ : 1; }
  const BinGrid& grid() const { return grid_; }

 private:
  // The least key of a cut between two bins of an axis, or `best` where that is less: its cost, whose bits sort as it does with
  // what is not finite last, then its axis and bin. Which is least cannot be predicted, so no branch depends on it.
  std::uint64_t sweep(std::uint32_t axis, std::uint64_t best) const {
    std::array<float, capacity> right_cost;
    const Bin* const bins = bins_.data() + axis * capacity;
    Bin left = Bin::empty(), right = left;
    for (std::uint32_t i = size(axis) - 1; i > 0; --i) {
      right.merge(bins[i]);
      right_cost[i] = right.half_area() * static_cast<float>(static_cast<std::int32_t>(right.count));
    }
    const std::uint32_t total = right.count + bins[0].count;
    for (std::uint32_t i = 1; i < size(axis); ++i) {
      left.merge(bins[i - 1]);
      const float cost = left.half_area() * static_cast<float>(static_cast<std::int32_t>(left.count)) + right_cost[i];
      const std::uint64_t key = std::uint64_t{std::bit_cast<std::uint32_t>(cost)} << 32 | axis << 16 | i;
      best = std::min(best, (left.count != 0) & (left.count != total) ? key : ~std::uint64_t{0});
    }
    return best;
  }

  static constexpr std::uint32_t max_on_stack = 64;

  BinGrid grid_;
  std::uint32_t count_;
  std::conditional_t<(capacity > max_on_stack), std::vector<Bin>, std::array<Bin, 3 * capacity>> bins_;  // by axis
};

template <std::uint32_t capacity>
class BinnedSplitter {
 public:
  BinnedSplitter(BuildItems& items, const BinnedSahParams& params)
      : params_(params), moved_(uninitialised_on_huge_pages<BuildItem>(items.size())), count_(items.size()) {
    items_ = {items.data(), moved_.get()};
  }

  std::optional<Split> best(const ItemRange& range) {
    if (range.size() <= small_sweep_size) return best_of_few(range);
    const std::uint32_t bin_count = bins_for(range.size());
    NodeBins bins(grid_over(range.centres, bin_count), bin_count);
    fill(bins, range);
    const typename NodeBins::Cut cut = bins.best();
    if (range.size() <= static_cast<std::uint32_t>(params_.leaf_size) && !is_worth(cut.cost, range)) return std::nullopt;
    if (cut.axis < 0) return halve(range);  // coincident centres, or areas beyond the range of float
    Split split{range.begin + cut.left, bins.bounds(cut.axis, 0, cut.bin),
                bins.bounds(cut.axis, cut.bin, bins.size(static_cast<std::uint32_t>(cut.axis)))};
    part(range, {bins.grid(), cut.axis, cut.bin}, split);
    return split;
  }

  Split halve(const ItemRange& range) {
    const Split split = halve_items(std::span(from(range), count_), range);
    std::copy(from(range) + range.begin, from(range) + range.end, to(range) + range.begin);
    return split;
  }

  std::uint32_t id(const ItemRange& range, std::uint32_t position) { return from(range)[position].id; }

 private:
  using NodeBins = Bins<capacity>;

  // A small node gains nothing from many bins, and empty bins cost as much as full ones.
  std::uint32_t bins_for(std::uint32_t size) const { return std::min(static_cast<std::uint32_t>(params_.bins), 4 + size / 8); }

  // Items change sides between two arrays at each level, so that none is moved twice.
  BuildItem* from(const ItemRange& range) const { return items_[range.depth & 1]; }
  BuildItem* to(const ItemRange& range) const { return items_[~range.depth & 1]; }

  bool is_worth(float cut_cost, const ItemRange& range) const {
    const float area = range.bounds.half_area(), cost = params_.primitive_cost;
    return area + cost * cut_cost < cost * area * static_cast<float>(range.size());
  }

  std::optional<Split> best_of_few(const ItemRange& range) {
    const BuildItem* const items = from(range) + range.begin;
    const SmallCut cut = sweep_small(items, range.size());
    if (range.size() <= static_cast<std::uint32_t>(params_.leaf_size) && !is_worth(cut.cost, range)) return std::nullopt;
    if (!(cut.cost < infinity)) return halve(range);
    SimdBounds left, right;
    BuildItem* const moved = to(range) + range.begin;
    for (std::uint32_t i = 0; i < cut.left; ++i) left.extend((moved[i] = items[cut.order[i]]).bounds);
    for (std::uint32_t i = cut.left; i < range.size(); ++i) right.extend((moved[i] = items[cut.order[i]]).bounds);
    return Split{range.begin + cut.left, left.get(), right.get()};
  }

  // A thread that waits for the parts of a run takes no other subtree meanwhile, or its stack could grow with each.
  template <class Body>
  static void alone(const Body& body) {
    tbb::this_task_arena::isolate(body);
  }

  // Does all of the machine work on a run? Only while there are fewer runs than threads: then each thread has one of its own.
  bool is_shared(const ItemRange& range) const {
    return range.size() >= parallel_size && range.size() * threads_ > count_ + count_ / 2;
  }

  void fill(NodeBins& bins, const ItemRange& range) const {
    const BuildItem* const items = from(range);
    if (!is_shared(range)) return bins.add(kernels_, items + range.begin, items + range.end);
    const NodeBins empty = bins;
    alone([&] {
      bins = tbb::parallel_reduce(
          tbb::blocked_range<std::uint32_t>(range.begin, range.end, parallel_grain), empty,
          [&](const auto& part, const NodeBins& before) {
            NodeBins sum = before;
            sum.add(kernels_, items + part.begin(), items + part.end());
            return sum;
          },
          [](const NodeBins& a, const NodeBins& b) {
            NodeBins sum = a;
            sum.merge(b);
            return sum;
          });
    });
  }

  // Stable, by chunks of which the places on both sides are known in large runs.
  void part(const ItemRange& range, const BinCut& cut, Split& split) const {
    const BuildItem* const items = from(range);
    BuildItem* const moved = to(range);
    const std::uint32_t chunk_size = is_shared(range) ? parallel_grain : range.size(),
                        chunk_count = (range.size() + chunk_size - 1) / chunk_size;
    if (chunk_count == 1) {
      const SideCentres centres =
          kernels_.part(cut, items + range.begin, items + range.end, moved + range.begin, moved + split.middle);
      split.left_centres = centres.get(0);
      split.right_centres = centres.get(1);
      return;
    }
    const auto begin_of = [&](std::size_t chunk) { return range.begin + static_cast<std::uint32_t>(chunk) * chunk_size; };
    const auto end_of = [&](std::size_t chunk) { return std::min(range.end, begin_of(chunk) + chunk_size); };
    std::vector<std::uint32_t> left(chunk_count);  // items of the chunk that go left; then where they go
    const auto each_chunk = [&](const auto& body) { alone([&] { parallel_for(chunk_count, 1, body); }); };
    each_chunk(
        [&](std::size_t chunk) { left[chunk] = kernels_.count_left(cut, items + begin_of(chunk), items + end_of(chunk)); });
    std::uint32_t place = range.begin;
    for (std::uint32_t& l : left) place += std::exchange(l, place);
    std::vector<SideCentres> centres(chunk_count);
    each_chunk([&](std::size_t chunk) {
      centres[chunk] = kernels_.part(cut, items + begin_of(chunk), items + end_of(chunk), moved + left[chunk],
                                     moved + split.middle + begin_of(chunk) - left[chunk]);
    });
    for (std::uint32_t chunk = 1; chunk < chunk_count; ++chunk) centres[0].merge(centres[chunk]);
    split.left_centres = centres[0].get(0);
    split.right_centres = centres[0].get(1);
  }

  BinnedSahParams params_;
  const BinnedKernels& kernels_ = binned_kernels(chosen_isa());
  UninitialisedArray<BuildItem> moved_;
  std::array<BuildItem*, 2> items_;  // by the depth's last bit
  std::size_t count_;
  std::size_t threads_ = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
};

template <std::uint32_t capacity>
BinaryTree build(BuildItems& items, const BinnedSahParams& params) {
  BinnedSplitter<capacity> splitter(items, params);
  return grow_tree(splitter, items, params);
}

}  // namespace

BinaryTree build_binned_sah(BuildItems items, const BinnedSahParams& params) {
  if (params.bins <= 16) return build<16>(items, params);
  if (params.bins <= 64) return build<64>(items, params);
  return build<256>(items, params);
}

RayEntry binned_sah_entry() {
  return bvh_entry<BinnedSahParams, build_binned_sah>("binned-sah",
                                                      "bounding volume hierarchy by surface area, cuts between bins", 64);
}

}  // namespace etendue
