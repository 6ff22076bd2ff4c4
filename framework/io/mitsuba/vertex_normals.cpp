#include "framework/io/mitsuba/vertex_normals.h"

#include "framework/core/elementary.h"

#include <algorithm>
#include <cmath>

namespace etendue {

std::vector<vec3> smooth_normals(const TriangleMesh& mesh) {
  std::vector<dvec3> sums(mesh.positions.size(), dvec3(0));
  for (const uvec3& t : mesh.triangles) {
    const dvec3 p[3] = {dvec3(mesh.positions[t.x]), dvec3(mesh.positions[t.y]), dvec3(mesh.positions[t.z])};
    const dvec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double length = glm::length(normal);
    if (!(length > 0)) continue;
    for (int i = 0; i < 3; ++i) {
      const dvec3 a = p[(i + 1) % 3] - p[i], b = p[(i + 2) % 3] - p[i];
      sums[t[i]] += normal / length * math::atan2(length, glm::dot(a, b));
    }
  }
  std::vector<vec3> normals(sums.size());
  std::transform(sums.begin(), sums.end(), normals.begin(), [](const dvec3& sum) {
    const double length = glm::length(sum);
    return length > 0 ? vec3(sum / length) : vec3(0);
  });
  return normals;
}

}  // namespace etendue
