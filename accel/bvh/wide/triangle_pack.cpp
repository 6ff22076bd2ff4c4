#include "accel/bvh/wide/triangle_pack.h"

#include "framework/scene/intersect.h"

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
    const uvec3& v = triangles[lane];
    const vec3 &a = geometry.positions[v.x], &b = geometry.positions[v.y], &c = geometry.positions[v.z];
    const bool needle = is_needle(a, b, c);
    for (int axis = 0; axis < 3; ++axis) {
      vertices[0][axis][lane] = a[axis];
      vertices[1][axis][lane] = needle ? a[axis] : b[axis];
      vertices[2][axis][lane] = needle ? a[axis] : c[axis];
    }
  }
}

template struct TrianglePack<4>;
template struct TrianglePack<8>;

}  // namespace etendue
