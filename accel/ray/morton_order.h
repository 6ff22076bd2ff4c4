// Primitives along a space-filling curve: sorted by the Morton codes of their boxes' centres ([Morton1966]; for trees first by
// [Lauterbach2009]).
//
// A code has 63 bits, 21 per axis, of a cube around the centres: the first cut is then across the longest axis, whatever the
// scene's shape. The sort is a radix sort by the upper 32 bits; only runs that are equal in these are sorted by the other 31.
// Equal codes keep the order of the items. Parallel (oneTBB), with the same result at any thread count, since a stable order is
// unique.
#pragma once

#include "accel/ray/binary_tree.h"

namespace etendue {

// Sorts the items and returns their codes.
std::vector<std::uint64_t> sort_by_morton_code(std::vector<BuildItem>& items);

}  // namespace etendue
