// The slabs between which a spatial split is sought ([Stich2009] section 4.2), and the boxes of what lies in each: the same
// bins serve for cuts between references, by their centres, and for cuts through them.
#pragma once

#include "accel/kernels/simd_bounds.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace etendue {

inline constexpr std::uint32_t max_slabs = 256;

// Equal intervals of an extent, each a half-open slab but the last.
class Slabs {
 public:
  Slabs(float lower, float upper, std::uint32_t count)
      : lower_(lower),
        width_((upper - lower) / static_cast<float>(count)),
        scale_(static_cast<float>(count) / (upper - lower)),
        count_(count) {}

  bool usable() const { return scale_ > 0 && scale_ < infinity && width_ > 0; }
  std::uint32_t of(float x) const {
    const float slab = (x - lower_) * scale_;
    return slab > 0 ? std::min(static_cast<std::uint32_t>(std::min(slab, 1e6f)), count_ - 1) : 0;
  }
  float plane(std::uint32_t slab) const { return lower_ + static_cast<float>(slab) * width_; }  // where it begins
  std::uint32_t count() const { return count_; }

 private:
  float lower_, width_, scale_;
  std::uint32_t count_;
};

struct SlabBin {
  SimdBounds bounds;
  std::uint32_t begins = 0, ends = 0;  // references
};

struct SlabCut {
  float cost = infinity;  // references on both sides, weighted by area
  int axis = -1;
  std::uint32_t slab = 0;             // where the right side begins
  std::uint32_t left = 0, right = 0;  // references
  Bounds left_bounds, right_bounds;
};

// The bins of one axis at a time, with room for the sweep. Reused for many nodes, because initialising them takes longer than a
// small node.
class SlabBins {
 public:
  SlabBin& operator[](std::uint32_t slab) { return bins_[slab]; }
  void clear(std::uint32_t count) {
    count_ = count;
    std::fill_n(bins_.begin(), count, SlabBin());
  }

  // Keeps the cheapest cut between two bins, where it is cheaper than `best`.
  void sweep(int axis, SlabCut& best) {
    SimdBounds bounds;
    std::uint32_t count = 0;
    for (std::uint32_t i = count_ - 1; i > 0; --i) {
      bounds.extend(bins_[i].bounds);
      right_[i] = bounds;
      right_count_[i] = count += bins_[i].ends;
    }
    bounds = {};
    count = 0;
    for (std::uint32_t i = 1; i < count_; ++i) {
      bounds.extend(bins_[i - 1].bounds);
      count += bins_[i - 1].begins;
      if (count == 0 || right_count_[i] == 0) continue;
      const float cost =
          bounds.half_area() * static_cast<float>(count) + right_[i].half_area() * static_cast<float>(right_count_[i]);
      if (cost < best.cost) best = {cost, axis, i, count, right_count_[i], bounds.get(), right_[i].get()};
    }
  }

 private:
  std::uint32_t count_ = 0;
  std::array<SlabBin, max_slabs> bins_;
  std::array<SimdBounds, max_slabs> right_;
  std::array<std::uint32_t, max_slabs> right_count_;
};

// Chops a box into the slabs that it spans.
inline void chop_box(const Bounds& box, int axis, const Slabs& slabs, std::uint32_t first, std::uint32_t last, SlabBins& bins) {
  const AxisLanes lanes(axis);
  SimdBounds rest(box);
  float lower = box.lower[axis];
  const float upper = box.upper[axis];
  for (std::uint32_t slab = first; slab < last; ++slab) {
    const float plane = slabs.plane(slab + 1);
    if (!(lower < plane && plane < upper)) continue;
    SimdBounds part = rest;
    part.set_upper(lanes, plane);
    bins[slab].bounds.extend(part);
    rest.set_lower(lanes, plane);
    lower = plane;
  }
  bins[last].bounds.extend(rest);
}

}  // namespace etendue
