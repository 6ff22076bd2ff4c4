// A pack of some triangles in any order.
#pragma once

#include "framework/scene/geometry.h"

#include <array>
#include <cstdint>
#include <span>

namespace etendue {

// Places triangles by rising id and each once: one that was cut in parts may have come together again.
template <class Pack>
void fill_pack(Pack& pack, const Geometry& geometry, std::span<const std::uint32_t> unsorted, std::span<const uvec3> corners) {
  std::array<std::uint32_t, Pack::lanes> ids;
  std::array<uvec3, Pack::lanes> triangles;
  std::size_t count = 0;
  for (std::size_t i = 0; i < unsorted.size(); ++i) {
    std::size_t place = count;
    while (place > 0 && ids[place - 1] > unsorted[i]) --place;
    if (place > 0 && ids[place - 1] == unsorted[i]) continue;
    for (std::size_t j = count++; j > place; --j) {
      ids[j] = ids[j - 1];
      triangles[j] = triangles[j - 1];
    }
    ids[place] = unsorted[i];
    triangles[place] = corners[i];
  }
  pack.fill(geometry, std::span(ids).first(count), std::span(triangles).first(count));
}

}  // namespace etendue
