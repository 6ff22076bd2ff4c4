#include "accel/kernels/shared_pack.h"

#include "accel/kernels/triangle_test.h"
#include "framework/core/check.h"

#include <algorithm>
#include <array>

namespace etendue {

namespace {

// The different vertices of a few triangles, in an open hash table that is used again and again: what an earlier generation
// wrote is as good as empty. Whether a vertex is new cannot be predicted, so no branch depends on it.
class VertexSet {
 public:
  static constexpr std::uint32_t most = SharedPack::slots;

  // Kept apart from the table, so that a compiler sees that no store there changes it.
  struct State {
    std::uint32_t generation, size = 0;
  };
  State clear() {
    if (++generation_ == 0) {
      table_ = {};
      generation_ = 1;
    }
    return {generation_};
  }
  // The slot of a vertex, which is added where it is new. To be asked while there are no more than `most`, for a triangle's
  // vertices at a time.
  std::uint32_t slot(std::uint32_t vertex, State& state) {
    std::uint32_t at = (vertex * 0x9e3779b1u) >> 24;
    while (table_[at].generation == state.generation && table_[at].vertex != vertex) [[unlikely]] at = (at + 1) % table_.size();
    const std::uint32_t is_new = table_[at].generation != state.generation,
                        slot = table_[at].slot ^ ((table_[at].slot ^ state.size) & (0 - is_new));
    table_[at] = {state.generation, vertex, slot, 0};
    vertices_[slot] = vertex;
    state.size += is_new;
    return slot;
  }
  std::uint32_t operator[](std::uint32_t slot) const { return vertices_[slot]; }

 private:
  struct Entry {
    std::uint32_t generation = 0, vertex = 0, slot = 0, unused = 0;
  };
  std::array<Entry, 256> table_;
  std::array<std::uint32_t, most + 3> vertices_{};
  std::uint32_t generation_ = 0;
};

thread_local constinit VertexSet vertex_set;

}  // namespace

SharedPack::SharedPack() {
  std::fill_n(&vertices[0][0], 3 * slots, 0.0f);
  std::fill_n(ids, lanes, no_id);
}

bool SharedPack::fits(std::span<const uvec3> triangles) {
  if (triangles.size() > lanes) return false;
  if (3 * triangles.size() <= slots) return true;
  VertexSet& set = vertex_set;
  VertexSet::State state = set.clear();
  for (const uvec3& triangle : triangles) {
    for (int corner = 0; corner < 3; ++corner) set.slot(triangle[corner], state);
    if (state.size > VertexSet::most) return false;
  }
  return true;
}

void SharedPack::fill(const Geometry& geometry, std::span<const std::uint32_t> triangle_ids, std::span<const uvec3> triangles) {
  VertexSet& set = vertex_set;
  VertexSet::State state = set.clear();
  for (const uvec3& triangle : triangles) {
    ids[count] = triangle_ids[count];
    for (int corner = 0; corner < 3; ++corner)
      corners[corner][count] = static_cast<std::uint8_t>(set.slot(triangle[corner], state));
    CHECK_LE(state.size, VertexSet::most);
    ++count;
  }
  for (std::uint32_t slot = 0; slot < state.size; ++slot)
    for (int axis = 0; axis < 3; ++axis) vertices[axis][slot] = geometry.positions[set[slot]][axis];
  find_needles();
}

void SharedPack::find_needles() {
  for (int lane = 0; lane < static_cast<int>(count); ++lane)
    needle_bits |= static_cast<unsigned>(is_needle(vertex(lane, 0), vertex(lane, 1), vertex(lane, 2))) << lane;
}

}  // namespace etendue
