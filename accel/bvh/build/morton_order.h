// Points along a space-filling curve: sorted by their Morton codes ([Morton1966]; for trees first by [Lauterbach2009]).
//
// A code has 63 bits, 21 per axis, of a cube around the points: the first cut is then across the longest axis, whatever the
// scene's shape. A key of 64 bits is a point's index below as many bits of its code as find room. The sort is a radix sort by
// the upper bits of the keys, 36 at most; runs that are equal in these are sorted by the others, and by the rest of the code
// where that is not enough. Equal codes keep the order of the points. Parallel (oneTBB), with the same result at any thread
// count, since a stable order is unique.
#pragma once

#include "accel/bvh/build/binary_tree.h"
#include "accel/kernels/simd_bounds.h"
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

  std::uint64_t operator()(const vec3& point) const;

  // The number of the cell along each axis, which has 2^21 of them.
  FourUnsigned cell(const vec3& point) const {
    return (FourUnsigned) __builtin_convertvector((0.5f * four(point) - origin_) * scale_, FourInts);
  }

 private:
  FourFloats origin_{};
  float scale_ = 0;
};

// Writes the keys of the points that count, in their order: the upper bits of each one's code, and its index in `index_mask`.
struct MortonKeyWriter {
  const MortonPoint* points;
  std::size_t begin, end;
  MortonCode code;
  std::uint64_t index_mask;
  std::uint64_t* keys;

  void write();
  void write_with_pdep();  // the same, by an instruction that spreads bits as a mask says
  static bool has_pdep();  // where that is quick
};

class MortonOrder {
 public:
  // `point(i)`, a MortonPoint, for i < count.
  template <class Point>
  MortonOrder(std::size_t count, const Point& point)
      : chunks_((count + chunk_size - 1) / chunk_size), points_(uninitialised_on_huge_pages<MortonPoint>(count)) {
    parallel_for(chunks_.size(), 1, [&](std::size_t c) {
      Chunk chunk{.begin = c * chunk_size, .end = std::min(count, (c + 1) * chunk_size)};
      PointBounds bounds;
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        points_[i] = point(i);
        if (points_[i].counts == 0) continue;
        ++chunk.size;
        bounds.extend(four(points_[i].position));
      }
      chunk.bounds = bounds.get();
      chunks_[c] = chunk;
    });
    sort();
  }

  std::uint32_t size() const { return size_; }  // of the points that count
  // The index of the point at a place in the order.
  std::uint32_t index(std::uint32_t place) const { return static_cast<std::uint32_t>(keys_[place] & index_mask_); }
  // The first place of a run of two or more behind the change of the highest bit in which its codes differ; the middle of a run
  // of equal codes.
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
  void sort_keys(std::uint32_t begin, std::uint32_t end);
  void sort_equal_keys(std::uint32_t begin, std::uint32_t end);
  void sort_by_rest(std::uint32_t begin, std::uint32_t end);
  // The bits of a place's code that are not in its key.
  std::uint64_t rest(std::uint32_t place) const { return 2 * code_(points_[index(place)].position) & index_mask_; }

  std::vector<Chunk> chunks_;
  UninitialisedArray<MortonPoint> points_;
  MortonCode code_;
  std::uint32_t size_ = 0;
  int radix_shift_ = 0;                     // of the lowest bit by which keys are first sorted
  std::uint64_t index_mask_ = 0;            // of the bits of a key that are an index; the others are the code's upper ones
  UninitialisedArray<std::uint64_t> keys_;  // by place in the order
};

// Sorts the items by the codes of their boxes' centres.
MortonOrder sort_by_morton_code(BuildItems& items);

}  // namespace etendue
