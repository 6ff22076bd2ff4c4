#include "framework/scene/triangle_point.h"

namespace etendue {

vec3 kept_off_edges(const TrianglePlane& t, vec3 weights, float distance) {
  const vec3 corners[3] = {vec3(0), t.e1, t.e2};
  vec3 least;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const vec3 edge = corners[k] - corners[j];
    const float length2 = length_squared(edge);
    least[i] = std::min(distance * std::sqrt(length2) / t.doubled, 0.25f);
    if (!(weights[i] < least[i])) continue;
    const float foot = glm::dot(corners[i] - corners[j], edge) / length2, missing = least[i] - weights[i];
    weights[i] += missing;
    weights[j] -= missing * (1 - foot);
    weights[k] -= missing * foot;
  }
  weights = glm::max(weights, least);
  return weights / (weights.x + weights.y + weights.z);
}

}  // namespace etendue
