// From spectra to the linear RGB (sRGB primaries, D65 white) that everything else computes with.
#pragma once

#include "framework/core/vec.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

// Piecewise linear over wavelengths in nm that increase strictly.
struct SampledSpectrum {
  std::vector<double> wavelengths, values;
  double at(double wavelength) const;      // the end values go on beyond the ends
  double within(double wavelength) const;  // 0 beyond the ends
};

// XYZ to linear RGB (IEC 61966-2-1); components are negative for colours outside sRGB.
dvec3 xyz_to_rgb(const dvec3& xyz);

// A reflectance or an index becomes its mean over the colour-matching functions under D65, so that a constant stays itself.
Rgb surface_rgb(const SampledSpectrum& spectrum);          // the end values go on beyond the ends
Rgb bounded_surface_rgb(const SampledSpectrum& spectrum);  // nothing lies beyond the ends, as in pbrt-v4

// A light is scaled to luminance 1, as pbrt-v4 scales its lights, of which nothing lies beyond the ends.
Rgb light_rgb(const SampledSpectrum& spectrum);
// RGB as pbrt-v3 has it for lights, surfaces and indices: the integral under light of equal energy. A constant of 1 has
// luminance 1 and is pinkish, and the end values go on beyond the ends.
Rgb version3_rgb(const SampledSpectrum& spectrum);

// Planck's law at a temperature in kelvin, scaled to luminance 1, or (as pbrt-v3 has it) to a largest spectral value of 1.
Rgb blackbody_rgb(double kelvin);
Rgb blackbody_rgb_of_unit_peak(double kelvin);

// The integral, as Mitsuba's RGB modes take it of lights: a constant of 1 has luminance 1, and nothing lies beyond the ends.
Rgb equal_energy_rgb(const SampledSpectrum& spectrum);
// Planck's radiance in W/(m^2 sr nm), integrated in the same way.
Rgb blackbody_radiance_rgb(double kelvin);

// Complex index of a metal by its symbol: Ag Al Au Cu CuZn MgO TiO2.
struct MetalIndex {
  std::string_view name;
  Rgb eta, k;
};
std::span<const MetalIndex> metals();

// Refractive index of a glass at the d line (587.6 nm), by pbrt's names: glass-BK7 ...
struct GlassIndex {
  std::string_view name;
  float eta;
};
std::span<const GlassIndex> glasses();

}  // namespace etendue
