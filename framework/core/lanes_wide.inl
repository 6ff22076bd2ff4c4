// The lane types of an instruction set: as many floats as its registers hold, in the terms of lanes.h.
//
// Included by sources that are compiled for one instruction set, after its intrinsics. All is in an unnamed namespace, and so
// is then every template over it: the linker never takes such code for another source's.
#pragma once

#include "framework/core/lanes.h"

#if defined(__AVX__)
#include <immintrin.h>
#else
#include <smmintrin.h>
#endif

namespace etendue {
namespace {

#if defined(__AVX512F__)
constexpr int widest_lanes = 16;
using Register = __m512;
#elif defined(__AVX2__)
constexpr int widest_lanes = 8;
using Register = __m256;
#else
constexpr int widest_lanes = 4;
using Register = __m128;
#endif

using FloatVector [[gnu::vector_size(4 * widest_lanes)]] = float;
using BitsVector [[gnu::vector_size(4 * widest_lanes)]] = std::uint32_t;
using IntVector [[gnu::vector_size(4 * widest_lanes)]] = std::int32_t;
using HalfBitsVector [[gnu::vector_size(2 * widest_lanes)]] = std::uint32_t;
using LongVector [[gnu::vector_size(4 * widest_lanes)]] = std::uint64_t;

// A condition in each lane.
class WideMask {
 public:
#if defined(__AVX512F__)
  using Held = __mmask16;
#else
  using Held = IntVector;  // all bits or none
#endif
  WideMask() = default;
  explicit WideMask(Held held) : held_(held) {}
  WideMask(bool all)  // NOLINT(google-explicit-constructor): what is known for all lanes
#if defined(__AVX512F__)
      : held_(all ? 0xffff : 0){}
#else
      : held_(IntVector{} - static_cast<int>(all)) {
  }
#endif
        Held held() const {
    return held_;
  }
  unsigned lanes() const {  // a bit each
#if defined(__AVX512F__)
    return held_;
#elif defined(__AVX2__)
    return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(held_)));
#else
    return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(held_)));
#endif
  }
  static WideMask first(int count) {  // the first lanes alone
#if defined(__AVX512F__)
    return WideMask(static_cast<Held>((1u << count) - 1));
#else
    IntVector number;
    for (int i = 0; i < widest_lanes; ++i) number[i] = i;
    return WideMask(number < count);
#endif
  }

  friend WideMask operator&(WideMask a, WideMask b) { return WideMask(static_cast<Held>(a.held_ & b.held_)); }
  friend WideMask operator|(WideMask a, WideMask b) { return WideMask(static_cast<Held>(a.held_ | b.held_)); }
  friend WideMask operator^(WideMask a, WideMask b) { return WideMask(static_cast<Held>(a.held_ ^ b.held_)); }
  friend WideMask operator!(WideMask a) { return WideMask(static_cast<Held>(~a.held_)); }
  friend WideMask operator==(WideMask a, WideMask b) { return !(a ^ b); }
  friend WideMask operator!=(WideMask a, WideMask b) { return a ^ b; }
  friend bool any(WideMask m) { return m.lanes() != 0; }
  friend bool all(WideMask m) { return m.lanes() == (1u << widest_lanes) - 1; }

 private:
  Held held_;
};

// body(i) for the number of each lane that is set.
template <class Body>
void for_lanes(WideMask mask, const Body& body) {
  for (unsigned rest = mask.lanes(); rest != 0; rest &= rest - 1) body(__builtin_ctz(rest));
}

struct WideFloats {
  FloatVector v;

  WideFloats() = default;
  WideFloats(FloatVector value) : v(value) {}    // NOLINT(google-explicit-constructor)
  WideFloats(float x) : v(x - FloatVector{}) {}  // NOLINT(google-explicit-constructor): the same in all lanes
  static WideFloats load(const float* p) {       // aligned
    return *reinterpret_cast<const FloatVector*>(p);
  }
  void store(float* p) const { *reinterpret_cast<FloatVector*>(p) = v; }
  Register r() const { return reinterpret_cast<Register>(v); }
  static WideFloats of(Register r) { return reinterpret_cast<FloatVector>(r); }

  friend WideFloats operator+(WideFloats a, WideFloats b) { return a.v + b.v; }
  friend WideFloats operator-(WideFloats a, WideFloats b) { return a.v - b.v; }
  friend WideFloats operator*(WideFloats a, WideFloats b) { return a.v * b.v; }
  friend WideFloats operator/(WideFloats a, WideFloats b) { return a.v / b.v; }
  friend WideFloats operator-(WideFloats a) { return -a.v; }
  WideFloats& operator+=(WideFloats b) { return *this = *this + b; }
  WideFloats& operator*=(WideFloats b) { return *this = *this * b; }
  WideFloats& operator/=(WideFloats b) { return *this = *this / b; }

#if defined(__AVX512F__)
#define ETENDUE_COMPARE(op, predicate) \
  friend WideMask operator op(WideFloats a, WideFloats b) { return WideMask(_mm512_cmp_ps_mask(a.r(), b.r(), predicate)); }
#else
#define ETENDUE_COMPARE(op, predicate) \
  friend WideMask operator op(WideFloats a, WideFloats b) { return WideMask(a.v op b.v); }
#endif
  ETENDUE_COMPARE(<, _CMP_LT_OQ)
  ETENDUE_COMPARE(<=, _CMP_LE_OQ)
  ETENDUE_COMPARE(>, _CMP_GT_OQ)
  ETENDUE_COMPARE(>=, _CMP_GE_OQ)
  ETENDUE_COMPARE(==, _CMP_EQ_OQ)
  ETENDUE_COMPARE(!=, _CMP_NEQ_UQ)
#undef ETENDUE_COMPARE

#if defined(__AVX512F__)
#define ETENDUE_OF_SET(name) _mm512_##name
#elif defined(__AVX2__)
#define ETENDUE_OF_SET(name) _mm256_##name
#else
#define ETENDUE_OF_SET(name) _mm_##name
#endif
  friend WideFloats sqrt(WideFloats a) { return of(ETENDUE_OF_SET(sqrt_ps)(a.r())); }
  // The operands in the order that gives the answers of std::min and std::max to NaN and to zeros of both signs.
  friend WideFloats min(WideFloats a, WideFloats b) { return of(ETENDUE_OF_SET(min_ps)(b.r(), a.r())); }
  friend WideFloats max(WideFloats a, WideFloats b) { return of(ETENDUE_OF_SET(max_ps)(b.r(), a.r())); }
  friend WideFloats floor(WideFloats a) {
#if defined(__AVX512F__)
    return of(_mm512_roundscale_ps(a.r(), _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC));
#else
    return of(ETENDUE_OF_SET(floor_ps)(a.r()));
#endif
  }
#undef ETENDUE_OF_SET
  friend WideFloats abs(WideFloats a) { return reinterpret_cast<FloatVector>(reinterpret_cast<BitsVector>(a.v) & 0x7fffffffu); }
  friend WideFloats copysign(WideFloats a, WideFloats sign) {
    return reinterpret_cast<FloatVector>((reinterpret_cast<BitsVector>(a.v) & 0x7fffffffu) |
                                         (reinterpret_cast<BitsVector>(sign.v) & 0x80000000u));
  }
  friend WideFloats square(WideFloats a) { return a * a; }
  friend WideFloats safe_sqrt(WideFloats a) { return sqrt(max(0.0f, a)); }
  friend WideFloats select(WideMask m, WideFloats a, WideFloats b) {
#if defined(__AVX512F__)
    return of(_mm512_mask_blend_ps(m.held(), b.r(), a.r()));
#else
    return m.held() ? a.v : b.v;
#endif
  }
};

struct WideBits {
  BitsVector v;

  WideBits() = default;
  WideBits(BitsVector value) : v(value) {}            // NOLINT(google-explicit-constructor)
  WideBits(std::uint32_t x) : v(BitsVector{} + x) {}  // NOLINT(google-explicit-constructor): the same in all lanes
  static WideBits load(const std::uint32_t* p) { return *reinterpret_cast<const BitsVector*>(p); }
  void store(std::uint32_t* p) const { *reinterpret_cast<BitsVector*>(p) = v; }

  friend WideBits operator+(WideBits a, WideBits b) { return a.v + b.v; }
  friend WideBits operator-(WideBits a, WideBits b) { return a.v - b.v; }
  friend WideBits operator*(WideBits a, WideBits b) { return a.v * b.v; }
  friend WideBits operator&(WideBits a, WideBits b) { return a.v & b.v; }
  friend WideBits operator|(WideBits a, WideBits b) { return a.v | b.v; }
  friend WideBits operator^(WideBits a, WideBits b) { return a.v ^ b.v; }
  friend WideBits operator<<(WideBits a, int by) { return a.v << by; }
  friend WideBits operator>>(WideBits a, int by) { return a.v >> by; }
#if defined(__AVX512F__)
  friend WideMask operator==(WideBits a, WideBits b) {
    return WideMask(_mm512_cmpeq_epi32_mask(reinterpret_cast<__m512i>(a.v), reinterpret_cast<__m512i>(b.v)));
  }
#else
  friend WideMask operator==(WideBits a, WideBits b) { return WideMask(reinterpret_cast<IntVector>(a.v == b.v)); }
#endif
  friend WideMask operator!=(WideBits a, WideBits b) { return !(a == b); }
  WideBits& operator^=(WideBits b) { return *this = *this ^ b; }
  WideBits& operator+=(WideBits b) { return *this = *this + b; }
  WideBits& operator*=(WideBits b) { return *this = *this * b; }

  friend WideBits rotate_right(WideBits x, WideBits by) { return x.v >> by.v | x.v << (-by.v & 31); }
  friend WideBits swap_bytes(WideBits x) { return x.v >> 24 | (x.v >> 8 & 0xff00u) | (x.v << 8 & 0xff0000u) | x.v << 24; }
  friend WideBits select(WideMask m, WideBits a, WideBits b) {
#if defined(__AVX512F__)
    return reinterpret_cast<BitsVector>(
        _mm512_mask_blend_epi32(m.held(), reinterpret_cast<__m512i>(b.v), reinterpret_cast<__m512i>(a.v)));
#else
    return m.held() ? a.v : b.v;
#endif
  }
};

// 64 bits a lane, in two registers: the first half of the lanes, and the second.
struct WideLongBits {
  LongVector low, high;

  WideLongBits() = default;
  WideLongBits(LongVector l, LongVector h) : low(l), high(h) {}
  WideLongBits(std::uint64_t x) : low(LongVector{} + x), high(low) {}  // NOLINT(google-explicit-constructor)
  static WideLongBits load(const std::uint64_t* p) {
    const auto* v = reinterpret_cast<const LongVector*>(p);
    return {v[0], v[1]};
  }
  void store(std::uint64_t* p) const {
    auto* v = reinterpret_cast<LongVector*>(p);
    v[0] = low;
    v[1] = high;
  }

  friend WideLongBits operator+(WideLongBits a, WideLongBits b) { return {a.low + b.low, a.high + b.high}; }
  friend WideLongBits operator*(WideLongBits a, WideLongBits b) { return {a.low * b.low, a.high * b.high}; }
  friend WideLongBits operator^(WideLongBits a, WideLongBits b) { return {a.low ^ b.low, a.high ^ b.high}; }
  friend WideLongBits operator|(WideLongBits a, WideLongBits b) { return {a.low | b.low, a.high | b.high}; }
  friend WideLongBits operator>>(WideLongBits a, int by) { return {a.low >> by, a.high >> by}; }
  friend WideLongBits operator<<(WideLongBits a, int by) { return {a.low << by, a.high << by}; }
  WideLongBits& operator+=(WideLongBits b) { return *this = *this + b; }
};

inline float lane(WideFloats x, int i) { return x.v[i]; }
inline void set_lane(WideFloats& x, int i, float value) { x.v[i] = value; }
inline WideBits bits_of(WideFloats x) { return reinterpret_cast<BitsVector>(x.v); }
inline WideFloats float_of(WideBits x) { return reinterpret_cast<FloatVector>(x.v); }
inline WideFloats to_float(WideBits x) { return __builtin_convertvector(reinterpret_cast<IntVector>(x.v), FloatVector); }
inline WideBits low_bits(WideLongBits x) {
  BitsVector out;
  const auto low = __builtin_convertvector(x.low, HalfBitsVector), high = __builtin_convertvector(x.high, HalfBitsVector);
  __builtin_memcpy(&out, &low, sizeof low);
  __builtin_memcpy(reinterpret_cast<char*>(&out) + sizeof low, &high, sizeof high);
  return out;
}
inline WideBits high_bits(WideLongBits x) { return low_bits(x >> 32); }
inline WideLongBits long_bits(WideBits x) {
  HalfBitsVector low, high;
  __builtin_memcpy(&low, &x.v, sizeof low);
  __builtin_memcpy(&high, reinterpret_cast<const char*>(&x.v) + sizeof low, sizeof high);
  return {__builtin_convertvector(low, LongVector), __builtin_convertvector(high, LongVector)};
}

struct WideVec2 {
  WideFloats x, y;

  WideVec2() = default;
  WideVec2(WideFloats a, WideFloats b) : x(a), y(b) {}
  friend WideVec2 operator*(WideFloats s, const WideVec2& v) { return {s * v.x, s * v.y}; }
  friend WideVec2 operator*(const WideVec2& v, WideFloats s) { return {v.x * s, v.y * s}; }
  friend WideVec2 operator-(const WideVec2& v, WideFloats s) { return {v.x - s, v.y - s}; }
};

// Operations are in GLM's order, so that the bits are the same.
struct WideVec3 {
  WideFloats x, y, z;

  WideVec3() = default;
  WideVec3(WideFloats a, WideFloats b, WideFloats c) : x(a), y(b), z(c) {}
  explicit WideVec3(WideFloats all) : x(all), y(all), z(all) {}
  WideVec3(const vec3& v) : x(v.x), y(v.y), z(v.z) {}  // NOLINT(google-explicit-constructor): the same in all lanes

  friend WideVec3 operator+(const WideVec3& a, const WideVec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend WideVec3 operator-(const WideVec3& a, const WideVec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend WideVec3 operator*(const WideVec3& a, const WideVec3& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
  friend WideVec3 operator/(const WideVec3& a, const WideVec3& b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
  friend WideVec3 operator+(const WideVec3& v, WideFloats s) { return {v.x + s, v.y + s, v.z + s}; }
  friend WideVec3 operator-(WideFloats s, const WideVec3& v) { return {s - v.x, s - v.y, s - v.z}; }
  friend WideVec3 operator*(WideFloats s, const WideVec3& v) { return {s * v.x, s * v.y, s * v.z}; }
  friend WideVec3 operator*(const WideVec3& v, WideFloats s) { return {v.x * s, v.y * s, v.z * s}; }
  friend WideVec3 operator/(const WideVec3& v, WideFloats s) { return {v.x / s, v.y / s, v.z / s}; }
  friend WideVec3 operator-(const WideVec3& v) { return {-v.x, -v.y, -v.z}; }
  WideVec3& operator*=(const WideVec3& b) { return *this = *this * b; }
  WideVec3& operator*=(WideFloats s) { return *this = *this * s; }
  WideVec3& operator/=(WideFloats s) { return *this = *this / s; }

  friend WideFloats dot(const WideVec3& a, const WideVec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  friend WideVec3 cross(const WideVec3& a, const WideVec3& b) {
    return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
  }
  friend WideFloats length(const WideVec3& v) { return sqrt(dot(v, v)); }
  friend WideVec3 normalize(const WideVec3& v) { return v * (1.0f / sqrt(dot(v, v))); }
  friend WideFloats length_squared(const WideVec3& v) { return dot(v, v); }
  friend WideFloats max_component(const WideVec3& v) { return max(v.x, max(v.y, v.z)); }
  friend WideFloats mean_component(const WideVec3& v) { return (v.x + v.y + v.z) * (1.0f / 3.0f); }
  friend WideMask is_black(const WideVec3& v) { return (v.x == 0) & (v.y == 0) & (v.z == 0); }
  friend WideVec3 max(const WideVec3& a, const WideVec3& b) { return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)}; }
  friend WideVec3 abs(const WideVec3& v) { return {abs(v.x), abs(v.y), abs(v.z)}; }
  friend WideVec3 select(WideMask m, const WideVec3& a, const WideVec3& b) {
    return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
  }
};

inline vec3 lane(const WideVec3& v, int i) { return {lane(v.x, i), lane(v.y, i), lane(v.z, i)}; }
inline void set_lane(WideVec3& v, int i, const vec3& value) {
  set_lane(v.x, i, value.x);
  set_lane(v.y, i, value.y);
  set_lane(v.z, i, value.z);
}

// framework/scene/triangle_point.h, rounded_twice_area: the products in double precision, half of the lanes at a time.
inline WideVec3 rounded_twice_area(const WideVec3& a, const WideVec3& b, const WideVec3& c) {
  using HalfFloats [[gnu::vector_size(2 * widest_lanes)]] = float;
  using Doubles [[gnu::vector_size(4 * widest_lanes)]] = double;
  alignas(64) float out[3][widest_lanes];
  for (int half = 0; half < 2; ++half) {
    const auto doubles = [half](WideFloats x) {
      HalfFloats part;
      __builtin_memcpy(&part, reinterpret_cast<const char*>(&x.v) + half * sizeof part, sizeof part);
      return __builtin_convertvector(part, Doubles);
    };
    const auto put = [&](int axis, Doubles x) {
      const HalfFloats part = __builtin_convertvector(x, HalfFloats);
      __builtin_memcpy(out[axis] + half * widest_lanes / 2, &part, sizeof part);
    };
    const Doubles ax = doubles(a.x), ay = doubles(a.y), az = doubles(a.z);
    const Doubles ux = doubles(b.x) - ax, uy = doubles(b.y) - ay, uz = doubles(b.z) - az;
    const Doubles vx = doubles(c.x) - ax, vy = doubles(c.y) - ay, vz = doubles(c.z) - az;
    put(0, uy * vz - vy * uz);
    put(1, uz * vx - vz * ux);
    put(2, ux * vy - vx * uy);
  }
  return {WideFloats::load(out[0]), WideFloats::load(out[1]), WideFloats::load(out[2])};
}

}  // namespace

template <>
struct LaneTypes<WideFloats> {
  using Mask = WideMask;
  using Bits = WideBits;
  using LongBits = WideLongBits;
  using Vec2 = WideVec2;
  using Vec3 = WideVec3;
  static constexpr int width = widest_lanes;
};

}  // namespace etendue
