// The loops of binned_kernels.h for one instruction set; included like wide_tests.inl.
#pragma once

#include "accel/bvh/build/binned_kernels.h"

namespace etendue {
namespace {

// An item's box, held as a bin holds its own.
struct ItemBox {
  FourFloats lower, minus_upper;

  [[gnu::always_inline]] explicit ItemBox(const BuildItem& item) {
    std::memcpy(&lower, &item.bounds.lower.x, sizeof lower);
    std::memcpy(&minus_upper, &item.bounds.lower.z, sizeof minus_upper);
    minus_upper = -minus_upper;
  }
  // It is Bounds::centre.
  [[gnu::always_inline]] FourFloats centre() const {
    return 0.5f * lower - 0.5f * __builtin_shufflevector(minus_upper, minus_upper, 1, 2, 3, 3);
  }
  [[gnu::always_inline]] void extend(Bin& bin) const {
#if defined(__AVX2__)
    using EightFloats = Vector<float, 8>;
    const EightFloats own = __builtin_shufflevector(lower, minus_upper, 0, 1, 2, 3, 4, 5, 6, 7);
    EightFloats box;
    std::memcpy(&box, &bin.lower, sizeof box);
    box = own < box ? own : box;
    std::memcpy(&bin.lower, &box, sizeof box);
#else
    bin.lower = lower < bin.lower ? lower : bin.lower;
    bin.minus_upper = minus_upper < bin.minus_upper ? minus_upper : bin.minus_upper;
#endif
    ++bin.count;
  }
};

// Takes a few items at a time, and finds the places of their bins before it writes any. So a processor that runs ahead soon knows
// where each store goes, and which loads must wait for one.
inline void add_items(const BinGrid& shared_grid, Bin* bins, std::size_t stride, const BuildItem* begin, const BuildItem* end) {
  const BinGrid grid = shared_grid;  // a copy that no store into the bins can reach
  static_assert(sizeof(Bin) == 64);
  constexpr std::ptrdiff_t few = 16;
  alignas(16) std::uint32_t offsets[few][4];  // in bytes, by axis
  while (begin != end) {
    const std::ptrdiff_t count = end - begin < few ? end - begin : few;
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const FourInts of_item = grid(ItemBox(begin[i]).centre()) << 6;
      std::memcpy(offsets[i], &of_item, sizeof of_item);
    }
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const ItemBox box(begin[i]);
      char* of_axis = reinterpret_cast<char*>(bins);
      for (int axis = 0; axis < 3; ++axis, of_axis += stride * sizeof(Bin))
        box.extend(*reinterpret_cast<Bin*>(of_axis + offsets[i][axis]));
    }
    begin += count;
  }
}

class GoesLeft {
 public:
  [[gnu::always_inline]] explicit GoesLeft(const BinCut& cut)
      : grid_(cut.grid), axis_(cut.axis), bin_(FourInts{} + static_cast<std::int32_t>(cut.bin)) {}
  // All bits of all lanes, or none.
  [[gnu::always_inline]] FourInts operator()(FourFloats centre) const { return axis_(grid_(centre)) < bin_; }

 private:
  BinGrid grid_;
  LaneCopies axis_;
  FourInts bin_;
};

// Without a branch: for the box of the other side, a centre is made a NaN, which no minimum takes.
inline SideCentres part_items(const BinCut& cut, const BuildItem* begin, const BuildItem* end, BuildItem* left,
                              BuildItem* right) {
  const GoesLeft goes_left(cut);
  SideCentres centres;
  const auto add = [&](int side, FourFloats centre, FourInts nan) {
    const auto value = reinterpret_cast<FourFloats>(reinterpret_cast<FourInts>(centre) | nan);
    centres.lower[side] = value < centres.lower[side] ? value : centres.lower[side];
    centres.upper[side] = value > centres.upper[side] ? value : centres.upper[side];
  };
  for (; begin != end; ++begin) {
    const FourFloats centre = ItemBox(*begin).centre();
    const FourInts all_if_left = goes_left(centre);
    const bool is_left = all_if_left[0] != 0;
    std::memcpy(is_left ? left : right, begin, sizeof(BuildItem));
    left += is_left;
    right += !is_left;
    add(0, centre, ~all_if_left);
    add(1, centre, all_if_left);
  }
  return centres;
}

inline std::uint32_t count_left(const BinCut& cut, const BuildItem* begin, const BuildItem* end) {
  const GoesLeft goes_left(cut);
  std::uint32_t count = 0;
  for (; begin != end; ++begin) count += goes_left(ItemBox(*begin).centre())[0] != 0;
  return count;
}

constexpr BinnedKernels binned_kernels_here{add_items, part_items, count_left};

}  // namespace
}  // namespace etendue
