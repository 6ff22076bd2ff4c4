// Wide traversal with AVX-512: sixteen lanes, comparisons to masks, children stacked by compression.
#include "accel/ray/wide_headers.h"

#if defined(__x86_64__)

#include "accel/ray/simd_compose.inl"
#include "accel/ray/wide_traversal.inl"

namespace etendue {
namespace {

struct Avx512x4 {
  __m128 v;

  static Avx512x4 load(const float* p) { return {_mm_load_ps(p)}; }
  static Avx512x4 set(float x) { return {_mm_set1_ps(x)}; }
  void store(float* p) const { _mm_store_ps(p, v); }
  friend Avx512x4 operator+(Avx512x4 a, Avx512x4 b) { return {_mm_add_ps(a.v, b.v)}; }
  friend Avx512x4 operator-(Avx512x4 a, Avx512x4 b) { return {_mm_sub_ps(a.v, b.v)}; }
  friend Avx512x4 operator*(Avx512x4 a, Avx512x4 b) { return {_mm_mul_ps(a.v, b.v)}; }
  friend Avx512x4 operator/(Avx512x4 a, Avx512x4 b) { return {_mm_div_ps(a.v, b.v)}; }
  friend Avx512x4 larger(Avx512x4 a, Avx512x4 b) { return {_mm_max_ps(a.v, b.v)}; }
  friend Avx512x4 smaller(Avx512x4 a, Avx512x4 b) { return {_mm_min_ps(a.v, b.v)}; }
  friend unsigned less(Avx512x4 a, Avx512x4 b) { return _mm_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ); }
  friend unsigned less_equal(Avx512x4 a, Avx512x4 b) { return _mm_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ); }
  friend unsigned equal(Avx512x4 a, Avx512x4 b) { return _mm_cmp_ps_mask(a.v, b.v, _CMP_EQ_OQ); }
};

struct Avx512x8 {
  __m256 v;

  static Avx512x8 load(const float* p) { return {_mm256_load_ps(p)}; }
  static Avx512x8 set(float x) { return {_mm256_set1_ps(x)}; }
  void store(float* p) const { _mm256_store_ps(p, v); }
  friend Avx512x8 operator+(Avx512x8 a, Avx512x8 b) { return {_mm256_add_ps(a.v, b.v)}; }
  friend Avx512x8 operator-(Avx512x8 a, Avx512x8 b) { return {_mm256_sub_ps(a.v, b.v)}; }
  friend Avx512x8 operator*(Avx512x8 a, Avx512x8 b) { return {_mm256_mul_ps(a.v, b.v)}; }
  friend Avx512x8 operator/(Avx512x8 a, Avx512x8 b) { return {_mm256_div_ps(a.v, b.v)}; }
  friend Avx512x8 larger(Avx512x8 a, Avx512x8 b) { return {_mm256_max_ps(a.v, b.v)}; }
  friend Avx512x8 smaller(Avx512x8 a, Avx512x8 b) { return {_mm256_min_ps(a.v, b.v)}; }
  friend unsigned less(Avx512x8 a, Avx512x8 b) { return _mm256_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ); }
  friend unsigned less_equal(Avx512x8 a, Avx512x8 b) { return _mm256_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ); }
  friend unsigned equal(Avx512x8 a, Avx512x8 b) { return _mm256_cmp_ps_mask(a.v, b.v, _CMP_EQ_OQ); }
};

struct Avx512x16 {
  __m512 v;

  static Avx512x16 load(const float* p) { return {_mm512_load_ps(p)}; }
  static Avx512x16 set(float x) { return {_mm512_set1_ps(x)}; }
  void store(float* p) const { _mm512_store_ps(p, v); }
  friend Avx512x16 operator-(Avx512x16 a, Avx512x16 b) { return {_mm512_sub_ps(a.v, b.v)}; }
  friend Avx512x16 operator*(Avx512x16 a, Avx512x16 b) { return {_mm512_mul_ps(a.v, b.v)}; }
  friend Avx512x16 larger(Avx512x16 a, Avx512x16 b) { return {_mm512_max_ps(a.v, b.v)}; }
  friend Avx512x16 smaller(Avx512x16 a, Avx512x16 b) { return {_mm512_min_ps(a.v, b.v)}; }
  friend unsigned less_equal(Avx512x16 a, Avx512x16 b) { return _mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ); }
};

template <int width>
struct Row;
template <>
struct Row<4> {
  using type = Avx512x4;
};
template <>
struct Row<8> {
  using type = Avx512x8;
};
template <>
struct Row<16> {
  using type = Avx512x16;
};

struct Avx512Simd : LaneByLane {
  template <int width>
  using Floats = typename Row<width>::type;

  using LaneByLane::stack_places;

  template <int width, class Lanes>
  static int nearest(const Lanes& entries, unsigned met) {
    if constexpr (width != 16) {
      return LaneByLane::nearest<width>(entries, met);
    } else {
      const __m512 candidates = _mm512_mask_mov_ps(_mm512_set1_ps(infinity), static_cast<__mmask16>(met), entries.v);
      const __m512 least = _mm512_set1_ps(_mm512_reduce_min_ps(candidates));
      return std::countr_zero<unsigned>(_mm512_mask_cmp_ps_mask(static_cast<__mmask16>(met), candidates, least, _CMP_EQ_OQ));
    }
  }

  // References and entries compressed, then interleaved into (reference, entry) pairs.
  static Waiting* stack_places(const WideNode<16>& node, const Avx512x16& entries, unsigned lanes, Waiting* top) {
    const auto mask = static_cast<__mmask16>(lanes);
    const __m512i places = _mm512_maskz_compress_epi32(mask, _mm512_load_si512(node.children));
    const __m512i keys = _mm512_maskz_compress_epi32(mask, _mm512_castps_si512(entries.v));
    const __m512i low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
    _mm512_storeu_si512(top, _mm512_permutex2var_epi32(places, low, keys));
    const int count = std::popcount(lanes);
    if (count > 8)
      _mm512_storeu_si512(top + 8, _mm512_permutex2var_epi32(places, _mm512_add_epi32(low, _mm512_set1_epi32(8)), keys));
    return top + count;
  }
};

}  // namespace

const WideKernelSet& wide_kernels_avx512() { return kernel_set<Avx512Simd>(); }

}  // namespace etendue
#endif
