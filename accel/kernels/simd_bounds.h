// Points and boxes in vectors of four floats: a builder's inner loops are minima and maxima of them.
#pragma once

#include "accel/kernels/floats.h"
#include "framework/core/vec.h"

namespace etendue {

// x, y and z of a point, and a lane that does not count.
using FourFloats = Vector<float, 4>;
using FourInts = Vector<std::int32_t, 4>;
using FourUnsigned = Vector<std::uint32_t, 4>;

inline FourFloats four(const vec3& v) { return FourFloats{v.x, v.y, v.z, 0}; }
inline FourFloats smaller(FourFloats a, FourFloats b) { return a < b ? a : b; }
inline FourFloats larger(FourFloats a, FourFloats b) { return a > b ? a : b; }
inline FourFloats yzx(FourFloats v) { return __builtin_shufflevector(v, v, 1, 2, 0, 3); }
inline FourFloats cross(FourFloats a, FourFloats b) { return yzx(a * yzx(b) - yzx(a) * b); }

// The product over x, y and z; the fourth lanes must be zero.
inline float dot(FourFloats a, FourFloats b) {
  const FourFloats products = a * b, pairs = products + __builtin_shufflevector(products, products, 1, 0, 3, 2);
  return pairs[0] + pairs[2];
}

// Swaps the halves of vectors, or does not: without a branch.
class HalfSwap {
 public:
  HalfSwap() = default;
#if defined(__SSE4_1__)
  explicit HalfSwap(bool swaps)
      : bytes_(swaps ? _mm_setr_epi8(8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7)
                     : _mm_setr_epi8(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)) {}
  FourFloats operator()(FourFloats v) const { return _mm_castsi128_ps(_mm_shuffle_epi8(_mm_castps_si128(v), bytes_)); }

 private:
  __m128i bytes_;
#else
  explicit HalfSwap(bool swaps) : swaps_(FourInts{} - static_cast<std::int32_t>(swaps)) {}
  FourFloats operator()(FourFloats v) const { return swaps_ ? __builtin_shufflevector(v, v, 2, 3, 0, 1) : v; }

 private:
  FourInts swaps_;
#endif
};

// One lane of a vector in all four.
class LaneCopies {
 public:
#if defined(__SSE4_1__)
  [[gnu::always_inline]] explicit LaneCopies(int lane) : bytes_(_mm_set1_epi32(0x03020100 + 0x04040404 * lane)) {}
  [[gnu::always_inline]] FourInts operator()(FourInts v) const {
    return reinterpret_cast<FourInts>(_mm_shuffle_epi8(reinterpret_cast<__m128i>(v), bytes_));
  }

 private:
  __m128i bytes_;
#else
  [[gnu::always_inline]] explicit LaneCopies(int lane) : lane_(lane) {}
  [[gnu::always_inline]] FourInts operator()(FourInts v) const { return FourInts{} + v[lane_]; }

 private:
  int lane_;
#endif
};

// A box around points. Negative zeros become positive, so that it depends on no order.
class PointBounds {
 public:
  void extend(FourFloats point) {
    lower_ = smaller(point, lower_);
    upper_ = larger(point, upper_);
  }
  Bounds get() const {
    const FourFloats lower = lower_ + 0.0f, upper = upper_ + 0.0f;
    return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
  }

 private:
  FourFloats lower_ = FourFloats{} + infinity, upper_ = FourFloats{} - infinity;
};

struct Uninitialised {};

// The lanes where a SimdBounds holds its bounds along an axis.
struct AxisLanes {
  FourInts lower, upper;

  explicit AxisLanes(int axis) : lower(FourInts{0, 1, 2, 3} == axis), upper(FourInts{-1, 0, 1, 2} == axis) {}
};

// A box under construction. Lanes 0-2 of `lower_` and 1-3 of `upper_` count; the two others hold what the overlapping loads of
// a Bounds bring along.
class SimdBounds {
 public:
  SimdBounds() : lower_(FourFloats{} + infinity), upper_(FourFloats{} - infinity) {}
  explicit SimdBounds(Uninitialised) {}
  explicit SimdBounds(const Bounds& b) {
    static_assert(sizeof(Bounds) == 6 * sizeof(float));
    std::memcpy(&lower_, &b.lower.x, sizeof lower_);
    std::memcpy(&upper_, &b.lower.z, sizeof upper_);
  }

  void extend(const Bounds& b) { extend(SimdBounds(b)); }
  void extend(const SimdBounds& b) {
    lower_ = smaller(lower_, b.lower_);
    upper_ = larger(upper_, b.upper_);
  }
  // Puts a plane in the place of a bound along an axis. A box in memory that was changed in this way must not be loaded at
  // once: a load wider than the store before it waits for that.
  void set_lower(const AxisLanes& axis, float plane) { lower_ = axis.lower ? plane - FourFloats{} : lower_; }
  void set_upper(const AxisLanes& axis, float plane) { upper_ = axis.upper ? plane - FourFloats{} : upper_; }
  Bounds get() const {
    alignas(16) float lower[4], upper[4];
    std::memcpy(lower, &lower_, sizeof lower);
    std::memcpy(upper, &upper_, sizeof upper);
    return {{lower[0], lower[1], lower[2]}, {upper[1], upper[2], upper[3]}};
  }
  // Computes what Bounds::centre does. The fourth lane does not count, but is finite where the box is.
  FourFloats centre() const { return 0.5f * lower_ + 0.5f * __builtin_shufflevector(upper_, upper_, 1, 2, 3, 3); }
  // Computes what Bounds::half_area does, of a box that is not empty.
  float half_area() const {
    const FourFloats extent = __builtin_shufflevector(upper_, upper_, 1, 2, 3, 0) - lower_, products = extent * yzx(extent);
    return products[0] + products[1] + products[2];
  }

 private:
  FourFloats lower_, upper_;
};

}  // namespace etendue
