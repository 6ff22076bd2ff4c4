// Points along a space-filling curve: sorted by their Morton codes ([Morton1966]; for trees first by [Lauterbach2009]).
//
// A code has 63 bits, 21 per axis, of a cube around the points: the first cut is then across the longest axis, whatever the
// scene's shape. The sort is a radix sort by the upper 32 bits; only runs that are equal in these are sorted by the other 31.
// Equal codes keep the order of the points. Parallel (oneTBB), with the same result at any thread count, since a stable order
// is unique.
#pragma once

#include "accel/ray/binary_tree.h"
#include "accel/ray/four_floats.h"
#include "framework/core/huge_pages.h"
#include "framework/core/parallel.h"

namespace etendue {

struct alignas(16) MortonPoint {
  vec3 position;
  std::uint32_t counts = 1;  // 0: left out
};

// The 63-bit codes of a cube around some points.
class MortonCode {
 public:
  MortonCode() = default;
  explicit MortonCode(const Bounds& points);

  std::uint32_t upper(const vec3& point) const;  // bits 31 to 62
  std::uint32_t lower(const vec3& point) const;  // bits 0 to 30

 private:
  FourUnsigned cell(const vec3& point) const {
    return (FourUnsigned) __builtin_convertvector((0.5f * four(point) - origin_) * scale_, FourInts);
  }

  FourFloats origin_{};
  float scale_ = 0;
};

class MortonOrder {
 public:
  // `point(i)`, a MortonPoint, for i < count.
  template <class Point>
  MortonOrder(std::size_t count, const Point& point)
      : chunks_((count + chunk_size - 1) / chunk_size), points_(uninitialised_on_huge_pages<MortonPoint>(count)) {
    parallel_for(chunks_.size(), 1, [&](std::size_t c) {
      Chunk chunk{.begin = c * chunk_size, .end = std::min(count, (c + 1) * chunk_size)};
      FourFloats lower = FourFloats{} + infinity, upper = -lower;
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        points_[i] = point(i);
        if (points_[i].counts == 0) continue;
        ++chunk.size;
        lower = smaller(four(points_[i].position), lower);
        upper = larger(four(points_[i].position), upper);
      }
      chunk.bounds = {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
      chunks_[c] = chunk;
    });
    sort();
  }

  std::uint32_t size() const { return size_; }  // of the points that count
  // Of the point at a place in the order.
  std::uint32_t index(std::uint32_t place) const { return static_cast<std::uint32_t>(keys_[place]); }
  // Where the highest bit in which the codes of a run of two or more differ changes: the first place behind. The middle of a
  // run of equal codes.
  std::uint32_t cut(std::uint32_t begin, std::uint32_t end) const;

 private:
  static constexpr std::size_t chunk_size = 1 << 13;

  struct Chunk {
    std::size_t begin = 0, end = 0;
    std::uint32_t size = 0;  // points that count
    Bounds bounds{};
  };

  void sort();
  void sort_equal_runs();
  std::uint32_t lower(std::uint64_t key) const { return code_.lower(points_[static_cast<std::uint32_t>(key)].position); }

  std::vector<Chunk> chunks_;
  UninitialisedArray<MortonPoint> points_;
  MortonCode code_;
  std::uint32_t size_ = 0;
  UninitialisedArray<std::uint64_t> keys_;  // upper 32 bits of the code, index of the point
};

// Sorts the items by the codes of their boxes' centres.
MortonOrder sort_by_morton_code(std::vector<BuildItem>& items);

}  // namespace etendue
