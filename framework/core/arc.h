// The azimuth as a polynomial without branches, inline, in the place of the arc tangent of elementary.h.
#pragma once

#include "framework/core/vec.h"

#include <array>

namespace etendue {

// The angle of (x, y) in turns, in [0, 1], within 6e-8; 0 of (0, 0). The arc tangent of [Abramowitz1964] 4.4.49, and a table of
// octants in place of branches, which could not be predicted.
inline float turn_of(float x, float y) {
  static constexpr std::array<float, 8> begin{0, 0.25f, 0.5f, 0.25f, 1, 0.75f, 0.5f, 0.75f}, sign{1, -1, -1, 1, -1, 1, 1, -1};
  static constexpr std::array<float, 8> coefficients{0.0028662257f, -0.0161657367f, 0.0429096138f, -0.0752896400f,
                                                     0.1065626393f, -0.1420889944f, 0.1999355085f, -0.3333314528f};
  const float width = std::abs(x), height = std::abs(y), most = std::max(width, height);
  const float tangent = most > 0 ? std::min(width, height) / most : 0, square = tangent * tangent;
  float arc = 0;
  for (const float coefficient : coefficients) arc = (arc + coefficient) * square;
  const std::size_t octant = (height > width ? 1u : 0u) + (x < 0 ? 2u : 0u) + (y < 0 ? 4u : 0u);
  return begin[octant] + sign[octant] * (0.5f * inv_pi) * (tangent + tangent * arc);
}

}  // namespace etendue
