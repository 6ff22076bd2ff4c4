// Transport is written over a lane type F, which is one float here, or the 4, 8 or 16 of an instruction set
// (lanes_wide.inl).
//
// A function `template <class F>` computes with F as with a float. Where lanes may differ, a Mask<F> (a bool for one float)
// takes the place of a condition: select(mask, a, b) picks lane by lane, and `if (any(mask))` passes over work that no lane
// needs. Each lane gets the bits that one float would get: there is no operation across lanes, and none whose rounding depends
// on the width.
#pragma once

#include "framework/core/vec.h"

#include <bit>
#include <cstdint>
#include <type_traits>
#include <utility>

namespace etendue {

template <class F>
struct LaneTypes;

template <>
struct LaneTypes<float> {
  using Mask = bool;
  using Bits = std::uint32_t;
  using LongBits = std::uint64_t;
  using Vec2 = vec2;
  using Vec3 = vec3;
  static constexpr int width = 1;
};

template <class F>
using Mask = typename LaneTypes<F>::Mask;
template <class F>
using Bits = typename LaneTypes<F>::Bits;
template <class F>
using LongBits = typename LaneTypes<F>::LongBits;
template <class F>
using Vec2 = typename LaneTypes<F>::Vec2;
template <class F>
using Vec3 = typename LaneTypes<F>::Vec3;
template <class F>
inline constexpr int lane_count = LaneTypes<F>::width;

// The lane type of a vector.
template <class V>
using LaneOf = std::remove_cvref_t<decltype(std::declval<V>().x)>;

// One float. (The functions that <cmath> and GLM have are named in vec.h.)
inline bool any(bool mask) { return mask; }
inline bool all(bool mask) { return mask; }
template <class T>
T select(bool mask, const T& a, const T& b) {
  return mask ? a : b;
}
inline float lane(float x, int) { return x; }
inline vec3 lane(const vec3& v, int) { return v; }
template <class T>
void set_lane(T& x, int, const T& value) {
  x = value;
}
// body(i) for the number of each lane that is set.
template <class Body>
void for_lanes(bool mask, const Body& body) {
  if (mask) body(0);
}
inline std::uint32_t bits_of(float x) { return std::bit_cast<std::uint32_t>(x); }
inline float float_of(std::uint32_t bits) { return std::bit_cast<float>(bits); }
inline float to_float(std::uint32_t x) { return static_cast<float>(x); }  // below 2^31
inline std::uint32_t low_bits(std::uint64_t x) { return static_cast<std::uint32_t>(x); }
inline std::uint32_t high_bits(std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); }
inline std::uint64_t long_bits(std::uint32_t x) { return x; }
inline std::uint32_t rotate_right(std::uint32_t x, std::uint32_t by) { return std::rotr(x, static_cast<int>(by)); }
inline std::uint32_t swap_bytes(std::uint32_t x) { return __builtin_bswap32(x); }

}  // namespace etendue
