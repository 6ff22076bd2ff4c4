#include "accel/bvh/build/small_sweep.h"

#include "accel/kernels/simd_bounds.h"

#include <bit>

namespace etendue {

namespace {

using Keys = FourUnsigned;  // of the x, y and z axis

constexpr std::uint32_t sorted_size = 16;  // of the largest network
constexpr std::uint32_t index_mask = sorted_size - 1;
static_assert(small_sweep_size <= sorted_size);

inline void compare_exchange(Keys& a, Keys& b) {
  const Keys low = a < b ? a : b, high = a < b ? b : a;
  a = low;
  b = high;
}

// Batcher's odd-even merge of two sorted halves, of every `stride`th of `count` keys.
template <int count, int stride>
inline void merge_halves(Keys* keys) {
  if constexpr (2 * stride < count) {
    merge_halves<count, 2 * stride>(keys);
    merge_halves<count, 2 * stride>(keys + stride);
    for (int i = stride; i + stride < count; i += 2 * stride) compare_exchange(keys[i], keys[i + stride]);
  } else {
    compare_exchange(keys[0], keys[stride]);
  }
}

template <int count>
inline void sort_network(Keys* keys) {
  if constexpr (count > 1) {
    sort_network<count / 2>(keys);
    sort_network<count / 2>(keys + count / 2);
    merge_halves<count, 1>(keys);
  }
}

// The centre's bits, in the order of the floats, with the item's index in place of the last four.
Keys sort_keys(const BuildItem& item, std::uint32_t index) {
  const auto bits = reinterpret_cast<Keys>(SimdBounds(item.bounds).centre());
  const Keys negative = (bits >> 31) * 0xffffffffu;
  return ((bits ^ (negative | 0x80000000u)) & ~index_mask) | index;
}

// The cost of the best cut so far, then its distance from the middle, axis and position: the least of these is the best cut.
// Costs are not negative, so their bits sort as they do, with infinities and NaNs last.
std::uint64_t candidate(float cost, std::uint32_t from_middle, std::uint32_t axis, std::uint32_t position) {
  return std::uint64_t{std::bit_cast<std::uint32_t>(cost)} << 32 | from_middle << 16 | axis << 8 | position;
}

}  // namespace

SmallCut sweep_small(const BuildItem* items, std::uint32_t count) {
  if (count == 2) return {SimdBounds(items[0].bounds).half_area() + SimdBounds(items[1].bounds).half_area(), 1, {0, 1}};
  Keys keys[sorted_size];
  for (std::uint32_t i = 0; i < count; ++i) keys[i] = sort_keys(items[i], i);
  const std::uint32_t padded = std::bit_ceil(count);
  for (std::uint32_t i = count; i < padded; ++i) keys[i] = Keys{} - 1;
  if (padded == 16)
    sort_network<16>(keys);
  else if (padded == 8)
    sort_network<8>(keys);
  else
    sort_network<4>(keys);

  std::uint64_t best = ~std::uint64_t{0};
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    std::uint8_t order[small_sweep_size];
    for (std::uint32_t i = 0; i < count; ++i) order[i] = keys[i][axis] & index_mask;
    float right_area[small_sweep_size];
    SimdBounds right, left;
    for (std::uint32_t i = count - 1; i > 0; --i) {
      right.extend(items[order[i]].bounds);
      right_area[i] = right.half_area();
    }
    for (std::uint32_t i = 1; i < count; ++i) {
      left.extend(items[order[i - 1]].bounds);
      const float cost = left.half_area() * static_cast<float>(i) + right_area[i] * static_cast<float>(count - i);
      const std::uint32_t twice = 2 * i;
      best = std::min(best, candidate(cost, twice > count ? twice - count : count - twice, axis, i));
    }
  }
  SmallCut cut;
  cut.cost = std::bit_cast<float>(static_cast<std::uint32_t>(best >> 32));
  cut.left = best & 0xff;
  const std::uint32_t axis = best >> 8 & 0xff;
  for (std::uint32_t i = 0; i < count; ++i) cut.order[i] = keys[i][axis] & index_mask;
  return cut;
}

}  // namespace etendue
