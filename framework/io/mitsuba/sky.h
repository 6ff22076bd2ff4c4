// The clear sky of [Preetham1999] and the sun behind it, y up.
//
// Deviations: luminance becomes radiance by 683 lm/W at every wavelength, which keeps the picture's balance and not its units;
// below the horizon the sky is black, as in Mitsuba.
#pragma once

#include "framework/scene/light.h"

namespace etendue {

// The place and time at which the sun is seen; the defaults are Mitsuba's, a summer's afternoon in Tokyo.
struct SunTime {
  int year = 2010, month = 7, day = 10;
  float hour = 15;                                                 // of the time zone's clock, with its minutes
  float latitude = 35.6894f, longitude = 139.6917f, timezone = 9;  // degrees, and hours
};
// The algorithm is that of [BlancoMuriel2001]. Up is +y, north -z and east +x.
vec3 towards_sun(const SunTime& when);

// 512 x 256 texels in the axes of an envmap of Mitsuba's: the caller sets light_to_world.
EnvironmentLight preetham_sky(const vec3& towards_sun, float turbidity);
// The irradiance of a surface that faces the sun, in W/m^2, which air and haze have dimmed.
Rgb sun_irradiance(const vec3& towards_sun, float turbidity);

}  // namespace etendue
