// Wide traversal with AVX2: eight lanes.
#include "accel/ray/wide_headers.h"

#if defined(__x86_64__)

#include "accel/ray/simd_compose.inl"
#include "accel/ray/wide_traversal.inl"

namespace etendue {
namespace {

struct Avx4 {
  __m128 v;

  static Avx4 load(const float* p) { return {_mm_load_ps(p)}; }
  static Avx4 set(float x) { return {_mm_set1_ps(x)}; }
  void store(float* p) const { _mm_store_ps(p, v); }
  friend Avx4 operator+(Avx4 a, Avx4 b) { return {_mm_add_ps(a.v, b.v)}; }
  friend Avx4 operator-(Avx4 a, Avx4 b) { return {_mm_sub_ps(a.v, b.v)}; }
  friend Avx4 operator*(Avx4 a, Avx4 b) { return {_mm_mul_ps(a.v, b.v)}; }
  friend Avx4 operator/(Avx4 a, Avx4 b) { return {_mm_div_ps(a.v, b.v)}; }
  friend Avx4 larger(Avx4 a, Avx4 b) { return {_mm_max_ps(a.v, b.v)}; }
  friend Avx4 smaller(Avx4 a, Avx4 b) { return {_mm_min_ps(a.v, b.v)}; }
  friend unsigned less(Avx4 a, Avx4 b) { return static_cast<unsigned>(_mm_movemask_ps(_mm_cmplt_ps(a.v, b.v))); }
  friend unsigned less_equal(Avx4 a, Avx4 b) { return static_cast<unsigned>(_mm_movemask_ps(_mm_cmple_ps(a.v, b.v))); }
  friend unsigned equal(Avx4 a, Avx4 b) { return static_cast<unsigned>(_mm_movemask_ps(_mm_cmpeq_ps(a.v, b.v))); }
};

struct Avx8 {
  __m256 v;

  static Avx8 load(const float* p) { return {_mm256_load_ps(p)}; }
  static Avx8 set(float x) { return {_mm256_set1_ps(x)}; }
  void store(float* p) const { _mm256_store_ps(p, v); }
  friend Avx8 operator+(Avx8 a, Avx8 b) { return {_mm256_add_ps(a.v, b.v)}; }
  friend Avx8 operator-(Avx8 a, Avx8 b) { return {_mm256_sub_ps(a.v, b.v)}; }
  friend Avx8 operator*(Avx8 a, Avx8 b) { return {_mm256_mul_ps(a.v, b.v)}; }
  friend Avx8 operator/(Avx8 a, Avx8 b) { return {_mm256_div_ps(a.v, b.v)}; }
  friend Avx8 larger(Avx8 a, Avx8 b) { return {_mm256_max_ps(a.v, b.v)}; }
  friend Avx8 smaller(Avx8 a, Avx8 b) { return {_mm256_min_ps(a.v, b.v)}; }
  friend unsigned less(Avx8 a, Avx8 b) { return bits(_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)); }
  friend unsigned less_equal(Avx8 a, Avx8 b) { return bits(_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)); }
  friend unsigned equal(Avx8 a, Avx8 b) { return bits(_mm256_cmp_ps(a.v, b.v, _CMP_EQ_OQ)); }

 private:
  static unsigned bits(__m256 mask) { return static_cast<unsigned>(_mm256_movemask_ps(mask)); }
};

template <int width>
struct Row;
template <>
struct Row<4> {
  using type = Avx4;
};
template <>
struct Row<8> {
  using type = Avx8;
};
template <>
struct Row<16> {
  using type = Twice<Avx8, 8>;
};

struct AvxSimd : LaneByLane {
  template <int width>
  using Floats = typename Row<width>::type;
};

}  // namespace

const WideKernelSet& wide_kernels_avx2() { return kernel_set<AvxSimd>(); }

}  // namespace etendue
#endif
