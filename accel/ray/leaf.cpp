#include "accel/ray/leaf.h"

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
  for (std::size_t begin = 0; begin < ids.size(); begin += TriangleBlock::width) {
    Block& block = blocks_.emplace_back();
    block.ids.fill(no_id);
    for (std::size_t i = begin; i < std::min(begin + TriangleBlock::width, ids.size()); ++i) {
      const std::uint32_t id = block.ids[block.size] = ids[i];
      if (geometry_->is_triangle(id)) {
        const uvec3 v = geometry_->triangles[id];
        block.triangles.set(block.triangle_count++, geometry_->positions[v.x], geometry_->positions[v.y],
                            geometry_->positions[v.z]);
      }
      ++block.size;
    }
  }
  references_ += ids.size();
  return {first, static_cast<std::uint32_t>(blocks_.size()) - first};
}

}  // namespace etendue
