#include "accel/kernels/leaf.h"

#include "framework/core/check.h"

#include <algorithm>

namespace etendue {

Leaves::Run Leaves::add(std::span<const std::uint32_t> ids) {
  std::vector<std::uint32_t> ordered(ids.begin(), ids.end());  // triangles before quadrics
  std::sort(ordered.begin(), ordered.end());
  const auto first = static_cast<std::uint32_t>(packs_.size());
  for (std::span<const std::uint32_t> rest = ordered; !rest.empty();) {
    const std::size_t size = std::min<std::size_t>(Pack::lanes, rest.size());
    fill(packs_.emplace_back(), rest.first(size));
    rest = rest.subspan(size);
  }
  return {first, static_cast<std::uint32_t>(packs_.size()) - first};
}

void Leaves::set(std::uint32_t pack, std::span<const std::uint32_t> ids) {
  CHECK_LE(ids.size(), static_cast<std::size_t>(Pack::lanes));
  std::array<std::uint32_t, Pack::lanes> ordered;
  const auto end = std::copy(ids.begin(), ids.end(), ordered.begin());
  std::sort(ordered.begin(), end);
  packs_[pack] = {};
  fill(packs_[pack], std::span(ordered).first(ids.size()));
}

void Leaves::fill(Pack& pack, std::span<const std::uint32_t> ids) const {
  for (std::size_t lane = 0; lane < ids.size(); ++lane) {
    pack.ids[lane] = ids[lane];
    if (!geometry_->is_triangle(ids[lane])) continue;
    const uvec3 v = geometry_->triangles[ids[lane]];
    const auto& p = geometry_->positions;
    pack.place(lane, p[v.x], p[v.y], p[v.z]);
    pack.needle_bits |= static_cast<unsigned>(is_needle(p[v.x], p[v.y], p[v.z])) << lane;
  }
}

std::uint64_t Leaves::references() const {
  std::uint64_t sum = 0;
  for (const Pack& pack : packs_) sum += primitives_of(pack);
  return sum;
}

}  // namespace etendue
