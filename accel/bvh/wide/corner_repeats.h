// How far back, along the corners of triangles in an order, each corner's vertex was last seen. So a few SIMD comparisons tell
// how many different vertices a run of triangles has, and which slot of a pack (shared_pack.h) each corner is.
//
// Vertices are told apart by position, not by index: readers of meshes often repeat one. A scan keeps only what a pack can
// reach back to, in a small open hash table; where that has let a vertex slip, it counts as a new one, which costs a slot of a
// pack and no more.
#pragma once

#include "accel/kernels/shared_pack.h"
#include "framework/core/huge_pages.h"

#include <array>
#include <bit>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace etendue {

class CornerRepeats {
 public:
  static constexpr std::uint32_t reach = 3 * SharedPack::lanes;  // corners of the longest run

  CornerRepeats() = default;
  explicit CornerRepeats(std::size_t triangles) : distances_(uninitialised_on_huge_pages<std::uint8_t>(3 * triangles)) {}

  // Corners since a corner's vertex was last seen, by triangle and corner; `never` or more than can be of use where it was not.
  const std::uint8_t* operator[](std::size_t triangle) const { return &distances_[3 * triangle]; }

  // A bit per corner of a run of triangles that a pack may take, set where a vertex is the first of its kind in the run. What
  // lies at `end` of the order or behind it is not looked at.
  std::uint64_t first_seen(std::size_t triangle, std::uint32_t count, std::size_t end) const {
    std::uint8_t last[reach];
    const std::uint8_t* distances = (*this)[triangle];
    if (triangle + SharedPack::lanes > end) distances = std::copy_n(distances, 3 * count, last) - 3 * count;
    std::uint64_t first = 0;
#if defined(__SSE2__)
    __m128i place = _mm_setr_epi8(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    for (std::uint32_t k = 0; k < reach; k += 16, place = _mm_add_epi8(place, _mm_set1_epi8(16))) {
      const __m128i distance = _mm_loadu_si128(reinterpret_cast<const __m128i*>(distances + k));
      first |= std::uint64_t{static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_cmpgt_epi8(distance, place)))} << k;
    }
#else
    for (std::uint32_t k = 0; k < reach; ++k) first |= std::uint64_t{distances[k] > k} << k;
#endif
    return first & ((std::uint64_t{1} << 3 * count) - 1);
  }

  // Fills an empty pack with a run that it takes, beginning at place `triangle` of the order, whose first_seen is `first`.
  // `ids` differ. Answers the box of the vertices.
  Bounds fill(SharedPack& pack, const Geometry& geometry, std::span<const std::uint32_t> ids, std::span<const uvec3> corners,
              std::size_t triangle, std::uint64_t first) const;

  // Goes along a part of the order, triangle by triangle.
  class Scan {
   public:
    Scan(CornerRepeats& repeats, std::size_t first_triangle) : to_(&repeats.distances_[3 * first_triangle]) {}

    void add(const vec3& vertex) { *to_++ = distance(vertex); }

   private:
    struct alignas(16) Entry {
      std::uint32_t x = 0, y = 0, z = 0, place = 0;
    };
    static constexpr int table_bits = 10;

    std::uint8_t distance(const vec3& vertex) {
      const auto bits = std::bit_cast<std::array<std::uint32_t, 3>>(vertex);
      const Entry own{bits[0], bits[1], bits[2], place_++};
      const std::uint64_t hash = (own.x | std::uint64_t{own.y} << 32) * 0x9e3779b97f4a7c15u ^ own.z * 0xc2b2ae3d27d4eb4fu;
      std::uint64_t at = hash >> (64 - table_bits);
      // Whether a vertex is new is a toss-up, so no branch depends on it.
      std::uint64_t others = differ(own, table_[at]);
      while ((others & is_near(own, table_[at])) != 0) [[unlikely]] {
          at = (at + 1) % table_.size();
          others = differ(own, table_[at]);
        }
      const std::uint64_t back = (own.place - table_[at].place) | others;
      table_[at] = own;
      return static_cast<std::uint8_t>(std::min<std::uint64_t>(back, never));
    }
    // Returns all bits or none.
    static std::uint64_t is_near(const Entry& a, const Entry& b) {
      return 0 - ((std::uint64_t{a.place - b.place} - reach) >> 63);
    }
    // Returns some bit above those of `never`, or none.
    static std::uint64_t differ(const Entry& a, const Entry& b) {
      return std::uint64_t{(a.x ^ b.x) | (a.y ^ b.y) | (a.z ^ b.z)} << 16;
    }

    std::uint8_t* to_;
    std::uint32_t place_ = never;  // of the next corner; so that an empty entry is out of reach
    std::array<Entry, 1 << table_bits> table_{};
  };

 private:
  static constexpr std::uint8_t never = 127;

  UninitialisedArray<std::uint8_t> distances_;
};

}  // namespace etendue
