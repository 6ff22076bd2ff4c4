#include "accel/bvh/wide/small_geometry.h"

#include "accel/kernels/triangle_test.h"

#include <algorithm>

namespace etendue {

SmallGeometry::SmallGeometry(const Geometry& geometry) {
  if (geometry.primitive_count() > most_triangles + most_others) return;
  const auto place_of = [&](const vec3& p) {
    const auto same = [&](const Vertex& v) {
      return v.coordinates[0] == p.x && v.coordinates[1] == p.y && v.coordinates[2] == p.z;
    };
    const auto found = std::find_if(vertices.begin(), vertices.end(), same);
    const auto place = static_cast<std::uint8_t>(found - vertices.begin());
    if (found == vertices.end()) vertices.push_back({{p.x, p.y, p.z, 0}});
    return place;
  };
  for (const std::uint32_t id : geometry.valid_primitives()) {
    if (geometry.is_triangle(id)) {
      const uvec3 v = geometry.triangles[id];
      const vec3 &a = geometry.positions[v.x], &b = geometry.positions[v.y], &c = geometry.positions[v.z];
      if (!is_needle(a, b, c)) {
        triangles.push_back({id, {place_of(a), place_of(b), place_of(c)}});
        continue;
      }
    }
    others.push_back(id);
  }
  if (triangles.size() > most_triangles || vertices.size() > most_vertices || others.size() > most_others) *this = {};
}

}  // namespace etendue
