#include "framework/materials/relief.h"

namespace etendue {

namespace {

// The normal moved against the gradient. Its components along dp_du and dp_dv, both made perpendicular to n, are the slopes.
vec3 tilted(const vec3& n, const SmoothPoint& at, const vec2& slopes) {
  const vec3 a = at.dp_du - glm::dot(at.dp_du, n) * n, b = at.dp_dv - glm::dot(at.dp_dv, n) * n, across = glm::cross(a, b);
  return n - (slopes.x * glm::cross(b, across) + slopes.y * glm::cross(across, a)) / length_squared(across);
}

vec3 mapped(const vec3& n, const SmoothPoint& at, const Rgb& encoded) {
  const vec3 local = 2.0f * encoded - 1.0f;
  const vec3 s = glm::normalize(at.dp_du - glm::dot(at.dp_du, n) * n);
  return local.x * s + local.y * glm::cross(n, s) + local.z * n;
}

}  // namespace

vec3 normal_of_relief(const Relief& relief, const Texture& texture, const SmoothPoint& point) {
  const vec3& n = point.shading_normal;
  const vec3 moved = relief.kind == Relief::Kind::normals ? mapped(n, point, evaluate(texture, point.uv))
                                                          : tilted(n, point, relief.scale * slope(texture, point.uv));
  const float far = glm::length(moved);
  if (!(far > 0 && far < infinity)) return n;
  return (glm::dot(moved, point.normal) < 0 ? -1.0f : 1.0f) * moved / far;
}

}  // namespace etendue
