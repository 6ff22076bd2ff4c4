// The plane z = 0 in white (18 m wide), and a point in its middle, seen from above: where tests hold density estimates to
// theory.
#pragma once

#include "framework/scene/builder.h"

namespace etendue::testing {

inline Scene white_plane() {
  SceneBuilder builder("white plane");
  builder.mesh(quad({-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}), builder.material(Diffuse{Rgb(1)}));
  return builder.finish();
}

inline const SurfacePoint origin{vec3(0), {0, 0, 1}, {0, 0, 1}, {1, 0, 0}, vec2(0), 0, no_id};

}  // namespace etendue::testing
