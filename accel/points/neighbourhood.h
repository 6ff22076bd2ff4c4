// The rules that every point and record structure follows, so that their answers are the same bits.
#pragma once

#include "framework/query.h"

#include <array>
#include <bit>

#ifdef __SSE4_1__
#include <smmintrin.h>
#endif

namespace etendue {

inline float distance_squared(const vec3& point, const vec3& p) { return length_squared(point - p); }

// Queries that are not finite, and negative or NaN radii, find nothing; and nothing finds points that are not finite.
inline bool can_find(const vec3& p, float r) { return is_finite(p) && r >= 0; }

// r enlarged by the rounding error: no point with a float distance^2 <= r^2 lies farther than this along any axis.
inline float reach(float r) { return r * (1 + 8 * std::numeric_limits<float>::epsilon()) + 1e-22f; }

// By distance, then by id: the order of the bits of both, as no distance is negative.
inline bool is_nearer(const Neighbour& a, const Neighbour& b) {
  const auto key = [](const Neighbour& n) {
    return std::uint64_t{std::bit_cast<std::uint32_t>(n.distance_squared)} << 32 | n.id;
  };
  return key(a) < key(b);
}

// The k nearest of `found`, nearest first.
void keep_nearest(Neighbours& found, std::size_t k);

// Points as the structures place them in the order of their cells: a query reads runs of them.
struct PlacedPoint {
  vec3 position;
  std::uint32_t id;
};

// Finds those of the points it is shown that lie within a squared distance, until more than `most` (by less than a block). The
// comparison of distances is hardly predictable, so it advances an index instead of a branch; found points are collected and
// appended to `out` in blocks.
class PointFinder {
 public:
  PointFinder(const vec3& p, float limit, std::size_t most, Neighbours& out) : p_(p), limit_(limit), most_(most), out_(out) {}
  ~PointFinder() { flush(); }
  PointFinder(const PointFinder&) = delete;
  PointFinder& operator=(const PointFinder&) = delete;

  // Tests a run of points; false once more than `most` have been found.
  bool look(const PlacedPoint* begin, const PlacedPoint* end) {
    while (begin != end) {
      if (count_ + block > found_.size()) flush();
      const PlacedPoint* const stop = begin + std::min<std::ptrdiff_t>(end - begin, block);
      count_ = look_at_block(begin, stop, count_);
      begin = stop;
      if (out_.size() + count_ > most_) return false;
    }
    return true;
  }

 private:
  static constexpr std::size_t block = 64;

  std::size_t look_at_block(const PlacedPoint* begin, const PlacedPoint* end, std::size_t count) {
#ifdef __SSE4_1__
    const __m128 px = _mm_set1_ps(p_.x), py = _mm_set1_ps(p_.y), pz = _mm_set1_ps(p_.z), limit = _mm_set1_ps(limit_);
    for (; end - begin >= 4; begin += 4) {
      __m128 x = _mm_loadu_ps(&begin[0].position.x), y = _mm_loadu_ps(&begin[1].position.x);
      __m128 z = _mm_loadu_ps(&begin[2].position.x), ids = _mm_loadu_ps(&begin[3].position.x);
      _MM_TRANSPOSE4_PS(x, y, z, ids);
      x = _mm_sub_ps(x, px);
      y = _mm_sub_ps(y, py);
      z = _mm_sub_ps(z, pz);
      const __m128 d2 = _mm_add_ps(_mm_add_ps(_mm_mul_ps(x, x), _mm_mul_ps(y, y)), _mm_mul_ps(z, z));
      const auto near = static_cast<unsigned>(_mm_movemask_ps(_mm_cmple_ps(d2, limit)));
      const __m128 low = _mm_unpacklo_ps(ids, d2), high = _mm_unpackhi_ps(ids, d2);  // Neighbours, two and two
      _mm_storel_pi(reinterpret_cast<__m64*>(&found_[count]), low);
      count += near & 1;
      _mm_storeh_pi(reinterpret_cast<__m64*>(&found_[count]), low);
      count += near >> 1 & 1;
      _mm_storel_pi(reinterpret_cast<__m64*>(&found_[count]), high);
      count += near >> 2 & 1;
      _mm_storeh_pi(reinterpret_cast<__m64*>(&found_[count]), high);
      count += near >> 3;
    }
#endif
    for (; begin != end; ++begin) {
      const float d2 = distance_squared(begin->position, p_);
      found_[count] = {begin->id, d2};
      count += d2 <= limit_;
    }
    return count;
  }

  void flush() {
    out_.insert(out_.end(), found_.begin(), found_.begin() + static_cast<std::ptrdiff_t>(count_));
    count_ = 0;
  }

  vec3 p_;
  float limit_;
  std::size_t most_;
  Neighbours& out_;
  std::size_t count_ = 0;
  std::array<Neighbour, 256 + 1> found_;  // one more than fits: the last that is looked at, and not found
};

// The k nearest points so far, among those with squared distance <= limit: a heap in the caller's buffer with the farthest on
// top.
class NearestSoFar {
 public:
  NearestSoFar(std::size_t k, float limit, Neighbours& out) : k_(k), limit_(limit), out_(out) { out_.clear(); }

  bool full() const { return out_.size() == k_; }
  // Points farther than this cannot be among them; one at exactly this distance can, if its id is lower.
  float worst() const { return limit_; }

  void add(std::uint32_t id, float distance_squared) {
    if (!(distance_squared <= limit_)) return;
    const Neighbour found{id, distance_squared};
    if (!full()) {
      out_.push_back(found);
      if (full()) std::make_heap(out_.begin(), out_.end(), is_nearer);
    } else if (is_nearer(found, out_.front())) {
      replace_farthest(found);
    }
    if (full()) limit_ = out_.front().distance_squared;
  }
  // Call once, at the end: nearest first.
  void sort() { std::sort(out_.begin(), out_.end(), is_nearer); }

 private:
  void replace_farthest(const Neighbour& found) {
    std::size_t hole = 0;
    for (std::size_t child; (child = 2 * hole + 1) < k_; hole = child) {
      child += child + 1 < k_ && is_nearer(out_[child], out_[child + 1]);
      if (!is_nearer(found, out_[child])) break;
      out_[hole] = out_[child];
    }
    out_[hole] = found;
  }

  std::size_t k_;
  float limit_;
  Neighbours& out_;
};

inline constexpr std::size_t no_limit = std::numeric_limits<std::size_t>::max();

// `nearest` for structures that find by radius searches spheres of growing radius until one holds enough; then the nearest are
// all inside it. The first is the caller's, and the next radii follow from the density found so far.
// A sphere that holds far too many points (a dense cluster, seen from afar) is abandoned for one in between.
//
// `find(p, r, most, out)` is `within` that may stop, with false, once it has found more than `most`. `count`: of all points;
// `bounds` of these; `step`: the first radius, above 0.
template <class Structure>
void nearest_by_growing_balls(const Structure& structure, std::size_t count, const Bounds& bounds, float step, const vec3& p,
                              std::size_t k, float r_max, Neighbours& out) {
  const std::size_t wanted = std::min(k, count), most = 16 * wanted + 64;
  float too_small = 0, too_large = infinity;
  float r = std::min(glm::length(p - glm::clamp(p, bounds.lower, bounds.upper)) + step, r_max);
  for (;;) {
    if (!structure.find(p, r, most, out)) {
      too_large = r;
    } else {
      if (out.size() >= wanted || r >= r_max) break;
      too_small = r;
      const float missing = static_cast<float>(k) / static_cast<float>(out.size() + 1);
      r = std::min(r * std::clamp(std::sqrt(1.5f * missing), 1.5f, 4.0f), r_max);
    }
    if (r < too_large) continue;
    r = too_small + 0.5f * (too_large - too_small);
    if (r > std::max(too_small + 1e-6f * too_large, 1e-6f * step)) continue;
    structure.find(p, too_large, no_limit, out);  // many at about one distance, or at one place
    break;
  }
  keep_nearest(out, k);
}

}  // namespace etendue
