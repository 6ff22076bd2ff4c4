#include "accel/ray/triangle_pack.h"

#include <algorithm>
#include <array>
#include <bit>

namespace etendue {

// A closed mesh has half as many vertices as triangles. Where there are clearly more, some may be copies, which are looked for
// in an open hash table.
VertexIds::VertexIds(const Geometry& geometry) : geometry_(&geometry) {
  const std::size_t count = geometry.positions.size();
  if (count < 0.6 * static_cast<double>(geometry.triangles.size())) return;
  const std::size_t size = std::bit_ceil(2 * count);
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

template <int width>
TrianglePack<width>::TrianglePack() {
  std::fill_n(&vertices[0][0][0], 9 * width, std::numeric_limits<float>::quiet_NaN());
  std::fill_n(ids, width, no_id);
}

template <int width>
void TrianglePack<width>::fill(const VertexIds& vertex_ids, std::span<const std::uint32_t> triangles) {
  for (std::size_t lane = 0; lane < triangles.size(); ++lane) {
    ids[lane] = triangles[lane];
    for (int corner = 0; corner < 3; ++corner)
      for (int axis = 0; axis < 3; ++axis)
        vertices[corner][axis][lane] = vertex_ids.geometry().positions[vertex_ids(triangles[lane], corner)][axis];
  }
}

namespace {

// The different vertices of a few triangles, in a small open hash table.
class VertexSet {
 public:
  static constexpr int most = SharedPack::slots;

  VertexSet() { slots_.fill(-1); }

  // The slot of a vertex, which is added if there is room; `most` if there is none.
  int slot(std::uint32_t vertex) {
    std::size_t at = (vertex * 0x9e3779b1u) >> 26;
    while (slots_[at] >= 0 && vertices_[slots_[at]] != vertex) at = (at + 1) % slots_.size();
    if (slots_[at] >= 0) return slots_[at];
    if (size_ == most) return most;
    vertices_[size_] = vertex;
    return slots_[at] = static_cast<std::int8_t>(size_++);
  }
  int size() const { return size_; }
  std::uint32_t operator[](int slot) const { return vertices_[slot]; }

 private:
  std::array<std::int8_t, 64> slots_;  // by hash
  std::array<std::uint32_t, most> vertices_;
  int size_ = 0;
};

}  // namespace

SharedPack::SharedPack() {
  std::fill_n(&vertices[0][0], 3 * slots, 0.0f);
  std::fill_n(ids, lanes, no_id);
}

bool SharedPack::fits(const VertexIds& vertex_ids, std::span<const std::uint32_t> triangles) {
  if (triangles.size() > lanes) return false;
  if (3 * triangles.size() <= slots) return true;
  VertexSet set;
  for (const std::uint32_t id : triangles)
    for (int corner = 0; corner < 3; ++corner)
      if (set.slot(vertex_ids(id, corner)) == VertexSet::most) return false;
  return true;
}

void SharedPack::fill(const VertexIds& vertex_ids, std::span<const std::uint32_t> triangles) {
  VertexSet set;
  for (const std::uint32_t id : triangles) {
    ids[count] = id;
    for (int corner = 0; corner < 3; ++corner)
      corners[corner][count] = static_cast<std::uint8_t>(set.slot(vertex_ids(id, corner)));
    ++count;
  }
  for (int slot = 0; slot < set.size(); ++slot)
    for (int axis = 0; axis < 3; ++axis) vertices[axis][slot] = vertex_ids.geometry().positions[set[slot]][axis];
}

template struct TrianglePack<4>;
template struct TrianglePack<8>;

}  // namespace etendue
