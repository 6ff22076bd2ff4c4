// The one SIMD type of the kernels: a vector of `width` floats for an instruction set whose registers hold up to `widest`. One
// float is the scalar form of every test; a vector wider than a register is two halves side by side.
//
// Each operation rounds by itself (the project is compiled without FMA contraction), so a lane gives the bits of the scalar
// form at any width. `larger` and `smaller` answer their second operand when one is NaN, as x86 does. Comparisons give a bit
// per lane. `widest` is part of the type so that code compiled for one instruction set never stands in for another's when the
// program is linked.
#pragma once

#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

#if defined(__AVX__)
#include <immintrin.h>
#elif defined(__x86_64__)
#include <smmintrin.h>  // which is parsed far sooner
#endif

namespace etendue {

// The widest vectors that this file is compiled for.
#if defined(__AVX512F__)
inline constexpr int native_width = 16;
#elif defined(__AVX2__)
inline constexpr int native_width = 8;
#elif defined(__SSE4_1__)
inline constexpr int native_width = 4;
#else
inline constexpr int native_width = 1;
#endif

// The compiler's own vectors; one float is no vector.
template <class T, int width>
struct VectorOf {
  typedef T type __attribute__((vector_size(width * sizeof(T))));
};
template <class T>
struct VectorOf<T, 1> {
  using type = T;
};
template <class T, int width>
using Vector = typename VectorOf<T, width>::type;

// These need intrinsics: a bit per lane of a comparison, and a choice of lanes. They are always inlined, as files are compiled
// for several instruction sets.
[[gnu::always_inline]] inline unsigned lane_bits(bool mask) { return mask; }
[[gnu::always_inline]] inline unsigned lane_bits(Vector<std::int32_t, 4> mask) {
#if defined(__SSE4_1__)
  return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(mask)));
#else
  return static_cast<unsigned>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}
#if defined(__AVX2__)
[[gnu::always_inline]] inline unsigned lane_bits(Vector<std::int32_t, 8> mask) {
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
}
#endif

#if defined(__AVX2__)
// Picks eight lanes of sixteen.
[[gnu::always_inline]] inline Vector<float, 8> picked(Vector<float, 8> low, Vector<float, 8> high, const std::uint8_t* slots) {
  const __m256i which = _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(slots)));
  return _mm256_blendv_ps(_mm256_permutevar8x32_ps(low, which), _mm256_permutevar8x32_ps(high, which),
                          _mm256_castsi256_ps(_mm256_slli_epi32(which, 28)));
}
#endif

template <class V>
[[gnu::always_inline]] inline unsigned less_bits(V a, V b) {
  return lane_bits(a < b);
}
template <class V>
[[gnu::always_inline]] inline unsigned less_equal_bits(V a, V b) {
  return lane_bits(a <= b);
}
template <class V>
[[gnu::always_inline]] inline unsigned equal_bits(V a, V b) {
  return lane_bits(a == b);
}
#if defined(__AVX512F__)
[[gnu::always_inline]] inline unsigned less_bits(__m512 a, __m512 b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
[[gnu::always_inline]] inline unsigned less_equal_bits(__m512 a, __m512 b) { return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ); }
[[gnu::always_inline]] inline unsigned equal_bits(__m512 a, __m512 b) { return _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ); }
[[gnu::always_inline]] inline Vector<float, 16> picked(Vector<float, 16> values, const std::uint8_t* slots) {
  return _mm512_permutexvar_ps(_mm512_cvtepu8_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(slots))), values);
}
#endif

inline bool any_lane(unsigned lanes) { return lanes != 0; }

template <int width, int widest>
struct Floats {
  using Half = Floats<width / 2, widest>;
  static constexpr int half = width / 2;

  Half low, high;

  static Floats load(const float* p) { return {Half::load(p), Half::load(p + half)}; }
  static Floats load_anywhere(const float* p) { return {Half::load_anywhere(p), Half::load_anywhere(p + half)}; }
  static Floats set(float x) { return {Half::set(x), Half::set(x)}; }
  void store(float* p) const {
    low.store(p);
    high.store(p + half);
  }
  void store_anywhere(float* p) const {
    low.store_anywhere(p);
    high.store_anywhere(p + half);
  }
  // Each lane gets the one that `slots` names for it; pick_half does so for the lanes of the first half alone.
  Floats pick(const std::uint8_t* slots) const { return {pick_half(slots), pick_half(slots + half)}; }
  Half pick_half(const std::uint8_t* slots) const {
#if defined(__AVX2__)
    if constexpr (width == 16) return {picked(low.v, high.v, slots)};
#endif
    alignas(64) float all[width], picked[half];
    store(all);
    for (int lane = 0; lane < half; ++lane) picked[lane] = all[slots[lane]];
    return Half::load(picked);
  }
  friend Floats operator+(const Floats& a, const Floats& b) { return {a.low + b.low, a.high + b.high}; }
  friend Floats operator-(const Floats& a, const Floats& b) { return {a.low - b.low, a.high - b.high}; }
  friend Floats operator*(const Floats& a, const Floats& b) { return {a.low * b.low, a.high * b.high}; }
  friend Floats operator/(const Floats& a, const Floats& b) { return {a.low / b.low, a.high / b.high}; }
  friend Floats larger(const Floats& a, const Floats& b) { return {larger(a.low, b.low), larger(a.high, b.high)}; }
  friend Floats smaller(const Floats& a, const Floats& b) { return {smaller(a.low, b.low), smaller(a.high, b.high)}; }
  friend Floats infinite_above(const Floats& a, const Floats& b) {
    return {infinite_above(a.low, b.low), infinite_above(a.high, b.high)};
  }
  friend unsigned less(const Floats& a, const Floats& b) { return less(a.low, b.low) | less(a.high, b.high) << half; }
  friend unsigned less_equal(const Floats& a, const Floats& b) {
    return less_equal(a.low, b.low) | less_equal(a.high, b.high) << half;
  }
  friend unsigned equal(const Floats& a, const Floats& b) { return equal(a.low, b.low) | equal(a.high, b.high) << half; }
};

// The vector that a register holds.
template <int width, int widest>
requires(width <= widest) struct Floats<width, widest> {
  Vector<float, width> v;

  static Floats load(const float* p) {
    return load_anywhere(static_cast<const float*>(__builtin_assume_aligned(p, 4 * width)));
  }
  static Floats load_anywhere(const float* p) {
    Floats loaded;
    std::memcpy(&loaded.v, p, sizeof loaded.v);
    return loaded;
  }
  static Floats set(float x) { return {x - Vector<float, width>{}}; }
  void store(float* p) const { store_anywhere(static_cast<float*>(__builtin_assume_aligned(p, 4 * width))); }
  void store_anywhere(float* p) const { std::memcpy(p, &v, sizeof v); }
  Floats pick(const std::uint8_t* slots) const { return {picked(v, slots)}; }
  friend Floats operator+(Floats a, Floats b) { return {a.v + b.v}; }
  friend Floats operator-(Floats a, Floats b) { return {a.v - b.v}; }
  friend Floats operator*(Floats a, Floats b) { return {a.v * b.v}; }
  friend Floats operator/(Floats a, Floats b) { return {a.v / b.v}; }
  friend Floats larger(Floats a, Floats b) { return {a.v > b.v ? a.v : b.v}; }
  friend Floats smaller(Floats a, Floats b) { return {a.v < b.v ? a.v : b.v}; }
  // The first where it is at most the second, else infinity.
  friend Floats infinite_above(Floats a, Floats b) {
    return {a.v <= b.v ? a.v : set(std::numeric_limits<float>::infinity()).v};
  }
  friend unsigned less(Floats a, Floats b) { return less_bits(a.v, b.v); }
  friend unsigned less_equal(Floats a, Floats b) { return less_equal_bits(a.v, b.v); }
  friend unsigned equal(Floats a, Floats b) { return equal_bits(a.v, b.v); }
};

}  // namespace etendue
