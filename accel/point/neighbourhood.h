// What every point and ball structure agrees on, so that their answers are equal to the bit.
#pragma once

#include "framework/query.h"

namespace etendue {

inline float distance_squared(const vec3& point, const vec3& p) { return length_squared(point - p); }

// Queries that are not finite, and negative or NaN radii, find nothing.
inline bool can_find(const vec3& p, float r) { return is_finite(p) && r >= 0; }

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

}  // namespace etendue
