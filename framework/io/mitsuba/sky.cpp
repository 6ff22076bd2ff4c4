#include "framework/io/mitsuba/sky.h"

#include "framework/core/elementary.h"
#include "framework/core/fuzzing.h"
#include "framework/io/spectra.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

namespace etendue {

namespace {

constexpr double lumen_per_watt = 683;

struct Perez {
  double a, b, c, d, e;

  double operator()(double cos_theta, double gamma) const {
    const double cos_gamma = math::cos(gamma);
    return (1 + a * math::exp(b / cos_theta)) * (1 + c * math::exp(d * gamma) + e * cos_gamma * cos_gamma);
  }
};

// [Preetham1999] table 2.
Perez luminance_of(double t) {
  return {0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771, -0.0670 * t + 0.3703};
}
Perez x_of(double t) {
  return {-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989, -0.0033 * t + 0.0452};
}
Perez y_of(double t) {
  return {-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537, -0.0109 * t + 0.0529};
}

struct Zenith {
  double luminance, x, y;  // cd/m^2
};

// [Preetham1999] appendix A.2.
Zenith zenith_of(double t, double sun) {
  const double chi = (4.0 / 9 - t / 120) * (std::numbers::pi - 2 * sun);
  const double s2 = sun * sun, s3 = s2 * sun, t2 = t * t;
  return {1000 * ((4.0453 * t - 4.9710) * math::tan(chi) - 0.2155 * t + 2.4192),
          t2 * (0.00166 * s3 - 0.00375 * s2 + 0.00209 * sun) + t * (-0.02903 * s3 + 0.06377 * s2 - 0.03202 * sun + 0.00394) +
              (0.11693 * s3 - 0.21196 * s2 + 0.06052 * sun + 0.25886),
          t2 * (0.00275 * s3 - 0.00610 * s2 + 0.00317 * sun) + t * (-0.04214 * s3 + 0.08970 * s2 - 0.04153 * sun + 0.00516) +
              (0.15346 * s3 - 0.26756 * s2 + 0.06670 * sun + 0.26688)};
}

Rgb from_xy_luminance(double x, double y, double luminance) {
  const double scale = luminance / y;
  return Rgb(glm::max(xyz_to_rgb({scale * x, luminance, scale * (1 - x - y)}), dvec3(0)));
}

// Since noon of 1 January 2000, in days.
double days_since_2000(const SunTime& when) {
  const std::chrono::sys_days date = std::chrono::year(when.year) / when.month / when.day;
  const std::chrono::sys_days epoch = std::chrono::year(2000) / 1 / 1;
  return static_cast<double>((date - epoch).count()) + (static_cast<double>(when.hour) - when.timezone - 12) / 24;
}

}  // namespace

vec3 towards_sun(const SunTime& when) {
  constexpr double degree = std::numbers::pi / 180;
  const double days = days_since_2000(when);
  const double omega = 2.1429 - 0.0010394594 * days, mean_longitude = 4.8950630 + 0.017202791698 * days,
               anomaly = 6.2400600 + 0.0172019699 * days;
  const double longitude = mean_longitude + 0.03341607 * math::sin(anomaly) + 0.00034894 * math::sin(2 * anomaly) - 0.0001134 -
                           0.0000203 * math::sin(omega);
  const double obliquity = 0.4090928 - 6.2140e-9 * days + 0.0000396 * math::cos(omega);
  const double ascension = math::atan2(math::cos(obliquity) * math::sin(longitude), math::cos(longitude)),
               declination = math::asin(math::sin(obliquity) * math::sin(longitude));
  const double universal_hour = static_cast<double>(when.hour) - when.timezone;
  const double sidereal_hour = 6.6974243242 + 0.0657098283 * days + universal_hour;
  const double hour_angle = (15 * sidereal_hour + when.longitude) * degree - ascension, latitude = when.latitude * degree;
  const dvec3 up_north_east{
      math::cos(latitude) * math::cos(hour_angle) * math::cos(declination) + math::sin(declination) * math::sin(latitude),
      math::sin(declination) * math::cos(latitude) - math::cos(declination) * math::sin(latitude) * math::cos(hour_angle),
      -math::cos(declination) * math::sin(hour_angle)};
  return vec3(up_north_east.z, up_north_east.x, -up_north_east.y);
}

EnvironmentLight preetham_sky(const vec3& towards_sun, float turbidity) {
  const double t = std::max(turbidity, 1.7f);  // the model's least
  const double sun = math::acos(std::clamp(towards_sun.y, 0.02f, 1.0f));
  const Zenith zenith = zenith_of(t, sun);
  const Perez luminance = luminance_of(t), x = x_of(t), y = y_of(t);
  EnvironmentLight light{
      .scale = Rgb(1), .size = unless_fuzzed(ivec2(512, 256), ivec2(16, 8)), .texels = {}, .light_to_world = {}};
  light.texels.resize(static_cast<std::size_t>(light.size.x) * light.size.y);
  for (int row = 0; row < light.size.y / 2; ++row)
    for (int column = 0; column < light.size.x; ++column) {
      const double theta = (row + 0.5) / light.size.y * std::numbers::pi,
                   phi = (column + 0.5) / light.size.x * 2 * std::numbers::pi;
      const dvec3 direction{math::sin(theta) * math::sin(phi), math::cos(theta), -math::sin(theta) * math::cos(phi)};
      const double gamma = math::acos(std::clamp(glm::dot(direction, dvec3(towards_sun)), -1.0, 1.0));
      const auto relative = [&](const Perez& f) { return f(std::max(math::cos(theta), 0.01), gamma) / f(1, sun); };
      light.texels[static_cast<std::size_t>(row) * light.size.x + column] =
          from_xy_luminance(zenith.x * relative(x), zenith.y * relative(y),
                            std::max(zenith.luminance * relative(luminance), 0.0) / lumen_per_watt);
    }
  return light;
}

// The sun has 128 klx outside of the atmosphere, which Rayleigh's and the haze's optical depths at 610, 550 and 465 nm weaken.
Rgb sun_irradiance(const vec3& towards_sun, float turbidity) {
  const double height = std::max(towards_sun.y, 0.02f);
  const double air_mass = 1 / height, beta = 0.04608 * turbidity - 0.04586;
  constexpr double wavelengths[] = {0.61, 0.55, 0.465};  // micrometres
  Rgb irradiance;
  for (int c = 0; c < 3; ++c) {
    const double rayleigh = 0.008735 * math::pow(wavelengths[c], -4.08),
                 haze = std::max(beta, 0.0) * math::pow(wavelengths[c], -1.3);
    irradiance[c] = static_cast<float>(128'000 / lumen_per_watt * math::exp(-(rayleigh + haze) * air_mass));
  }
  return irradiance;
}

}  // namespace etendue
