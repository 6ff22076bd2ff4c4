// The clear sky of [Preetham1999] and the sun behind it, y up.
//
// Deviations: luminance becomes radiance by 683 lm/W at every wavelength, which keeps the picture's balance and not its units;
// below the horizon the sky is black, as in Mitsuba.
#pragma once

#include "framework/scene/light.h"

namespace etendue {

// 512 x 256 texels in the axes of an envmap of Mitsuba's: the caller sets light_to_world.
EnvironmentLight preetham_sky(const vec3& towards_sun, float turbidity);
// Of a surface that faces the sun, W/m^2, dimmed by air and haze.
Rgb sun_irradiance(const vec3& towards_sun, float turbidity);

}  // namespace etendue
