#include "accel/ray/morton_order.h"

#include "framework/core/huge_pages.h"
#include "framework/core/parallel.h"

#include <tbb/parallel_reduce.h>

#include <array>

namespace etendue {

namespace {

constexpr int bits_per_axis = 21;
constexpr std::size_t grain = 1 << 14;

Bounds centre_bounds(std::span<const BuildItem> items) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, items.size(), grain), Bounds(),
      [&](const auto& range, Bounds bounds) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) bounds.extend(items[i].bounds.centre());
        return bounds;
      },
      [](Bounds a, const Bounds& b) {
        a.extend(b);
        return a;
      });
}

// The 21 low bits of x, each followed by two zeros.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffff;
  x = (x | x << 16) & 0x001f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

class MortonCode {
 public:
  explicit MortonCode(const Bounds& centres) : origin_(0.5f * centres.lower) {
    // Halves of coordinates, whose differences are finite. A little below the number of cells, so that the upper end falls into
    // the last one; an extent that is zero or too small to divide by has one cell.
    const float extent = max_component(0.5f * centres.upper - origin_);
    scale_ = static_cast<float>(1 << bits_per_axis) * (1 - 1e-6f) / extent;
    if (!(scale_ < infinity)) scale_ = 0;
  }

  std::uint64_t operator()(const vec3& centre) const {
    const vec3 cell = (0.5f * centre - origin_) * scale_;
    return spread(static_cast<std::uint32_t>(cell.x)) << 2 | spread(static_cast<std::uint32_t>(cell.y)) << 1 |
           spread(static_cast<std::uint32_t>(cell.z));
  }

 private:
  vec3 origin_;
  float scale_;
};

// Stable radix sort by bits [32, 64), by blocks whose counts are summed up per digit.
class RadixSort {
 public:
  explicit RadixSort(std::vector<std::uint64_t>& keys)
      : keys_(keys), moved_(keys.size()), block_size_(std::max(grain, (keys.size() + max_blocks - 1) / max_blocks)) {
    counts_.resize((keys.size() + block_size_ - 1) / block_size_);
    for (const int shift : {32, 43, 54}) pass(shift);
  }

 private:
  static constexpr std::size_t max_blocks = 32, digits = 1 << 11;

  template <class Body>
  void each_key(std::size_t block, const Body& body) {
    const std::size_t end = std::min(keys_.size(), (block + 1) * block_size_);
    for (std::size_t i = block * block_size_; i < end; ++i) body(keys_[i]);
  }

  void pass(int shift) {
    const auto digit = [shift](std::uint64_t key) { return key >> shift & (digits - 1); };
    parallel_for(counts_.size(), 1, [&](std::size_t block) {
      counts_[block].fill(0);
      each_key(block, [&](std::uint64_t key) { ++counts_[block][digit(key)]; });
    });
    std::uint32_t sum = 0;
    for (std::size_t d = 0; d < digits; ++d)
      for (auto& counts : counts_) sum += std::exchange(counts[d], sum);
    parallel_for(counts_.size(), 1, [&](std::size_t block) {
      each_key(block, [&](std::uint64_t key) { moved_[counts_[block][digit(key)]++] = key; });
    });
    keys_.swap(moved_);
  }

  std::vector<std::uint64_t>& keys_;
  std::vector<std::uint64_t> moved_;
  std::size_t block_size_;
  std::vector<std::array<std::uint32_t, digits>> counts_;  // by block; then where its next key of a digit goes
};

// Where the upper halves are equal, sorts by the lower ones.
void sort_runs(std::vector<std::uint64_t>& keys, const std::vector<std::uint32_t>& lower) {
  for (std::size_t begin = 0, end; begin < keys.size(); begin = end) {
    for (end = begin + 1; end < keys.size() && keys[end] >> 32 == keys[begin] >> 32;) ++end;
    if (end - begin == 1) continue;
    std::sort(keys.begin() + begin, keys.begin() + end, [&](std::uint64_t a, std::uint64_t b) {
      const auto i = static_cast<std::uint32_t>(a), j = static_cast<std::uint32_t>(b);
      return lower[i] < lower[j] || (lower[i] == lower[j] && i < j);
    });
  }
}

}  // namespace

std::vector<std::uint64_t> sort_by_morton_code(std::vector<BuildItem>& items) {
  const MortonCode code(centre_bounds(items));
  std::vector<std::uint64_t> keys(items.size());   // upper 32 bits of the code, index of the item
  std::vector<std::uint32_t> lower(items.size());  // the other 31 bits
  parallel_for(items.size(), grain, [&](std::size_t i) {
    const std::uint64_t c = code(items[i].bounds.centre());
    keys[i] = c >> 31 << 32 | i;
    lower[i] = c & 0x7fffffff;
  });
  RadixSort sort(keys);
  sort_runs(keys, lower);
  std::vector<BuildItem> sorted;
  resize_on_huge_pages(sorted, items.size());
  parallel_for(items.size(), grain, [&](std::size_t i) {
    const auto index = static_cast<std::uint32_t>(keys[i]);
    sorted[i] = items[index];
    keys[i] = keys[i] >> 32 << 31 | lower[index];
  });
  items = std::move(sorted);
  return keys;
}

}  // namespace etendue
