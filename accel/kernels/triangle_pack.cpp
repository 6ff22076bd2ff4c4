#include "accel/kernels/triangle_pack.h"

#include <algorithm>
#include <limits>

namespace etendue {

template <int width>
TrianglePack<width>::TrianglePack() {
  // Both signs stand here, so that the edge functions' mostly differ and a lane does not count as one that the ray may meet.
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  for (int corner = 0; corner < 3; ++corner) std::fill_n(&vertices[corner][0][0], 3 * width, corner == 1 ? -nan : nan);
  std::fill_n(ids, width, no_id);
}

template <int width>
void TrianglePack<width>::fill(const Geometry& geometry, std::span<const std::uint32_t> triangle_ids,
                               std::span<const uvec3> triangles) {
  for (std::size_t lane = 0; lane < triangles.size(); ++lane) {
    ids[lane] = triangle_ids[lane];
    const uvec3& v = triangles[lane];
    set(lane, geometry.positions[v.x], geometry.positions[v.y], geometry.positions[v.z]);
  }
}

template struct TrianglePack<4>;
template struct TrianglePack<8>;

}  // namespace etendue
