#include "accel/points/cell_size.h"

#include "framework/core/elementary.h"
#include "framework/core/parallel.h"
#include "framework/core/rng.h"

#include <tbb/parallel_reduce.h>

#include <atomic>
#include <bit>

namespace etendue {

namespace {

// About how many cells of the given size hold points: each sets the bit its hash falls on, and the number of bits that stay
// clear tells how many cells there were (linear counting). Bits are set, never cleared, so threads may do it in any order.
class OccupiedCells {
 public:
  explicit OccupiedCells(std::size_t points) : words_(std::bit_ceil(points / 16 + 16)) {}

  double count(std::span<const vec3> points, const vec3& origin, float size) {
    for (auto& word : words_) word.store(0, std::memory_order_relaxed);
    const std::size_t mask = words_.size() - 1;
    parallel_for(points.size(), 1 << 14, [&](std::size_t i) {
      if (!is_finite(points[i])) return;
      const vec3 cell = glm::min((points[i] - origin) / size, vec3(1 << 21));
      const std::uint64_t hash = mix_bits(static_cast<std::uint64_t>(cell.x) << 42 | static_cast<std::uint64_t>(cell.y) << 21 |
                                          static_cast<std::uint64_t>(cell.z));
      std::atomic<std::uint64_t>& word = words_[hash >> 6 & mask];
      const std::uint64_t bit = std::uint64_t{1} << (hash & 63);
      if (!(word.load(std::memory_order_relaxed) & bit)) word.fetch_or(bit, std::memory_order_relaxed);
    });
    std::size_t set = 0;
    for (const auto& word : words_) set += static_cast<std::size_t>(std::popcount(word.load(std::memory_order_relaxed)));
    const double bits = 64.0 * static_cast<double>(words_.size());
    return -bits * math::log1p(-std::min(static_cast<double>(set), bits - 1) / bits);
  }

 private:
  std::vector<std::atomic<std::uint64_t>> words_;
};

}  // namespace

// The first guess spreads the points over the surface of their bounds; two corrections bring the mean near the aim.
float cell_size_for(std::span<const vec3> points, const Bounds& bounds, float points_per_cell, float smallest) {
  const float count = static_cast<float>(points.size()), largest = std::max(max_component(bounds.diagonal()), smallest);
  float size = std::clamp(std::sqrt(2 * bounds.half_area() * points_per_cell / count), smallest, largest);
  OccupiedCells occupied(points.size());
  for (int round = 0; round < 2; ++round) {
    const float mean = count / static_cast<float>(std::max(1.0, occupied.count(points, bounds.lower, size)));
    const float corrected = std::clamp(size * std::sqrt(points_per_cell / mean), smallest, largest);
    const bool near = mean > 0.7f * points_per_cell && mean < 1.4f * points_per_cell;
    if (near || corrected == size) break;
    size = corrected;
  }
  return size;
}

}  // namespace etendue
