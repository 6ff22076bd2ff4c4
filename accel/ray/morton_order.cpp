#include "accel/ray/morton_order.h"

#include "accel/ray/four_floats.h"

#include <array>
#include <bit>

namespace etendue {

namespace {

constexpr int bits_per_axis = 21;

// The 11 low bits of each, every one followed by two zeros.
FourUnsigned spread(FourUnsigned x) {
  x = (x | x << 16) & 0x070000ff;
  x = (x | x << 8) & 0x0700f00f;
  x = (x | x << 4) & 0x430c30c3;
  return (x | x << 2) & 0x49249249;
}

// Stable radix sort by bits [32, 64), by blocks whose counts are summed up per digit.
class RadixSort {
 public:
  RadixSort(UninitialisedArray<std::uint64_t>& keys, std::size_t size)
      : keys_(keys),
        moved_(uninitialised_on_huge_pages<std::uint64_t>(size)),
        size_(size),
        block_size_(std::max(grain, (size + max_blocks - 1) / max_blocks)),
        counts_((size + block_size_ - 1) / block_size_) {
    for (const int shift : {32, 43, 54}) pass(shift);
  }

 private:
  static constexpr std::size_t grain = 1 << 14, max_blocks = 32, digits = 1 << 11;

  template <class Body>
  void each_key(std::size_t block, const Body& body) {
    const std::uint64_t* const keys = keys_.get();
    const std::size_t end = std::min(size_, (block + 1) * block_size_);
    for (std::size_t i = block * block_size_; i < end; ++i) body(keys[i]);
  }

  void pass(int shift) {
    const auto digit = [shift](std::uint64_t key) { return key >> shift & (digits - 1); };
    parallel_for(counts_.size(), 1, [&](std::size_t block) {
      auto& counts = counts_[block];
      counts.fill(0);
      each_key(block, [&](std::uint64_t key) { ++counts[digit(key)]; });
    });
    std::uint32_t sum = 0;
    for (std::size_t d = 0; d < digits; ++d)
      for (auto& counts : counts_) sum += std::exchange(counts[d], sum);
    parallel_for(counts_.size(), 1, [&](std::size_t block) {
      auto& places = counts_[block];
      std::uint64_t* const moved = moved_.get();
      each_key(block, [&](std::uint64_t key) { moved[places[digit(key)]++] = key; });
    });
    keys_.swap(moved_);
  }

  UninitialisedArray<std::uint64_t>& keys_;
  UninitialisedArray<std::uint64_t> moved_;
  std::size_t size_, block_size_;
  std::vector<std::array<std::uint32_t, digits>> counts_;  // by block; then where its next key of a digit goes
};

// The first of the places in (begin, end) whose value, by `value_at`, is `bound` or more; values rise, the last is no less.
template <class Value, class ValueAt>
std::uint32_t first_from(std::uint32_t begin, std::uint32_t end, Value bound, const ValueAt& value_at) {
  std::uint32_t below = begin;
  for (std::uint32_t count = end - begin; count > 1;) {
    const std::uint32_t half = count / 2;
    below = value_at(below + half) < bound ? below + half : below;
    count -= half;
  }
  return below + 1;
}

// What the first code with the highest bit that differs is no less than.
std::uint32_t bound_between(std::uint32_t first, std::uint32_t last) { return last & ~(std::bit_floor(first ^ last) - 1); }

}  // namespace

MortonCode::MortonCode(const Bounds& points) : origin_(four(0.5f * points.lower)) {
  // Halves of coordinates, whose differences are finite. A little below the number of cells, so that the upper end falls into
  // the last one; an extent that is zero or too small to divide by has one cell.
  const float extent = max_component(0.5f * points.upper - 0.5f * points.lower);
  scale_ = static_cast<float>(1 << bits_per_axis) * (1 - 1e-6f) / extent;
  if (!(scale_ < infinity)) scale_ = 0;
}

// Of x and y the upper 11 bits, of z the upper 10, side by side.
std::uint32_t MortonCode::upper(const vec3& point) const {
  const FourUnsigned bits = spread(cell(point) >> FourUnsigned{10, 10, 11, 0});
  return bits[0] << 1 | bits[1] | bits[2] << 2;
}

std::uint32_t MortonCode::lower(const vec3& point) const {
  const FourUnsigned bits = spread(cell(point) & FourUnsigned{0x3ff, 0x3ff, 0x7ff, 0});
  return bits[0] << 2 | bits[1] << 1 | bits[2];
}

void MortonOrder::sort() {
  Bounds bounds;
  for (Chunk& chunk : chunks_) {
    bounds.extend(chunk.bounds);
    size_ += std::exchange(chunk.size, size_);  // then: the points before it
  }
  code_ = MortonCode(bounds);
  keys_ = uninitialised_on_huge_pages<std::uint64_t>(size_);
  parallel_for(chunks_.size(), 1, [&](std::size_t c) {
    const Chunk& chunk = chunks_[c];
    const MortonCode code = code_;
    std::uint64_t* key = keys_.get() + chunk.size;
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      if (points_[i].counts == 0) continue;
      *key++ = std::uint64_t{code.upper(points_[i].position)} << 32 | i;
    }
  });
  RadixSort(keys_, size_);
  sort_equal_runs();
}

// By the other bits, where the upper 32 are equal.
void MortonOrder::sort_equal_runs() {
  const auto same = [this](std::size_t a, std::size_t b) { return keys_[a] >> 32 == keys_[b] >> 32; };
  std::vector<std::size_t> begins{0};  // about a chunk apart, at the beginnings of runs
  for (std::size_t i = chunk_size; i < size_; i += chunk_size) {
    while (i < size_ && same(i - 1, i)) ++i;
    begins.push_back(i);
  }
  begins.push_back(size_);
  parallel_for(begins.size() - 1, 1, [&](std::size_t c) {
    std::vector<std::uint64_t> run;  // the other bits, then the index
    for (std::size_t begin = begins[c], next; begin < begins[c + 1]; begin = next) {
      for (next = begin + 1; next < begins[c + 1] && same(begin, next);) ++next;
      __builtin_prefetch(&points_[static_cast<std::uint32_t>(keys_[std::min<std::size_t>(next + 16, begins[c + 1] - 1)])]);
      if (next - begin == 1) continue;
      run.resize(next - begin);
      for (std::size_t i = begin; i < next; ++i)
        run[i - begin] = std::uint64_t{lower(keys_[i])} << 32 | static_cast<std::uint32_t>(keys_[i]);
      std::sort(run.begin(), run.end());
      const std::uint64_t upper = keys_[begin] >> 32 << 32;
      for (std::size_t i = begin; i < next; ++i) keys_[i] = upper | static_cast<std::uint32_t>(run[i - begin]);
    }
  });
}

std::uint32_t MortonOrder::cut(std::uint32_t begin, std::uint32_t end) const {
  const std::uint64_t* const keys = keys_.get();
  const auto first = static_cast<std::uint32_t>(keys[begin] >> 32), last = static_cast<std::uint32_t>(keys[end - 1] >> 32);
  if (first != last)
    return first_from(begin, end, std::uint64_t{bound_between(first, last)} << 32, [=](std::uint32_t i) { return keys[i]; });
  const std::uint32_t low_first = lower(keys[begin]), low_last = lower(keys[end - 1]);
  if (low_first == low_last) return begin + (end - begin) / 2;
  return first_from(begin, end, bound_between(low_first, low_last), [&](std::uint32_t i) { return lower(keys[i]); });
}

MortonOrder sort_by_morton_code(std::vector<BuildItem>& items) {
  MortonOrder order(items.size(), [&](std::size_t i) { return MortonPoint{items[i].bounds.centre()}; });
  auto sorted = std::vector<BuildItem>();
  resize_on_huge_pages(sorted, items.size());
  constexpr std::size_t grain = 1 << 14;
  parallel_for(items.size(), grain, [&](std::size_t i) { sorted[i] = items[order.index(static_cast<std::uint32_t>(i))]; });
  items = std::move(sorted);
  return order;
}

}  // namespace etendue
