// The loops of binned_sah.cpp over the items of each level of a tree: one puts items into bins, one moves them to their sides
// of a cut. Both are compiled for SSE4.1 and for AVX2 (binned_kernels.inl, wide_isa.h), and give the same bits.
#pragma once

#include "accel/bvh/build/binary_tree.h"
#include "accel/kernels/simd_bounds.h"
#include "framework/core/isa.h"

namespace etendue {

// Items whose centres lie in one interval of an axis: how many, and the box around them. Upper bounds are negated, so that the
// least values of both vectors unite two boxes; lanes as in SimdBounds.
struct alignas(64) Bin {
  FourFloats lower, minus_upper;
  std::uint32_t count;

  Bin() {}  // initialising all bins would take longer than the sweep of a small node
  static Bin empty() {
    Bin bin;
    bin.lower = bin.minus_upper = FourFloats{} + infinity;
    bin.count = 0;
    return bin;
  }
  void merge(const Bin& other) {
    lower = smaller(other.lower, lower);
    minus_upper = smaller(other.minus_upper, minus_upper);
    count += other.count;
  }
  // It is Bounds::half_area, where there are items.
  float half_area() const {
    const FourFloats minus_extent = __builtin_shufflevector(minus_upper, minus_upper, 1, 2, 3, 0) + lower,
                     products = minus_extent * yzx(minus_extent);
    return products[0] + products[1] + products[2];
  }
  Bounds bounds() const { return {{lower[0], lower[1], lower[2]}, {-minus_upper[1], -minus_upper[2], -minus_upper[3]}}; }
};

// The equal intervals of the centres' extent, per axis.
struct BinGrid {
  FourFloats lower, scale;
  FourInts last;

  // The bins of a centre, by axis.
  [[gnu::always_inline]] FourInts operator()(FourFloats centre) const {
    const FourInts bins = __builtin_convertvector((centre - lower) * scale, FourInts);
    return bins < last ? bins : last;
  }
};

// Items of bins below `bin` along an axis go left.
struct BinCut {
  BinGrid grid;
  int axis;
  std::uint32_t bin;
};

// Boxes of centres on both sides of a cut.
struct SideCentres {
  FourFloats lower[2] = {FourFloats{} + infinity, FourFloats{} + infinity};
  FourFloats upper[2] = {FourFloats{} - infinity, FourFloats{} - infinity};

  void merge(const SideCentres& other) {
    for (int side = 0; side < 2; ++side) {
      lower[side] = smaller(other.lower[side], lower[side]);
      upper[side] = larger(other.upper[side], upper[side]);
    }
  }
  Bounds get(int side) const {
    const FourFloats l = lower[side], u = upper[side];
    return {{l[0], l[1], l[2]}, {u[0], u[1], u[2]}};
  }
};

struct BinnedKernels {
  // Adds items to the bins of the three axes, those of an axis `stride` behind the ones before.
  void (*add)(const BinGrid& grid, Bin* bins, std::size_t stride, const BuildItem* begin, const BuildItem* end);
  // Moves items to `left` and `right`, in order. Answers the boxes of their centres.
  SideCentres (*part)(const BinCut& cut, const BuildItem* begin, const BuildItem* end, BuildItem* left, BuildItem* right);
  // Counts those that would go left.
  std::uint32_t (*count_left)(const BinCut& cut, const BuildItem* begin, const BuildItem* end);
};

const BinnedKernels& binned_kernels(Isa isa);  // wide_bvh.cpp

}  // namespace etendue
