#include "accel/bvh/wide/triangle_pack.h"

#include <algorithm>
#include <limits>

namespace etendue {

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

template struct TrianglePack<4>;
template struct TrianglePack<8>;

}  // namespace etendue
