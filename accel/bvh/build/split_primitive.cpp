#include "accel/bvh/build/split_primitive.h"

namespace etendue {

SplitParts split_primitive(const Geometry* geometry, const BuildItem& item, int axis, float plane) {
  SplitParts halves{item.bounds, item.bounds};
  halves.left.upper[axis] = halves.right.lower[axis] = plane;
  if (geometry == nullptr || !geometry->is_triangle(item.id)) return halves;
  const uvec3& corners = geometry->triangles[item.id];
  SplitParts parts;
  vec3 from = geometry->positions[corners.z];
  for (int corner = 0; corner < 3; ++corner) {
    const vec3 to = geometry->positions[corners[corner]];
    if (to[axis] <= plane) parts.left.extend(to);
    if (to[axis] >= plane) parts.right.extend(to);
    if ((from[axis] < plane && to[axis] > plane) || (from[axis] > plane && to[axis] < plane)) {
      const float along = (plane - from[axis]) / (to[axis] - from[axis]);
      const vec3 met = from + along * (to - from);
      const vec3 pad = glm::max(glm::abs(from), glm::abs(to)) * (8 * std::numeric_limits<float>::epsilon());
      const Bounds around{met - pad, met + pad};
      parts.left.extend(around);
      parts.right.extend(around);
    }
    from = to;
  }
  return {overlap(parts.left, halves.left), overlap(parts.right, halves.right)};
}

}  // namespace etendue
