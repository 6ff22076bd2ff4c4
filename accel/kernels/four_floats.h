// Four floats in one of the compiler's vectors: x, y and z of a point, and a lane that does not count.
#pragma once

#include "framework/core/vec.h"

#include <cstdint>
#include <cstring>

namespace etendue {

using FourFloats = float __attribute__((vector_size(16)));
using FourInts = std::int32_t __attribute__((vector_size(16)));
using FourUnsigned = std::uint32_t __attribute__((vector_size(16)));

inline FourFloats four(const vec3& v) { return FourFloats{v.x, v.y, v.z, 0}; }
inline FourFloats smaller(FourFloats a, FourFloats b) { return a < b ? a : b; }
inline FourFloats larger(FourFloats a, FourFloats b) { return a > b ? a : b; }

inline FourFloats cross(FourFloats a, FourFloats b) {
  const auto yzx = [](FourFloats v) { return __builtin_shufflevector(v, v, 1, 2, 0, 3); };
  return yzx(a * yzx(b) - yzx(a) * b);
}

// Bounds::centre, by two loads that overlap. The fourth lane does not count, but is finite where the box is.
inline FourFloats centre_of(const Bounds& b) {
  static_assert(sizeof(Bounds) == 6 * sizeof(float));
  FourFloats lower, upper;
  std::memcpy(&lower, &b.lower.x, sizeof lower);
  std::memcpy(&upper, &b.lower.z, sizeof upper);  // lanes 1 to 3
  return 0.5f * lower + 0.5f * __builtin_shufflevector(upper, upper, 1, 2, 3, 3);
}

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

// The product over x, y and z; the fourth lanes must be zero.
inline float dot(FourFloats a, FourFloats b) {
  const FourFloats products = a * b, pairs = products + __builtin_shufflevector(products, products, 1, 0, 3, 2);
  return pairs[0] + pairs[2];
}

}  // namespace etendue
