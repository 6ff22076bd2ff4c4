// Ray origins moved off the surface they start on, by integer steps in the floats' own precision ([Waechter2019]).
#pragma once

#include "framework/core/vec.h"

#include <bit>

namespace etendue {

// `position` moved along `normal` (unit, on the side the ray leaves to).
inline vec3 offset_origin(const vec3& position, const vec3& normal) {
  constexpr float near_origin = 1.0f / 32, float_scale = 1.0f / 65536, int_scale = 256;
  vec3 out;
  for (int i = 0; i < 3; ++i) {
    const auto step = static_cast<std::int32_t>(int_scale * normal[i]);
    const auto bits = std::bit_cast<std::int32_t>(position[i]);
    out[i] = std::abs(position[i]) < near_origin ? position[i] + float_scale * normal[i]
                                                 : std::bit_cast<float>(bits + (position[i] < 0 ? -step : step));
  }
  return out;
}

}  // namespace etendue
