// A sheet that is lit through, and a wall that stands on one side of it: light on the sheet is even up to the wall, whichever
// side it hides of the discs that photons are gathered from.
#pragma once

#include "framework/image/film.h"
#include "framework/scene/builder.h"

#include <gtest/gtest.h>

namespace etendue::testing {

inline constexpr ivec2 sheet_resolution{16, 16};

// `height`: of the wall, towards the camera; negative: on the far side. `veiled`: light comes by way of a pane.
inline Scene sheet_beside_wall(float height, bool veiled) {
  SceneBuilder b("sheet");
  b.mesh(quad({-3, -3, 0}, {3, -3, 0}, {3, 3, 0}, {-3, 3, 0}), b.material(DiffuseTransmission{Rgb(0), Rgb(0.5f)}));
  b.mesh(quad({0, -3, 0}, {0, 3, 0}, {0, 3, height}, {0, -3, height}), b.material(Diffuse{Rgb(0)}));
  if (veiled) b.mesh(quad({-3, -3, -2}, {3, -3, -2}, {3, 3, -2}, {-3, 3, -2}), b.material(Dielectric{.eta = 1}));
  b.light(DirectionalLight{{0, 0, 1}, Rgb(1)});
  b.camera({-0.6f, 0, 4}, {-0.6f, 0, 0}, 20, sheet_resolution);
  return b.finish();
}

// The wall is seen in the last two columns of one side.
inline void expect_even_sheet(const Image& image) {
  for (int x = 2; x < sheet_resolution.x - 2; ++x) {
    double column = 0;
    for (int y = 0; y < sheet_resolution.y; ++y) column += image.at(x, y).y / sheet_resolution.y;
    EXPECT_NEAR(column, 0.5 / pi, 0.02) << "column " << x;
  }
}

}  // namespace etendue::testing
