// Choosing by a number among entries of a cumulative table.
#pragma once

#include "framework/core/rng.h"

#include <algorithm>
#include <cstddef>

namespace etendue {

// Index of the first entry above u in a cumulative table that ends at 1; u is rescaled to [0, 1) within the entry. Bisection
// without a branch, which would be mispredicted every other time.
template <class T>
std::size_t pick(const T* cumulative, std::size_t count, T& u) {
  std::size_t i = 0;
  for (std::size_t left = count; left > 1;) {
    const std::size_t half = left / 2;
    i += half * static_cast<std::size_t>(cumulative[i + half - 1] <= u);
    left -= half;
  }
  const auto is_inner = static_cast<std::size_t>(i > 0);
  const T before = cumulative[i - is_inner] * static_cast<T>(is_inner), width = cumulative[i] - before;
  u = width > 0 ? std::min(std::max(T(0), (u - before) / width), T(0x1.fffffep-1)) : 0;
  return i;
}

// A number of [0, 1) in steps of 2^-24 with digits below those, hashed from it and from `salt`, a number beside it: among many
// entries a choice needs more digits than a float has, and leaves too few of them within the entry.
inline double with_more_digits(float u, float salt) {
  const std::uint64_t hash = mix_bits(static_cast<std::uint64_t>(bits_of(u)) << 32 | bits_of(salt));
  return u + 0x1p-24 * (static_cast<double>(hash >> 32) * 0x1p-32);
}

}  // namespace etendue
