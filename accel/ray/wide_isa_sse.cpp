// Wide traversal with SSE4.1: four lanes.
#include "accel/ray/wide_headers.h"

#if defined(__x86_64__)

#include "accel/ray/simd_compose.inl"
#include "accel/ray/wide_traversal.inl"

namespace etendue {
namespace {

struct Sse4 {
  __m128 v;

  static Sse4 load(const float* p) { return {_mm_load_ps(p)}; }
  static Sse4 set(float x) { return {_mm_set1_ps(x)}; }
  void store(float* p) const { _mm_store_ps(p, v); }
  friend Sse4 operator+(Sse4 a, Sse4 b) { return {_mm_add_ps(a.v, b.v)}; }
  friend Sse4 operator-(Sse4 a, Sse4 b) { return {_mm_sub_ps(a.v, b.v)}; }
  friend Sse4 operator*(Sse4 a, Sse4 b) { return {_mm_mul_ps(a.v, b.v)}; }
  friend Sse4 operator/(Sse4 a, Sse4 b) { return {_mm_div_ps(a.v, b.v)}; }
  friend Sse4 larger(Sse4 a, Sse4 b) { return {_mm_max_ps(a.v, b.v)}; }
  friend Sse4 smaller(Sse4 a, Sse4 b) { return {_mm_min_ps(a.v, b.v)}; }
  friend unsigned less(Sse4 a, Sse4 b) { return static_cast<unsigned>(_mm_movemask_ps(_mm_cmplt_ps(a.v, b.v))); }
  friend unsigned less_equal(Sse4 a, Sse4 b) { return static_cast<unsigned>(_mm_movemask_ps(_mm_cmple_ps(a.v, b.v))); }
  friend unsigned equal(Sse4 a, Sse4 b) { return static_cast<unsigned>(_mm_movemask_ps(_mm_cmpeq_ps(a.v, b.v))); }
};

template <int width>
struct Row {
  using type = Twice<typename Row<width / 2>::type, width / 2>;
};
template <>
struct Row<4> {
  using type = Sse4;
};

struct SseSimd : LaneByLane {
  template <int width>
  using Floats = typename Row<width>::type;
};

}  // namespace

const WideKernelSet& wide_kernels_sse() { return kernel_set<SseSimd>(); }

}  // namespace etendue
#endif
