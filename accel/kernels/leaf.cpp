#include "accel/kernels/leaf.h"

#include "framework/core/check.h"

#include <algorithm>

namespace etendue {

LeafBlocks::Run LeafBlocks::add(std::span<const std::uint32_t> ids) {
  std::vector<std::uint32_t> ordered;  // triangles before quadrics
  if (mixed()) {
    ordered.assign(ids.begin(), ids.end());
    std::sort(ordered.begin(), ordered.end());
    ids = ordered;
  }
  const auto first = static_cast<std::uint32_t>(blocks_.size());
  for (std::size_t begin = 0; begin < ids.size(); begin += TriangleBlock::width)
    fill(blocks_.emplace_back(), ids.subspan(begin, std::min<std::size_t>(TriangleBlock::width, ids.size() - begin)));
  return {first, static_cast<std::uint32_t>(blocks_.size()) - first};
}

void LeafBlocks::set(std::uint32_t block, std::span<const std::uint32_t> ids) {
  CHECK_LE(ids.size(), TriangleBlock::width);
  blocks_[block] = {};
  if (!mixed()) return fill(blocks_[block], ids);
  std::array<std::uint32_t, TriangleBlock::width> ordered;
  ordered.fill(no_id);
  std::copy(ids.begin(), ids.end(), ordered.begin());
  std::sort(ordered.begin(), ordered.end());
  fill(blocks_[block], std::span(ordered).first(ids.size()));
}

void LeafBlocks::fill(Block& block, std::span<const std::uint32_t> ids) const {
  for (const std::uint32_t id : ids) {
    block.ids[block.size++] = id;
    if (!geometry_->is_triangle(id)) continue;
    const uvec3 v = geometry_->triangles[id];
    const auto& p = geometry_->positions;
    block.needles |= static_cast<std::uint8_t>(is_needle(p[v.x], p[v.y], p[v.z]) << block.triangle_count);
    block.triangles.set(block.triangle_count++, p[v.x], p[v.y], p[v.z]);
  }
}

std::uint64_t LeafBlocks::references() const {
  std::uint64_t sum = 0;
  for (const Block& block : blocks_) sum += block.size;
  return sum;
}

}  // namespace etendue
