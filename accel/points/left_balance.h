// The shape of left-balanced trees: every level but the last is full, the last from the left ([Jensen2001]).
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>

namespace etendue {

// Nodes of the left subtree of such a tree of `count` nodes, at least one.
inline std::size_t left_subtree_size(std::size_t count) {
  const std::size_t full = std::bit_floor(count);  // nodes of the last level, were it full; those above are one fewer
  if (full == 1) return 0;
  const std::size_t last = count - (full - 1), half = full / 2;
  return half - 1 + std::min(last, half);
}

}  // namespace etendue
