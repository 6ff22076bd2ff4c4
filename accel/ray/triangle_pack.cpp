#include "accel/ray/triangle_pack.h"

#include "framework/core/check.h"
#include "framework/core/parallel.h"

#include <algorithm>
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

std::vector<uvec3> VertexIds::in_order(std::span<const std::uint32_t> primitives) const {
  std::vector<uvec3> corners(primitives.size());
  parallel_for(primitives.size(), 1 << 13, [&](std::size_t i) {
    if (geometry_->is_triangle(primitives[i])) corners[i] = (*this)(primitives[i]);
  });
  return corners;
}

template <int width>
TrianglePack<width>::TrianglePack() {
  std::fill_n(&vertices[0][0][0], 9 * width, std::numeric_limits<float>::quiet_NaN());
  std::fill_n(ids, width, no_id);
}

template <int width>
void TrianglePack<width>::fill(const Geometry& geometry, std::span<const std::uint32_t> triangle_ids,
                               std::span<const uvec3> triangles) {
  for (std::size_t lane = 0; lane < triangles.size(); ++lane) {
    ids[lane] = triangle_ids[lane];
    for (int corner = 0; corner < 3; ++corner)
      for (int axis = 0; axis < 3; ++axis) vertices[corner][axis][lane] = geometry.positions[triangles[lane][corner]][axis];
  }
}

namespace {

// The different vertices of a few triangles, in an open hash table that is used again and again: what an earlier generation
// wrote is as good as empty. Whether a vertex is new is a toss-up, so no branch depends on it.
class VertexSet {
 public:
  static constexpr std::uint32_t most = SharedPack::slots;

  void clear() {
    size_ = 0;
    if (++generation_ > 0) return;
    table_ = {};
    generation_ = 1;
  }
  // The slot of a vertex, which is added where it is new. To be asked while there are no more than `most`, for a triangle's
  // vertices at a time.
  std::uint32_t slot(std::uint32_t vertex) {
    std::uint32_t at = (vertex * 0x9e3779b1u) >> 24;
    while ((table_[at].generation == generation_) & (table_[at].vertex != vertex)) [[unlikely]] at = (at + 1) % table_.size();
    const std::uint32_t is_new = table_[at].generation != generation_,
                        slot = table_[at].slot ^ ((table_[at].slot ^ size_) & (0 - is_new));
    table_[at] = {generation_, vertex, slot, 0};
    vertices_[slot] = vertex;
    size_ += is_new;
    return slot;
  }
  std::uint32_t size() const { return size_; }
  std::uint32_t operator[](std::uint32_t slot) const { return vertices_[slot]; }

 private:
  struct Entry {
    std::uint32_t generation = 0, vertex = 0, slot = 0, unused = 0;
  };
  std::array<Entry, 256> table_;
  std::array<std::uint32_t, most + 3> vertices_{};
  std::uint32_t size_ = 0, generation_ = 0;
};

VertexSet& empty_vertex_set() {
  thread_local constinit VertexSet set;
  set.clear();
  return set;
}

}  // namespace

SharedPack::SharedPack() {
  std::fill_n(&vertices[0][0], 3 * slots, 0.0f);
  std::fill_n(ids, lanes, no_id);
}

bool SharedPack::fits(std::span<const uvec3> triangles) {
  if (triangles.size() > lanes) return false;
  if (3 * triangles.size() <= slots) return true;
  VertexSet& set = empty_vertex_set();
  for (const uvec3& triangle : triangles) {
    for (int corner = 0; corner < 3; ++corner) set.slot(triangle[corner]);
    if (set.size() > VertexSet::most) return false;
  }
  return true;
}

void SharedPack::fill(const Geometry& geometry, std::span<const std::uint32_t> triangle_ids, std::span<const uvec3> triangles) {
  VertexSet& set = empty_vertex_set();
  for (const uvec3& triangle : triangles) {
    ids[count] = triangle_ids[count];
    for (int corner = 0; corner < 3; ++corner) corners[corner][count] = static_cast<std::uint8_t>(set.slot(triangle[corner]));
    CHECK_LE(set.size(), VertexSet::most);
    ++count;
  }
  for (std::uint32_t slot = 0; slot < set.size(); ++slot)
    for (int axis = 0; axis < 3; ++axis) vertices[axis][slot] = geometry.positions[set[slot]][axis];
}

template struct TrianglePack<4>;
template struct TrianglePack<8>;

}  // namespace etendue
