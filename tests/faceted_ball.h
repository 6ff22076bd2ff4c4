// A ball of few facets that is shaded as if it were round, under an even sky: of everything that photons may be mistaken about,
// only that their density follows the facets, and what is reflected the shading normals.
#pragma once

#include "framework/scene/builder.h"

#include <cmath>

namespace etendue::testing {

// Radius 1, filling the image; light of one scattering event.
inline Scene faceted_ball() {
  constexpr int around = 12, down = 6;
  MeshData ball;
  for (int j = 0; j <= down; ++j)
    for (int i = 0; i < around; ++i) {
      const float theta = pi * static_cast<float>(j) / down, phi = 2 * pi * static_cast<float>(i) / around;
      ball.positions.emplace_back(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi));
    }
  ball.normals = ball.positions;
  for (std::uint32_t j = 0; j < down; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t a = j * around + i, b = j * around + (i + 1) % around;
      if (j > 0) ball.triangles.emplace_back(a, a + around, b);
      if (j + 1 < down) ball.triangles.emplace_back(b, a + around, b + around);
    }
  SceneBuilder builder("faceted ball");
  builder.mesh(ball, builder.material(Diffuse{Rgb(0.8f)}));
  builder.light(EnvironmentLight{.scale = Rgb(1), .size = ivec2(0), .texels = {}, .light_to_world = {}});
  builder.camera({0, 0.8f, 5}, {0, 0, 0}, 15, {32, 32});
  builder.max_depth(1);
  return builder.finish();
}

}  // namespace etendue::testing
