// Colour matching by the multi-lobe fits to the CIE 1931 standard observer of [Wyman2013]; illuminant D65 of [CIE2004].

#include "framework/io/spectra.h"

#include "framework/core/elementary.h"

#include <algorithm>
#include <array>

namespace etendue {

dvec3 xyz_to_rgb(const dvec3& c) {
  return {3.2404542 * c.x - 1.5371385 * c.y - 0.4985314 * c.z, -0.9692660 * c.x + 1.8760108 * c.y + 0.0415560 * c.z,
          0.0556434 * c.x - 0.2040259 * c.y + 1.0572252 * c.z};
}

namespace {

double lobe(double wavelength, double centre, double inverse_width_below, double inverse_width_above) {
  const double t = (wavelength - centre) * (wavelength < centre ? inverse_width_below : inverse_width_above);
  return math::exp(-0.5 * t * t);
}

dvec3 cie_xyz(double w) {
  return {
      0.362 * lobe(w, 442.0, 0.0624, 0.0374) + 1.056 * lobe(w, 599.8, 0.0264, 0.0323) - 0.065 * lobe(w, 501.1, 0.0490, 0.0382),
      0.821 * lobe(w, 568.8, 0.0213, 0.0247) + 0.286 * lobe(w, 530.9, 0.0613, 0.0322),
      1.217 * lobe(w, 437.0, 0.0845, 0.0278) + 0.681 * lobe(w, 459.0, 0.0385, 0.0725)};
}

constexpr int first_wavelength = 380, last_wavelength = 780;

// Every 10 nm from 380 nm.
constexpr std::array<double, 41> d65{49.9755, 54.6482, 82.7549, 91.486,  93.4318, 86.6823, 104.865, 117.008, 117.812,
                                     114.861, 115.923, 108.811, 109.354, 107.802, 104.790, 107.689, 104.405, 104.046,
                                     100.000, 96.3342, 95.788,  88.6856, 90.0062, 89.5991, 87.6987, 83.2886, 83.6992,
                                     80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.349,  61.604,  69.8856,
                                     75.087,  63.5927, 46.4182, 66.8054, 63.3828};

double d65_at(int wavelength) {
  const int i = std::min((wavelength - first_wavelength) / 10, 39);
  const double t = (wavelength - first_wavelength) / 10.0 - i;
  return (1 - t) * d65[i] + t * d65[i + 1];
}

// Relative spectral radiance; the constants are those of the 2019 SI.
double planck(double wavelength, double kelvin) {
  constexpr double c = 299792458, h = 6.62607015e-34, k = 1.380649e-23;
  const double metres = wavelength * 1e-9;
  return 2 * h * c * c / (math::pow(metres, 5) * math::expm1(h * c / (metres * k * kelvin)));
}

// Negative components lie outside sRGB: the nearest colour without them.
Rgb in_gamut(const dvec3& c) { return Rgb(glm::max(c, dvec3(0))); }

template <class Spectrum>
dvec3 integrate(const Spectrum& spectrum) {
  dvec3 sum(0);
  for (int w = first_wavelength; w <= last_wavelength; ++w) sum += spectrum(w) * cie_xyz(w);
  return sum;
}

template <class Spectrum>
Rgb of_unit_luminance(const Spectrum& spectrum) {
  const dvec3 xyz = integrate(spectrum);
  return xyz.y > 0 ? in_gamut(xyz_to_rgb(xyz / xyz.y)) : Rgb(0);
}

// The mean, scaled so that a constant of 1 has luminance 1.
template <class Spectrum>
Rgb mean_rgb(const Spectrum& spectrum) {
  const double y_integral = integrate([](int) { return 1.0; }).y;
  return in_gamut(xyz_to_rgb(integrate(spectrum) / y_integral));
}

// The mean under D65, within the range of the values that it is of.
template <class Spectrum>
Rgb mean_under_d65(const Spectrum& spectrum, double low, double high) {
  const dvec3 white = xyz_to_rgb(integrate([](int w) { return d65_at(w); }));
  const dvec3 colour = xyz_to_rgb(integrate([&](int w) { return d65_at(w) * spectrum(w); })) / white;
  return Rgb(glm::clamp(colour, dvec3(low), dvec3(high)));
}

}  // namespace

double SampledSpectrum::at(double wavelength) const {
  const auto above = std::upper_bound(wavelengths.begin(), wavelengths.end(), wavelength);
  if (above == wavelengths.begin()) return values.front();
  if (above == wavelengths.end()) return values.back();
  const auto i = static_cast<std::size_t>(above - wavelengths.begin());
  const double t = (wavelength - wavelengths[i - 1]) / (wavelengths[i] - wavelengths[i - 1]);
  return (1 - t) * values[i - 1] + t * values[i];
}

double SampledSpectrum::within(double wavelength) const {
  return wavelength < wavelengths.front() || wavelength > wavelengths.back() ? 0 : at(wavelength);
}

Rgb surface_rgb(const SampledSpectrum& spectrum) {
  const auto [low, high] = std::minmax_element(spectrum.values.begin(), spectrum.values.end());
  return mean_under_d65([&](int w) { return spectrum.at(w); }, *low, *high);
}

Rgb bounded_surface_rgb(const SampledSpectrum& spectrum) {
  const std::vector<double>& ends = spectrum.wavelengths;
  if (ends.front() <= first_wavelength && ends.back() >= last_wavelength) return surface_rgb(spectrum);
  return mean_under_d65([&](int w) { return spectrum.within(w); }, 0,
                        *std::max_element(spectrum.values.begin(), spectrum.values.end()));
}

Rgb light_rgb(const SampledSpectrum& spectrum) {
  return of_unit_luminance([&](int w) { return spectrum.within(w); });
}

Rgb version3_rgb(const SampledSpectrum& spectrum) {
  return mean_rgb([&](int w) { return spectrum.at(w); });
}

Rgb blackbody_rgb(double kelvin) {
  return of_unit_luminance([&](int w) { return planck(w, kelvin); });
}

Rgb blackbody_rgb_of_unit_peak(double kelvin) {
  constexpr double wien = 2.897771955e6;  // nm K
  const double peak = planck(wien / kelvin, kelvin);
  return mean_rgb([&](int w) { return planck(w, kelvin) / peak; });
}

Rgb blackbody_radiance_rgb(double kelvin) {
  return mean_rgb([&](int w) { return 1e-9 * planck(w, kelvin); });
}

Rgb equal_energy_rgb(const SampledSpectrum& spectrum) {
  return mean_rgb([&](int w) { return spectrum.within(w); });
}

// Fitted, per channel, to the reflectance that the spectral index gives at 45 angles of incidence, averaged over the channel's
// matching function under D65 (gold's red lies outside sRGB and is held to its largest spectral reflectance). The fit's largest
// error in reflectance is 0.004; averaging eta and k themselves would be off by 0.02 for gold. Spectral data: Ag, Al, Au, MgO
// and TiO2 (rutile, extraordinary ray) [Palik1998], Cu [Hagemann1974], CuZn (70 % copper) [Querry1985].
std::span<const MetalIndex> metals() {
  static constexpr std::array<MetalIndex, 7> table{{
      {"Ag", {0.1293f, 0.1253f, 0.1513f}, {4.0919f, 3.3556f, 2.4132f}},
      {"Al", {1.4185f, 0.9321f, 0.5905f}, {7.7181f, 6.6128f, 5.3586f}},
      {"Au", {0.1641f, 0.4040f, 1.5728f}, {4.3642f, 2.3476f, 1.7188f}},
      {"Cu", {0.2023f, 0.9730f, 1.2118f}, {3.9351f, 2.6231f, 2.3660f}},
      {"CuZn", {0.4679f, 0.5220f, 1.1264f}, {4.2286f, 2.6722f, 1.8107f}},
      {"MgO", {1.7338f, 1.7409f, 1.7536f}, {0, 0, 0}},
      {"TiO2", {2.8618f, 2.9562f, 3.1857f}, {0, 0, 0}},
  }};
  return table;
}

// pbrt's F5, F10 and F11 are Schott's SF5, SF10 and SF11.
std::span<const GlassIndex> glasses() {
  static constexpr std::array<GlassIndex, 7> table{{{"glass-BK7", 1.5168f},
                                                    {"glass-BAF10", 1.6700f},
                                                    {"glass-FK51A", 1.4866f},
                                                    {"glass-LASF9", 1.8503f},
                                                    {"glass-F5", 1.6727f},
                                                    {"glass-F10", 1.7283f},
                                                    {"glass-F11", 1.7847f}}};
  return table;
}

}  // namespace etendue
