// Wide traversal with AVX2: eight lanes, children stacked by permutations from a table.
#include "accel/bvh/wide/wide_headers.h"

#if defined(__x86_64__)

#include "accel/bvh/build/binned_kernels.inl"
#include "accel/bvh/wide/wide_kernels.inl"

namespace etendue {

namespace {

// For each mask of eight lanes: the lanes set, in order, and then any.
constexpr auto lanes_set = [] {
  std::array<std::uint64_t, 256> lanes{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    int count = 0;
    for (std::uint64_t lane = 0; lane < 8; ++lane)
      if (mask >> lane & 1) lanes[mask] |= lane << 8 * count++;
  }
  return lanes;
}();

struct Avx2 : Simd<8> {
  using Simd<8>::stack_places;
  using Simd<8>::collect;

  [[gnu::always_inline]] static __m256i order_of(unsigned mask) {
    return _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(&lanes_set[mask])));
  }
  // Entries are not negative, so they order as integers; the lane stands in the last bits, which no order of visits misses.
  [[gnu::always_inline]] static __m256i keys(__m256 entries, int first) {
    const __m256i lanes = _mm256_add_epi32(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), _mm256_set1_epi32(first));
    return _mm256_or_si256(_mm256_and_si256(_mm256_castps_si256(entries), _mm256_set1_epi32(~15)), lanes);
  }
  // The least of eight, in each lane.
  [[gnu::always_inline]] static __m128i least(__m256i eight) {
    __m128i four = _mm_min_epi32(_mm256_castsi256_si128(eight), _mm256_extracti128_si256(eight, 1));
    four = _mm_min_epi32(four, _mm_shuffle_epi32(four, _MM_SHUFFLE(1, 0, 3, 2)));
    return _mm_min_epi32(four, _mm_shuffle_epi32(four, _MM_SHUFFLE(2, 3, 0, 1)));
  }
  [[gnu::always_inline]] static __m256i without(__m256i keys, __m256i least) {
    return _mm256_or_si256(keys, _mm256_srli_epi32(_mm256_cmpeq_epi32(keys, least), 1));
  }
  template <int width, class Lanes>
  [[gnu::always_inline]] static NearestTwo nearest_two(const Lanes& entries) {
    if constexpr (width == 4) {
      return Simd<8>::nearest_two<width>(entries);
    } else {
      __m256i low, high;
      if constexpr (width == 16) {
        low = keys(entries.low.v, 0);
        high = keys(entries.high.v, 8);
      } else {
        low = high = keys(entries.v, 0);
      }
      const __m128i first = least(_mm256_min_epi32(low, high));
      const __m256i taken = _mm256_broadcastd_epi32(first);
      const __m128i second = least(_mm256_min_epi32(without(low, taken), without(high, taken)));
      return {_mm_cvtsi128_si32(first) & (width - 1), _mm_cvtsi128_si32(second) & (width - 1),
              _mm_cvtss_f32(_mm_castsi128_ps(_mm_andnot_si128(_mm_set1_epi32(15), second)))};
    }
  }

  static Waiting* stack_eight(const WideRef* children, __m256 entries, unsigned lanes, Waiting* top) {
    const __m256i order = order_of(lanes);
    const __m256i places = _mm256_permutevar8x32_epi32(_mm256_load_si256(reinterpret_cast<const __m256i*>(children)), order);
    const __m256i keys = _mm256_permutevar8x32_epi32(_mm256_castps_si256(entries), order);
    const __m256i low = _mm256_unpacklo_epi32(places, keys), high = _mm256_unpackhi_epi32(places, keys);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(top), _mm256_permute2x128_si256(low, high, 0x20));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(top + 4), _mm256_permute2x128_si256(low, high, 0x31));
    return top + std::popcount(lanes);
  }
  static Waiting* stack_places(const WideNode<8>& node, const Floats<8>& entries, unsigned lanes, Waiting* top) {
    return stack_eight(node.children, entries.v, lanes, top);
  }
  static Waiting* stack_places(const WideNode<16>& node, const Floats<16>& entries, unsigned lanes, Waiting* top) {
    top = stack_eight(node.children, entries.low.v, lanes & 0xff, top);
    return stack_eight(node.children + 8, entries.high.v, lanes >> 8, top);
  }
  static WaitingAny* stack_eight(const WideRef* children, unsigned lanes, WaitingAny* top) {
    _mm256_storeu_si256(
        reinterpret_cast<__m256i*>(top),
        _mm256_permutevar8x32_epi32(_mm256_load_si256(reinterpret_cast<const __m256i*>(children)), order_of(lanes)));
    return top + std::popcount(lanes);
  }
  static WaitingAny* stack_places(const WideNode<8>& node, unsigned lanes, WaitingAny* top) {
    return stack_eight(node.children, lanes, top);
  }
  static WaitingAny* stack_places(const WideNode<16>& node, unsigned lanes, WaitingAny* top) {
    return stack_eight(node.children + 8, lanes >> 8, stack_eight(node.children, lanes & 0xff, top));
  }
  using Simd<8>::leaves;
  static unsigned leaves(const WideNode<8>& node) {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_load_ps(reinterpret_cast<const float*>(node.children))));
  }
  static unsigned leaves(const WideNode<16>& node) {
    const auto* p = reinterpret_cast<const float*>(node.children);
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_load_ps(p)) | _mm256_movemask_ps(_mm256_load_ps(p + 8)) << 8);
  }
  static std::uint32_t collect(const std::uint32_t* met, const std::uint32_t* ids, std::uint32_t count, int child,
                               std::uint32_t* to) {
    const __m128i shift = _mm_cvtsi32_si128(31 - child);
    std::uint32_t size = 0;
    for (std::uint32_t i = 0; i < count; i += 8) {
      const auto mask = static_cast<unsigned>(_mm256_movemask_ps(
          _mm256_castsi256_ps(_mm256_sll_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(met + i)), shift))));
      _mm256_storeu_si256(
          reinterpret_cast<__m256i*>(to + size),
          _mm256_permutevar8x32_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(ids + i)), order_of(mask)));
      size += static_cast<std::uint32_t>(std::popcount(mask));
    }
    return size;
  }
};

}  // namespace

const WideKernelSet& wide_kernels_avx2() { return kernel_set<Avx2>(); }
const BinnedKernels& binned_kernels_avx2() { return binned_kernels_here; }

}  // namespace etendue

#endif
