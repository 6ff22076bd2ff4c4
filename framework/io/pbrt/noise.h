// Perlin's gradient noise ([Perlin2002]) and the sums of it that pbrt's procedural textures are made of.
#pragma once

#include "framework/core/vec.h"

namespace etendue {

// About -1 .. 1, and 0 at points of whole numbers.
float perlin_noise(const vec3& p);
// Sums of noise at frequencies that nearly double, each `roughness` times as strong as the one before; turbulence sums
// magnitudes.
float fractal_noise(const vec3& p, float roughness, int octaves);
float turbulence(const vec3& p, float roughness, int octaves);

}  // namespace etendue
