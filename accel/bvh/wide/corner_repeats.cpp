#include "accel/bvh/wide/corner_repeats.h"

#include "accel/kernels/ranks.h"
#include "accel/kernels/simd_bounds.h"

namespace etendue {

Bounds CornerRepeats::fill(SharedPack& pack, const Geometry& geometry, std::span<const std::uint32_t> ids,
                           std::span<const uvec3> corners, std::size_t triangle, std::uint64_t first) const {
  const auto count = static_cast<std::uint32_t>(ids.size());
  const std::uint8_t* const distances = (*this)[triangle];
  const Ranks lanes(ids.data(), ids.size());
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
  PointBounds box;
  for (std::uint64_t rest = first; rest != 0; rest &= rest - 1, ++slot) {
    const FourFloats p = four(geometry.positions[(&corners[0].x)[std::countr_zero(rest)]]);
    for (int axis = 0; axis < 3; ++axis) pack.vertices[axis][slot] = p[axis];
    box.extend(p);
  }
  pack.find_needles();
  return box.get();
}

}  // namespace etendue
