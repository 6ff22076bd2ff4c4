#include "accel/ray/corner_repeats.h"

#include "accel/ray/four_floats.h"

#include <cstring>

namespace etendue {

namespace {

// Where each of up to sixteen different ids comes in their rising order.
class Ranks {
 public:
  explicit Ranks(std::span<const std::uint32_t> ids) {
    FourUnsigned values[4], ranks[4]{};
    std::memset(values, 0xff, sizeof values);
    std::memcpy(values, ids.data(), ids.size_bytes());
    const std::size_t used = (ids.size() + 3) / 4;
    for (const std::uint32_t id : ids)
      for (std::size_t i = 0; i < used; ++i) ranks[i] -= (FourUnsigned)(values[i] > id);
    std::memcpy(ranks_, ranks, sizeof ranks);
  }
  std::uint32_t operator[](std::size_t i) const { return ranks_[i]; }

 private:
  std::uint32_t ranks_[SharedPack::lanes];
};

}  // namespace

void CornerRepeats::fill(SharedPack& pack, const Geometry& geometry, std::span<const std::uint32_t> ids,
                         std::span<const uvec3> corners, std::size_t triangle) const {
  const auto count = static_cast<std::uint32_t>(ids.size());
  const std::uint64_t first = first_seen(triangle, count, size_);
  const std::uint8_t* const distances = (*this)[triangle];
  const Ranks lanes(ids);
  // A corner has the next slot, or that of the corner so far back, which may be before the run where the slot is new.
  std::uint8_t slots[never + reach]{}, next = 0;
  std::uint8_t* const slot_of = slots + never;
  for (std::uint32_t i = 0, k = 0; i < count; ++i) {
    const std::uint32_t lane = lanes[i];
    pack.ids[lane] = ids[i];
    for (std::uint32_t corner = 0; corner < 3; ++corner, ++k) {
      const bool is_first = first >> k & 1;
      const std::uint8_t known = slot_of[static_cast<std::ptrdiff_t>(k) - distances[k]];
      const std::uint8_t slot = is_first ? next : known;
      next = static_cast<std::uint8_t>(next + is_first);
      pack.corners[corner][lane] = slot_of[k] = slot;
    }
  }
  pack.count = count;
  std::uint32_t slot = 0;
  for (std::uint64_t rest = first; rest != 0; rest &= rest - 1, ++slot) {
    const auto k = static_cast<std::uint32_t>(std::countr_zero(rest));
    const vec3& p = geometry.positions[corners[k / 3][k % 3]];
    for (int axis = 0; axis < 3; ++axis) pack.vertices[axis][slot] = p[axis];
  }
}

}  // namespace etendue
