#include "accel/ray/vertex_ids.h"

#include <array>
#include <bit>

namespace etendue {

// A closed mesh has half as many vertices as triangles. Where there are clearly more, some may be copies, which are looked for
// in an open hash table.
VertexIds::VertexIds(const Geometry& geometry) : geometry_(&geometry) {
  const std::size_t count = geometry.positions.size();
  if (count < 0.6 * static_cast<double>(geometry.triangles.size())) return;
  const std::size_t size = std::bit_ceil(count + count / 2);
  std::vector<std::uint32_t> table(size, no_id);
  first_equal_.resize(count);
  for (std::uint32_t vertex = 0; vertex < count; ++vertex) {
    const auto bits = std::bit_cast<std::array<std::uint32_t, 3>>(geometry.positions[vertex]);
    std::uint64_t hash = bits[0] * 0x9e3779b97f4a7c15u;
    hash = ((hash >> 32) ^ bits[1]) * 0x9e3779b97f4a7c15u;
    hash = ((hash >> 32) ^ bits[2]) * 0x9e3779b97f4a7c15u;
    std::size_t slot = (hash >> 20) & (size - 1);
    while (table[slot] != no_id && std::bit_cast<std::array<std::uint32_t, 3>>(geometry.positions[table[slot]]) != bits)
      slot = (slot + 1) & (size - 1);
    if (table[slot] == no_id) table[slot] = vertex;
    first_equal_[vertex] = table[slot];
  }
}

}  // namespace etendue
