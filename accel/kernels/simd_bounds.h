// A box under construction, held in two SIMD registers: a builder's inner loops are minima and maxima of boxes.
#pragma once

#include "framework/core/vec.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace etendue {

struct Uninitialised {};

#if defined(__SSE2__)

// Where a box holds its bounds along an axis.
class AxisLanes {
 public:
  explicit AxisLanes(int axis)
      : lower_(_mm_castsi128_ps(_mm_cmpeq_epi32(_mm_setr_epi32(0, 1, 2, 3), _mm_set1_epi32(axis)))),
        upper_(_mm_castsi128_ps(_mm_cmpeq_epi32(_mm_setr_epi32(-1, 0, 1, 2), _mm_set1_epi32(axis)))) {}

 private:
  friend class SimdBounds;
  __m128 lower_, upper_;
};

// Lanes 0-2 of `lower_` and 1-3 of `upper_` count; the two others hold what the overlapping loads of a Bounds bring along.
class SimdBounds {
 public:
  SimdBounds() : lower_(_mm_set1_ps(infinity)), upper_(_mm_set1_ps(-infinity)) {}
  explicit SimdBounds(Uninitialised) {}
  explicit SimdBounds(const Bounds& b) : lower_(_mm_loadu_ps(&b.lower.x)), upper_(_mm_loadu_ps(&b.lower.x + 2)) {
    static_assert(sizeof(Bounds) == 6 * sizeof(float));
  }

  void extend(const Bounds& b) { extend(SimdBounds(b)); }
  void extend(const SimdBounds& b) {
    lower_ = _mm_min_ps(lower_, b.lower_);
    upper_ = _mm_max_ps(upper_, b.upper_);
  }
  // A plane in place of a bound along an axis. A box in memory that is changed so must not be loaded at once: a load wider than
  // the store before it waits for that.
  void set_lower(const AxisLanes& axis, float plane) { lower_ = blend(lower_, _mm_set1_ps(plane), axis.lower_); }
  void set_upper(const AxisLanes& axis, float plane) { upper_ = blend(upper_, _mm_set1_ps(plane), axis.upper_); }
  Bounds get() const {
    alignas(16) float lower[4], upper[4];
    _mm_store_ps(lower, lower_);
    _mm_store_ps(upper, upper_);
    return {{lower[0], lower[1], lower[2]}, {upper[1], upper[2], upper[3]}};
  }
  // As Bounds::half_area, of a box that is not empty.
  float half_area() const {
    const __m128 xyz = _mm_sub_ps(_mm_shuffle_ps(upper_, upper_, _MM_SHUFFLE(0, 3, 2, 1)), lower_);
    const __m128 yzx = _mm_shuffle_ps(xyz, xyz, _MM_SHUFFLE(3, 0, 2, 1));
    const __m128 products = _mm_mul_ps(xyz, yzx);
    const __m128 second = _mm_shuffle_ps(products, products, _MM_SHUFFLE(1, 1, 1, 1));
    return _mm_cvtss_f32(_mm_add_ss(_mm_add_ss(products, second), _mm_movehl_ps(products, products)));
  }

 private:
  static __m128 blend(__m128 a, __m128 b, __m128 mask) { return _mm_or_ps(_mm_andnot_ps(mask, a), _mm_and_ps(mask, b)); }

  __m128 lower_, upper_;
};

#else

struct AxisLanes {
  int axis;
};

class SimdBounds {
 public:
  SimdBounds() = default;
  explicit SimdBounds(Uninitialised) {}
  explicit SimdBounds(const Bounds& b) : bounds_(b) {}

  void extend(const Bounds& b) { bounds_.extend(b); }
  void extend(const SimdBounds& b) { bounds_.extend(b.bounds_); }
  void set_lower(const AxisLanes& lanes, float plane) { bounds_.lower[lanes.axis] = plane; }
  void set_upper(const AxisLanes& lanes, float plane) { bounds_.upper[lanes.axis] = plane; }
  Bounds get() const { return bounds_; }
  float half_area() const { return bounds_.half_area(); }

 private:
  Bounds bounds_;
};

#endif

}  // namespace etendue
