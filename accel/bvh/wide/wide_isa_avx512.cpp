// Wide traversal with AVX-512: sixteen lanes, children stacked by compression.
#include "accel/bvh/wide/wide_headers.h"

#if defined(__x86_64__)

#include "accel/bvh/wide/wide_kernels.inl"

namespace etendue {

namespace {

struct Avx512 : Simd<16> {
  static constexpr bool streams_nearest = true;

  using Simd<16>::stack_places;
  using Simd<16>::collect;

  static std::uint32_t collect(const std::uint32_t* met, const std::uint32_t* ids, std::uint32_t count, int child,
                               std::uint32_t* to) {
    const __m512i bit = _mm512_set1_epi32(1 << child);
    std::uint32_t size = 0;
    for (std::uint32_t i = 0; i < count; i += 16) {
      const __mmask16 lanes = _mm512_test_epi32_mask(_mm512_loadu_si512(met + i), bit);
      _mm512_storeu_si512(to + size, _mm512_maskz_compress_epi32(lanes, _mm512_loadu_si512(ids + i)));
      size += static_cast<std::uint32_t>(std::popcount<unsigned>(lanes));
    }
    return size;
  }

  // The same with where the rays enter the child: `entries` by ray and child; `nearest` is the least.
  template <int width>
  static std::uint32_t collect(const std::uint32_t* met, const std::uint32_t* ids, const float* entries, std::uint32_t count,
                               int child, std::uint32_t* to, float* nears, float& nearest) {
    const __m512i bit = _mm512_set1_epi32(1 << child);
    const __m512i rows =
        _mm512_mullo_epi32(_mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15), _mm512_set1_epi32(width));
    __m512 least = _mm512_set1_ps(infinity);
    std::uint32_t size = 0;
    for (std::uint32_t i = 0; i < count; i += 16) {
      const __mmask16 lanes = _mm512_test_epi32_mask(_mm512_loadu_si512(met + i), bit);
      const __m512 entry = _mm512_mask_i32gather_ps(_mm512_set1_ps(infinity), lanes, rows, entries + i * width + child, 4);
      least = _mm512_min_ps(least, entry);
      _mm512_storeu_si512(to + size, _mm512_maskz_compress_epi32(lanes, _mm512_loadu_si512(ids + i)));
      _mm512_storeu_ps(nears + size, _mm512_maskz_compress_ps(lanes, entry));
      size += static_cast<std::uint32_t>(std::popcount<unsigned>(lanes));
    }
    nearest = _mm512_reduce_min_ps(least);
    return size;
  }

  // The least of sixteen, in each lane.
  static __m128i least(__m512i sixteen) {
    const __m256i eight = _mm256_min_epi32(_mm512_castsi512_si256(sixteen), _mm512_extracti64x4_epi64(sixteen, 1));
    __m128i four = _mm_min_epi32(_mm256_castsi256_si128(eight), _mm256_extracti128_si256(eight, 1));
    four = _mm_min_epi32(four, _mm_shuffle_epi32(four, _MM_SHUFFLE(1, 0, 3, 2)));
    return _mm_min_epi32(four, _mm_shuffle_epi32(four, _MM_SHUFFLE(2, 3, 0, 1)));
  }
  template <int width, class Lanes>
  static NearestTwo nearest_two(const Lanes& entries) {
    if constexpr (width != 16) {
      return Simd<16>::nearest_two<width>(entries);
    } else {
      // Entries are not negative, so they order as integers; the lane stands in the last bits, which no order of visits misses.
      const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
      const __m512i keys = _mm512_ternarylogic_epi32(_mm512_castps_si512(entries.v), _mm512_set1_epi32(15), lane, 0xba);
      const __m128i first = least(keys);
      const __m512i others = _mm512_mask_mov_epi32(keys, _mm512_cmpeq_epi32_mask(keys, _mm512_broadcastd_epi32(first)),
                                                   _mm512_set1_epi32(0x7fffffff));
      const __m128i second = least(others);
      return {_mm_cvtsi128_si32(first) & 15, _mm_cvtsi128_si32(second) & 15,
              _mm_cvtss_f32(_mm_castsi128_ps(_mm_andnot_si128(_mm_set1_epi32(15), second)))};
    }
  }

  using Simd<16>::leaves;
  static unsigned leaves(const WideNode<16>& node) { return _mm512_movepi32_mask(_mm512_load_si512(node.children)); }

  // Stored by halves, the upper ones only where there is anything: few stores then cross a line.
  static WaitingAny* stack_places(const WideNode<16>& node, unsigned lanes, WaitingAny* top) {
    const __m512i places = _mm512_maskz_compress_epi32(static_cast<__mmask16>(lanes), _mm512_load_si512(node.children));
    const int count = std::popcount(lanes);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(top), _mm512_castsi512_si256(places));
    if (count > 8) _mm256_storeu_si256(reinterpret_cast<__m256i*>(top + 8), _mm512_extracti64x4_epi64(places, 1));
    return top + count;
  }

  // Compresses references and entries, then interleaves them into (reference, entry) pairs.
  static Waiting* stack_places(const WideNode<16>& node, const Simd<16>::Floats<16>& entries, unsigned lanes, Waiting* top) {
    const auto mask = static_cast<__mmask16>(lanes);
    const __m512i places = _mm512_maskz_compress_epi32(mask, _mm512_load_si512(node.children));
    const __m512i keys = _mm512_maskz_compress_epi32(mask, _mm512_castps_si512(entries.v));
    const __m512i low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
    const __m512i pairs = _mm512_permutex2var_epi32(places, low, keys);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(top), _mm512_castsi512_si256(pairs));
    const int count = std::popcount(lanes);
    if (count > 4) _mm256_storeu_si256(reinterpret_cast<__m256i*>(top + 4), _mm512_extracti64x4_epi64(pairs, 1));
    if (count > 8)
      _mm512_storeu_si512(top + 8, _mm512_permutex2var_epi32(places, _mm512_add_epi32(low, _mm512_set1_epi32(8)), keys));
    return top + count;
  }
};

}  // namespace

const WideKernelSet& wide_kernels_avx512() { return kernel_set<Avx512>(); }

}  // namespace etendue

#endif
