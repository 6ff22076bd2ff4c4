// The equal-area octahedral map of the sphere to the square ([Clarberg2008]), in which pbrt-v4 stores environments; and the
// equirectangular ones of others, which look them up between their texels.
#pragma once

#include "framework/io/image/image_file.h"

namespace etendue {

// The direction at a point of the unit square, and back. Unit vectors.
vec3 octahedral_to_direction(const vec2& p);
vec2 direction_to_octahedral(const vec3& direction);

// A square octahedral image (the square's y runs down the rows) as the equirectangular image of an EnvironmentLight, twice as
// wide as high and as high as the square.
RgbImage octahedral_to_equirectangular(const RgbImage& square);

// Where the rows of an equirectangular image lie: the poles are half a row beyond the first and the last, or are those rows, as
// Mitsuba 2 and 3 have it.
enum class RowsOf : std::uint8_t { centres, poles };

// Refines an equirectangular image whose texels are to be interpolated, so that steps are 1/8 of a texel wide, or as little as
// 2^21 texels in all allow: no integrator interpolates environments, whose lights are then sampled as they are seen.
// Throws Error at `where` when the memory that is free does not hold them.
void interpolate_environment(ivec2& size, std::vector<Rgb>& texels, const Location& where, RowsOf rows = RowsOf::centres);

}  // namespace etendue
