// Warps of the unit square, each with its density.
#pragma once

#include "framework/core/vec.h"

namespace etendue {

// Concentric map of [Shirley1997]; uniform on the unit disk.
inline vec2 sample_unit_disk(const vec2& u) {
  const vec2 p = 2.0f * u - 1.0f;
  if (p.x == 0 && p.y == 0) return vec2(0);
  const bool wide = std::abs(p.x) > std::abs(p.y);
  const float r = wide ? p.x : p.y;
  const float theta = wide ? 0.25f * pi * (p.y / p.x) : 0.5f * pi - 0.25f * pi * (p.x / p.y);
  return r * vec2(std::cos(theta), std::sin(theta));
}

// Density cos / pi over the hemisphere about +z.
inline vec3 sample_cosine_hemisphere(const vec2& u) {
  const vec2 d = sample_unit_disk(u);
  return {d, safe_sqrt(1 - d.x * d.x - d.y * d.y)};
}

// Density 1 / (4 pi).
inline vec3 sample_unit_sphere(const vec2& u) {
  const float z = 1 - 2 * u.x, r = safe_sqrt(1 - z * z), phi = 2 * pi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

// Density 1 / (2 pi (1 - cos_max)) over the cone about +z.
inline vec3 sample_cone(const vec2& u, float cos_max) {
  const float z = 1 - u.x * (1 - cos_max), r = safe_sqrt(1 - z * z), phi = 2 * pi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

// Barycentric weights of the second and third vertex; uniform over the triangle.
inline vec2 sample_triangle(const vec2& u) {
  const float root = std::sqrt(u.x);
  return {root * (1 - u.y), root * u.y};
}

}  // namespace etendue
