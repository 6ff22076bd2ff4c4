#include "accel/bvh/build/morton_order.h"

#include "accel/kernels/simd_bounds.h"
#include "framework/core/check.h"
#include "framework/core/isa.h"

#include <array>
#include <bit>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

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

// Stable radix sort by bits [shift, 64), 28 <= shift, by blocks whose counts are summed up per digit.
class RadixSort {
 public:
  RadixSort(UninitialisedArray<std::uint64_t>& keys, std::size_t size, int shift)
      : keys_(keys),
        moved_(uninitialised_on_huge_pages<std::uint64_t>(size)),
        size_(size),
        block_size_(std::max(grain, (size + max_blocks - 1) / max_blocks)),
        counts_((size + block_size_ - 1) / block_size_) {
    for (const int digit : {0, 1, 2}) pass(shift + digit * bits_per_digit);
  }

 private:
  static constexpr int bits_per_digit = 12;
  static constexpr std::size_t grain = 1 << 14, max_blocks = 32, digits = 1 << bits_per_digit;

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
template <class ValueAt>
std::uint32_t first_from(std::uint32_t begin, std::uint32_t end, std::uint64_t bound, const ValueAt& value_at) {
  std::uint32_t below = begin;
  for (std::uint32_t count = end - begin; count > 1;) {
    const std::uint32_t half = count / 2;
    below = value_at(below + half) < bound ? below + half : below;
    count -= half;
  }
  return below + 1;
}

// A lower bound of the first value that has the highest bit in which the two differ.
std::uint64_t bound_between(std::uint64_t first, std::uint64_t last) { return last & ~(std::bit_floor(first ^ last) - 1); }

}  // namespace

void MortonKeyWriter::write() {
  for (std::size_t i = begin; i < end; ++i)
    if (points[i].counts != 0) *keys++ = (2 * code(points[i].position) & ~index_mask) | i;
}

#if defined(__x86_64__)
[[gnu::target("bmi2")]] void MortonKeyWriter::write_with_pdep() {
  constexpr std::uint64_t every_third = 0x2492492492492492;  // of a key: one bit above those of the code
  for (std::size_t i = begin; i < end; ++i) {
    if (points[i].counts == 0) continue;
    const FourUnsigned cell = code.cell(points[i].position);
    const std::uint64_t bits =
        _pdep_u64(cell[0], 4 * every_third) | _pdep_u64(cell[1], 2 * every_third) | _pdep_u64(cell[2], every_third);
    *keys++ = (bits & ~index_mask) | i;
  }
}
bool MortonKeyWriter::has_pdep() {
  static const bool has = __builtin_cpu_supports("bmi2") && !__builtin_cpu_is("znver1") && !__builtin_cpu_is("znver2");
  return has && chosen_isa() >= Isa::avx2;
}
#else
void MortonKeyWriter::write_with_pdep() { write(); }
bool MortonKeyWriter::has_pdep() { return false; }
#endif

MortonCode::MortonCode(const Bounds& points) : origin_(four(0.5f * points.lower)) {
  // Halves of coordinates have finite differences. The scale is a little below the number of cells, so that the upper end falls
  // into the last one; an extent that is zero or too small to divide by has one cell.
  const float extent = max_component(0.5f * points.upper - 0.5f * points.lower);
  scale_ = static_cast<float>(1 << bits_per_axis) * (1 - 1e-6f) / extent;
  if (!(scale_ < infinity)) scale_ = 0;
}

// The upper 32 bits hold the upper 11 bits of x and y and the upper 10 of z, the lower 31 the others.
std::uint64_t MortonCode::operator()(const vec3& point) const {
  const FourUnsigned all = cell(point), upper = spread(all >> FourUnsigned{10, 10, 11, 0}),
                     lower = spread(all & FourUnsigned{0x3ff, 0x3ff, 0x7ff, 0});
  const std::uint64_t upper_bits = upper[0] << 1 | upper[1] | upper[2] << 2,
                      lower_bits = lower[0] << 2 | lower[1] << 1 | lower[2];
  return upper_bits << 31 | lower_bits;
}

void MortonOrder::sort() {
  Bounds bounds;
  for (Chunk& chunk : chunks_) {
    bounds.extend(chunk.bounds);
    size_ += std::exchange(chunk.size, size_);  // then: the points before it
  }
  code_ = MortonCode(bounds);
  keys_ = uninitialised_on_huge_pages<std::uint64_t>(size_);
  if (size_ == 0) return;
  CHECK_LE(chunks_.back().end, std::size_t{1} << 31);
  index_mask_ = std::bit_ceil(chunks_.back().end) - 1;
  radix_shift_ = std::max(28, std::popcount(index_mask_));
  parallel_for(chunks_.size(), 1, [&](std::size_t c) {
    const Chunk& chunk = chunks_[c];
    MortonKeyWriter writer{points_.get(), chunk.begin, chunk.end, code_, index_mask_, keys_.get() + chunk.size};
    if (MortonKeyWriter::has_pdep())
      writer.write_with_pdep();
    else
      writer.write();
  });
  RadixSort(keys_, size_, radix_shift_);
  sort_equal_runs();
}

void MortonOrder::sort_equal_runs() {
  const std::uint64_t* const keys = keys_.get();
  const auto same = [=, this](std::size_t a, std::size_t b) { return keys[a] >> radix_shift_ == keys[b] >> radix_shift_; };
  std::vector<std::uint32_t> begins{0};  // about a chunk apart, at the beginnings of runs
  for (std::uint32_t i = chunk_size; i < size_; i += chunk_size) {
    while (i < size_ && same(i - 1, i)) ++i;
    begins.push_back(i);
  }
  begins.push_back(size_);
  parallel_for(begins.size() - 1, 1, [&](std::size_t c) {
    sort_keys(begins[c], begins[c + 1]);
    sort_equal_keys(begins[c], begins[c + 1]);
  });
}

// Sorts by insertion, as few are out of order; a run that is long and in no order is sorted by comparison.
void MortonOrder::sort_keys(std::uint32_t begin, std::uint32_t end) {
  std::uint64_t* const keys = keys_.get();
  constexpr std::uint32_t few = 16;
  for (std::uint32_t i = begin + 1; i < end; ++i) {
    const std::uint64_t key = keys[i];
    if (keys[i - 1] < key) [[likely]]
      continue;
    std::uint32_t place = i;
    for (const std::uint32_t last = i - std::min(i - begin, few); place > last && keys[place - 1] > key; --place)
      keys[place] = keys[place - 1];
    keys[place] = key;
    if (place + few > i) continue;
    std::uint32_t first = place, next = i + 1;
    const auto same = [=, this](std::uint32_t a) { return keys[a] >> radix_shift_ == key >> radix_shift_; };
    while (first > begin && same(first - 1)) --first;
    while (next < end && same(next)) ++next;
    std::sort(keys + first, keys + next);
    i = next - 1;
  }
}

// Sorts runs of keys that differ in their indices only by the rest of the code. Many are of one point, and in order: the halves
// of a rectangle share a centre.
void MortonOrder::sort_equal_keys(std::uint32_t begin, std::uint32_t end) {
  const auto equal = [&](std::uint32_t place) { return ((keys_[place - 1] ^ keys_[place]) & ~index_mask_) == 0; };
  const auto point = [&](std::uint32_t place) { return points_[index(place)].position; };
  for (std::uint32_t i = begin + 1; i < end; ++i) {
    if (!equal(i) || point(i - 1) == point(i)) continue;
    std::uint32_t first = i - 1, next = i + 1;
    while (first > begin && equal(first)) --first;
    while (next < end && equal(next)) ++next;
    sort_by_rest(first, next);
    i = next - 1;
  }
}

void MortonOrder::sort_by_rest(std::uint32_t begin, std::uint32_t end) {
  std::uint64_t* const keys = keys_.get();
  if (end - begin == 2) {
    if (rest(begin) > rest(begin + 1)) std::swap(keys[begin], keys[begin + 1]);
    return;
  }
  std::vector<std::uint64_t> run(end - begin);  // the rest, then the index
  for (std::uint32_t i = begin; i < end; ++i) run[i - begin] = rest(i) << 32 | index(i);
  std::sort(run.begin(), run.end());
  const std::uint64_t code = keys[begin] & ~index_mask_;
  for (std::uint32_t i = begin; i < end; ++i) keys[i] = code | static_cast<std::uint32_t>(run[i - begin]);
}

std::uint32_t MortonOrder::cut(std::uint32_t begin, std::uint32_t end) const {
  const std::uint64_t* const keys = keys_.get();
  const std::uint64_t first = keys[begin], last = keys[end - 1];
  if ((first | index_mask_) != (last | index_mask_))
    return first_from(begin, end, bound_between(first, last), [=](std::uint32_t i) { return keys[i]; });
  const std::uint64_t first_rest = rest(begin), last_rest = rest(end - 1);
  if (first_rest == last_rest) return begin + (end - begin) / 2;
  return first_from(begin, end, bound_between(first_rest, last_rest), [&](std::uint32_t i) { return rest(i); });
}

MortonOrder sort_by_morton_code(BuildItems& items) {
  MortonOrder order(items.size(), [&](std::size_t i) { return MortonPoint{items[i].bounds.centre()}; });
  BuildItems sorted(items.size());
  constexpr std::size_t grain = 1 << 14;
  parallel_for(items.size(), grain, [&](std::size_t i) { sorted[i] = items[order.index(static_cast<std::uint32_t>(i))]; });
  items = std::move(sorted);
  return order;
}

}  // namespace etendue
