// What every point and ball structure agrees on, so that their answers are equal to the bit.
#pragma once

#include "framework/query.h"

#include <array>

namespace etendue {

inline float distance_squared(const vec3& point, const vec3& p) { return length_squared(point - p); }

// Queries that are not finite, and negative or NaN radii, find nothing; and nothing finds points that are not finite.
inline bool can_find(const vec3& p, float r) { return is_finite(p) && r >= 0; }

// Above r by what rounding allows: no point with a float distance^2 <= r^2 lies farther than this along any axis.
inline float reach(float r) { return r * (1 + 8 * std::numeric_limits<float>::epsilon()) + 1e-22f; }

inline bool is_nearer(const Neighbour& a, const Neighbour& b) {
  return a.distance_squared < b.distance_squared || (a.distance_squared == b.distance_squared && a.id < b.id);
}

// The k nearest of `found`, nearest first.
inline void keep_nearest(Neighbours& found, std::size_t k) {
  if (k < found.size()) {
    std::nth_element(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(k), found.end(), is_nearer);
    found.resize(k);
  }
  std::sort(found.begin(), found.end(), is_nearer);
}

// Points as the structures place them in the order of their cells: a query reads runs of them.
struct PlacedPoint {
  vec3 position;
  std::uint32_t id;
};

// Appends the points of a run with squared distance <= limit; stops, with false, once `out` holds more than `most`. Distances
// are rarely predictable, so they decide about an index, not about a jump.
inline bool append_within(const PlacedPoint* begin, const PlacedPoint* end, const vec3& p, float limit, std::size_t most,
                          Neighbours& out) {
  constexpr std::ptrdiff_t chunk = 32;
  std::array<Neighbour, chunk> found;
  while (begin != end) {
    const PlacedPoint* const stop = begin + std::min(end - begin, chunk);
    std::size_t count = 0;
    for (; begin != stop; ++begin) {
      const float d2 = distance_squared(begin->position, p);
      found[count] = {begin->id, d2};
      count += d2 <= limit;
    }
    out.insert(out.end(), found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count));
    if (out.size() > most) return false;
  }
  return true;
}

// The k nearest points so far, among those with squared distance <= limit: a heap in the caller's buffer with the farthest on
// top.
class NearestSoFar {
 public:
  NearestSoFar(std::size_t k, float limit, Neighbours& out) : k_(k), limit_(limit), out_(out) { out_.clear(); }

  bool full() const { return out_.size() == k_; }
  // Points farther than this cannot be among them; one at just this distance can, if its id is low.
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

// `nearest` for structures that find by radius: balls of growing radius until one holds enough; then the nearest are all inside
// it. The first is small, as clusters may be much denser than the mean; the next ones are as large as the density met so far
// asks for. One that holds many times too much (a dense cluster, seen from afar) is given up for one in between.
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
