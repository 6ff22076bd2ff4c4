// Wide traversal with AVX-512: sixteen lanes, children stacked by compression.
#include "accel/ray/wide_headers.h"

#if defined(__x86_64__)

#include "accel/ray/simd_lanes.inl"
#include "accel/ray/wide_traversal.inl"

namespace etendue {

namespace {

struct Avx512 : Simd<16> {
  using Simd<16>::stack_places;

  template <int width, class Lanes>
  static int nearest(const Lanes& entries, unsigned met) {
    if constexpr (width != 16) {
      return Simd<16>::nearest<width>(entries, met);
    } else {
      const __m512 candidates = _mm512_mask_mov_ps(_mm512_set1_ps(infinity), static_cast<__mmask16>(met), entries.v);
      const __m512 least = _mm512_set1_ps(_mm512_reduce_min_ps(candidates));
      return std::countr_zero<unsigned>(_mm512_mask_cmp_ps_mask(static_cast<__mmask16>(met), candidates, least, _CMP_EQ_OQ));
    }
  }

  // References and entries compressed, then interleaved into (reference, entry) pairs.
  static Waiting* stack_places(const WideNode<16>& node, const Lanes16& entries, unsigned lanes, Waiting* top) {
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

const WideKernelSet& wide_kernels_avx512() { return kernel_set<Avx512>(); }

}  // namespace etendue

#endif
