// Warps of the unit square, each with its density.
#pragma once

#include "framework/core/vec.h"

#include <bit>

namespace etendue {

// Cosine and sine of an angle in [-pi/4, pi/4], within 8e-8: polynomials in its square, without a branch.
inline vec2 cos_sin_within_eighth(float angle) {
  const float x = angle * angle;
  const float cosine = 1 - 0.5f * x + x * x * (4.166664568e-2f + x * (-1.388731625e-3f + x * 2.443315712e-5f));
  const float sine = angle + angle * x * (-1.666665461e-1f + x * (8.332160874e-3f + x * -1.951529589e-4f));
  return {cosine, sine};
}

// Concentric map of [Shirley1997]; uniform on the unit disk. The two pairs of wedges differ only by the order of the
// coordinates, which are swapped without a branch: it could not be predicted.
inline vec2 sample_unit_disk(const vec2& u) {
  const vec2 p = 2.0f * u - 1.0f;
  const std::uint32_t steep = -static_cast<std::uint32_t>(std::abs(p.y) >= std::abs(p.x));
  const auto swapped = [steep](const vec2& v) {
    const auto x = std::bit_cast<std::uint32_t>(v.x), y = std::bit_cast<std::uint32_t>(v.y), change = (x ^ y) & steep;
    return vec2(std::bit_cast<float>(x ^ change), std::bit_cast<float>(y ^ change));
  };
  const vec2 q = swapped(p);  // the larger one first
  if (q.x == 0) return vec2(0);
  return swapped(q.x * cos_sin_within_eighth(0.25f * pi * (q.y / q.x)));
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
