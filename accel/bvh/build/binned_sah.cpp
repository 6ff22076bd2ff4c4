#include "accel/bvh/build/binned_sah.h"

#include "accel/bvh/build/grow_tree.h"
#include "accel/bvh/build/small_sweep.h"
#include "accel/bvh/bvh_entry.h"
#include "accel/kernels/simd_bounds.h"
#include "framework/core/huge_pages.h"
#include "framework/core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <array>

namespace etendue {

namespace {

constexpr std::uint32_t parallel_size = 1 << 15;  // runs at least this long may be binned and parted in parallel
constexpr std::uint32_t parallel_grain = 1 << 11;

struct Bin {
  SimdBounds bounds;
  std::uint32_t count;
  char unused[60 - sizeof(SimdBounds)];  // a stride that is a power of two

  Bin() : bounds(Uninitialised()) {}  // initialising all bins would take longer than the sweep of a small node
  static Bin empty() {
    Bin bin;
    bin.bounds = {};
    bin.count = 0;
    return bin;
  }

  void merge(const Bin& other) {
    bounds.extend(other.bounds);
    count += other.count;
  }
};

// The equal intervals of the centres' extent, per axis.
class Grid {
 public:
  Grid(const Bounds& centres, std::uint32_t count) {
    // A little below count / extent, so that the upper end falls into the last bin. An axis whose extent is zero, or too small
    // or too large to divide by, has no cut: 0 and 0 send everything into bin 0.
    for (int axis = 0; axis < 3; ++axis) {
      lower_[axis] = centres.lower[axis];
      scale_[axis] = static_cast<float>(count) * (1 - 1e-6f) / (centres.upper[axis] - centres.lower[axis]);
      if (!(scale_[axis] > 0 && scale_[axis] < infinity)) scale_[axis] = lower_[axis] = 0;
    }
    last_ = FourInts{} + static_cast<std::int32_t>(count - 1);
  }

  // The bins of a centre, by axis.
  FourInts operator()(FourFloats centre) const {
    const FourInts bins = __builtin_convertvector((centre - lower_) * scale_, FourInts);
    return bins < last_ ? bins : last_;
  }

  // The same along one axis.
  class Axis {
   public:
    Axis(const Grid& grid, int axis)
        : axis_(axis), lower_(grid.lower_[axis]), scale_(grid.scale_[axis]), last_(grid.last_[0]) {}
    std::int32_t operator()(const Bounds& b) const {
      const float centre = 0.5f * component(b.lower, axis_) + 0.5f * component(b.upper, axis_);
      return std::min(static_cast<std::int32_t>((centre - lower_) * scale_), last_);
    }

   private:
    int axis_;
    float lower_, scale_;
    std::int32_t last_;
  };

 private:
  FourFloats lower_{}, scale_{};
  FourInts last_;
};

// Counts and boxes of the items in each bin of each axis. Two merge exactly and in any order.
template <std::uint32_t capacity>
class Bins {
 public:
  Bins(const Grid& grid, std::uint32_t count) : grid_(grid), count_(count) {
    if constexpr (capacity > max_on_stack) bins_.resize(3 * capacity);
    for (std::uint32_t axis = 0; axis < 3; ++axis) std::fill_n(&bins_[axis * capacity], count, Bin::empty());
  }

  // Two sets of bins by turns, where there are items enough: neighbours often fall into one bin, and each would wait for what
  // the one before stores there.
  void add(const BuildItem* begin, const BuildItem* end) {
    const Grid grid = grid_;  // a copy that no store into the bins can reach
    if (end - begin >= by_turns_from) {
      Bins second(grid, count_);
      for (; end - begin >= 2; begin += 2) {
        add(begin[0], grid);
        second.add(begin[1], grid);
      }
      merge(second);
    }
    for (; begin != end; ++begin) add(*begin, grid);
  }
  void merge(const Bins& other) {
    for (std::uint32_t axis = 0; axis < 3; ++axis)
      for (std::uint32_t i = axis * capacity; i < axis * capacity + count_; ++i) bins_[i].merge(other.bins_[i]);
  }

  struct Cut {
    float cost = infinity;  // primitive tests on both sides, weighted by area
    int axis = -1;
    std::uint32_t bin = 0;   // where the right side begins
    std::uint32_t left = 0;  // how many items go left
  };

  Cut best() const {
    Cut best;
    for (int axis = 0; axis < 3; ++axis) sweep(axis, best);
    return best;
  }
  Bounds bounds(int axis, std::uint32_t begin, std::uint32_t end) const {
    SimdBounds sum;
    for (std::uint32_t i = begin; i < end; ++i) sum.extend(bins_[axis * capacity + i].bounds);
    return sum.get();
  }
  std::uint32_t size() const { return count_; }
  const Grid& grid() const { return grid_; }

 private:
  [[gnu::always_inline]] void add(const BuildItem& item, const Grid& grid) {
    const SimdBounds bounds(item.bounds);
    const FourInts bins = grid(bounds.centre());
    for (int axis = 0; axis < 3; ++axis) {
      Bin& bin = bins_[axis * capacity + static_cast<std::uint32_t>(bins[axis])];
      bin.bounds.extend(bounds);
      ++bin.count;
    }
  }

  // The cheapest cut between two bins of an axis.
  void sweep(int axis, Cut& best) const {
    std::array<float, capacity> right_cost;
    const Bin* const bins = bins_.data() + axis * capacity;
    Bin left = Bin::empty(), right = left;
    for (std::uint32_t i = count_ - 1; i > 0; --i) {
      right.merge(bins[i]);
      right_cost[i] = right.bounds.half_area() * static_cast<float>(right.count);
    }
    const std::uint32_t total = right.count + bins[0].count;
    for (std::uint32_t i = 1; i < count_; ++i) {
      left.merge(bins[i - 1]);
      const float cost = left.bounds.half_area() * static_cast<float>(left.count) + right_cost[i];
      if (cost < best.cost && left.count != 0 && left.count != total) best = {cost, axis, i, left.count};
    }
  }

  static constexpr std::uint32_t max_on_stack = 64;
  static constexpr std::ptrdiff_t by_turns_from = capacity <= max_on_stack ? 32 : 4096;

  Grid grid_;
  std::uint32_t count_;
  std::conditional_t<(capacity > max_on_stack), std::vector<Bin>, std::array<Bin, 3 * capacity>> bins_;  // by axis
};

// Boxes of centres on both sides of a cut, without a branch: an item is made a NaN, which no minimum takes, for the other side.
class SideCentres {
 public:
  void add(FourFloats centre, bool goes_left) {
    const FourInts all_if_left = FourInts{} - static_cast<std::int32_t>(goes_left);
    add(lower_[0], upper_[0], centre, ~all_if_left);
    add(lower_[1], upper_[1], centre, all_if_left);
  }
  void merge(const SideCentres& other) {
    for (int side = 0; side < 2; ++side) {
      lower_[side] = other.lower_[side] < lower_[side] ? other.lower_[side] : lower_[side];
      upper_[side] = other.upper_[side] > upper_[side] ? other.upper_[side] : upper_[side];
    }
  }
  Bounds get(int side) const {
    const FourFloats l = lower_[side], u = upper_[side];
    return {{l[0], l[1], l[2]}, {u[0], u[1], u[2]}};
  }

 private:
  static void add(FourFloats& lower, FourFloats& upper, FourFloats centre, FourInts nan) {
    const auto value = reinterpret_cast<FourFloats>(reinterpret_cast<FourInts>(centre) | nan);
    lower = value < lower ? value : lower;
    upper = value > upper ? value : upper;
  }

  FourFloats lower_[2] = {FourFloats{} + infinity, FourFloats{} + infinity};
  FourFloats upper_[2] = {FourFloats{} - infinity, FourFloats{} - infinity};
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
    NodeBins bins(Grid(range.centres, bin_count), bin_count);
    fill(bins, range);
    const typename NodeBins::Cut cut = bins.best();
    if (range.size() <= static_cast<std::uint32_t>(params_.leaf_size) && !is_worth(cut.cost, range)) return std::nullopt;
    if (cut.axis < 0) return halve(range);  // coincident centres, or areas beyond the range of float
    Split split{range.begin + cut.left, bins.bounds(cut.axis, 0, cut.bin), bins.bounds(cut.axis, cut.bin, bins.size())};
    part(range, bins.grid(), cut.axis, cut.bin, split);
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
    if (!is_shared(range)) return bins.add(items + range.begin, items + range.end);
    const NodeBins empty = bins;
    alone([&] {
      bins = tbb::parallel_reduce(
          tbb::blocked_range<std::uint32_t>(range.begin, range.end, parallel_grain), empty,
          [&](const auto& part, NodeBins sum) {
            sum.add(items + part.begin(), items + part.end());
            return sum;
          },
          [](NodeBins a, const NodeBins& b) {
            a.merge(b);
            return a;
          });
    });
  }

  // Items of bins below `bin` go left. Stable, by chunks of which the places on both sides are known in large runs.
  void part(const ItemRange& range, const Grid& grid, int axis, std::int32_t bin, Split& split) const {
    const auto goes_left = [bin, place = Grid::Axis(grid, axis)](const BuildItem& item) { return place(item.bounds) < bin; };
    const BuildItem* const items = from(range);
    const std::uint32_t chunk_size = is_shared(range) ? parallel_grain : range.size(),
                        chunk_count = (range.size() + chunk_size - 1) / chunk_size;
    const auto end_of = [&](std::size_t chunk) {
      return std::min(range.end, range.begin + (static_cast<std::uint32_t>(chunk) + 1) * chunk_size);
    };
    if (chunk_count == 1) {
      const SideCentres centres = part(range, range.begin, range.end, range.begin, split.middle, goes_left);
      split.left_centres = centres.get(0);
      split.right_centres = centres.get(1);
      return;
    }
    std::vector<std::uint32_t> left(chunk_count);  // items of the chunk that go left; then where they go
    const auto each_chunk = [&](const auto& body) { alone([&] { parallel_for(chunk_count, 1, body); }); };
    each_chunk([&](std::size_t chunk) {
      const std::uint32_t begin = range.begin + static_cast<std::uint32_t>(chunk) * chunk_size;
      left[chunk] = static_cast<std::uint32_t>(std::count_if(items + begin, items + end_of(chunk), goes_left));
    });
    std::uint32_t place = range.begin;
    for (std::uint32_t& l : left) place += std::exchange(l, place);
    std::vector<SideCentres> centres(chunk_count);
    each_chunk([&](std::size_t chunk) {
      const std::uint32_t begin = range.begin + static_cast<std::uint32_t>(chunk) * chunk_size;
      centres[chunk] = part(range, begin, end_of(chunk), left[chunk], split.middle + begin - left[chunk], goes_left);
    });
    for (std::uint32_t chunk = 1; chunk < chunk_count; ++chunk) centres[0].merge(centres[chunk]);
    split.left_centres = centres[0].get(0);
    split.right_centres = centres[0].get(1);
  }

  // Moves the items in [begin, end) to `left` and `right` in the other array.
  template <class GoesLeft>
  SideCentres part(const ItemRange& range, std::uint32_t begin, std::uint32_t end, std::uint32_t left, std::uint32_t right,
                   const GoesLeft& goes_left) const {
    const BuildItem* const items = from(range);
    BuildItem* const moved = to(range);
    SideCentres centres;
    for (std::uint32_t i = begin; i < end; ++i) {
      const bool is_left = goes_left(items[i]);
      moved[is_left ? left : right] = items[i];
      left += is_left;
      right += !is_left;
      centres.add(SimdBounds(items[i].bounds).centre(), is_left);
    }
    return centres;
  }

  BinnedSahParams params_;
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
