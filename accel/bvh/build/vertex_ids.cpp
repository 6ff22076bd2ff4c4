#include "accel/bvh/build/vertex_ids.h"

#include <array>
#include <bit>
#include <cstring>

namespace etendue {

// A closed mesh has half as many vertices as triangles. Where there are clearly more, some may be copies, which are looked for
// in an open hash table.
VertexIds::VertexIds(const Geometry& geometry) : geometry_(&geometry) {
  const std::size_t count = geometry.positions.size();
  if (count < 0.6 * static_cast<double>(geometry.triangles.size())) return;
  const std::size_t size = std::bit_ceil(count + count / 2);
  std::vector<std::uint32_t> table(size, no_id);
  first_equal_.resize(count);
  const auto equal = [&](std::uint32_t a, std::uint32_t b) {
    return std::memcmp(&geometry.positions[a], &geometry.positions[b], sizeof(vec3)) == 0;
  };
  for (std::uint32_t vertex = 0; vertex < count; ++vertex) {
    const auto bits = std::bit_cast<std::array<std::uint32_t, 3>>(geometry.positions[vertex]);
    std::uint64_t hash = bits[0] * 0x9e3779b97f4a7c15u;
    hash = ((hash >> 32) ^ bits[1]) * 0x9e3779b97f4a7c15u;
    hash = ((hash >> 32) ^ bits[2]) * 0x9e3779b97f4a7c15u;
    // Whether a vertex is new cannot be predicted, so no branch depends on it: a new one is compared with itself.
    std::size_t slot = (hash >> 20) & (size - 1);
    std::uint32_t first = table[slot] == no_id ? vertex : table[slot];
    while (!equal(first, vertex)) [[unlikely]] {
        slot = (slot + 1) & (size - 1);
        first = table[slot] == no_id ? vertex : table[slot];
      }
    first_equal_[vertex] = table[slot] = first;
  }
}

}  // namespace etendue
