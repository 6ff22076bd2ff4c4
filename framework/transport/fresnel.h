// Fresnel reflectance of interfaces.
#pragma once

#include "framework/core/vec.h"

namespace etendue {

// Unpolarised reflectance of a dielectric. cos_in > 0 is the incident cosine, eta the index beyond the interface over the index
// before it. `cos_transmitted` gets the refracted cosine, 0 at total internal reflection.
inline float fresnel_dielectric(float cos_in, float eta, float* cos_transmitted = nullptr) {
  const float sin2_t = (1 - cos_in * cos_in) / (eta * eta);
  if (sin2_t >= 1) {
    if (cos_transmitted) *cos_transmitted = 0;
    return 1;
  }
  const float cos_t = std::sqrt(1 - sin2_t);
  if (cos_transmitted) *cos_transmitted = cos_t;
  const float parallel = (eta * cos_in - cos_t) / (eta * cos_in + cos_t);
  const float perpendicular = (cos_in - eta * cos_t) / (cos_in + eta * cos_t);
  return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

// Unpolarised reflectance of a conductor with complex index eta + i k, per channel ([BornWolf1999] 14.4).
inline Rgb fresnel_conductor(float cos_in, const Rgb& eta, const Rgb& k) {
  const float c2 = cos_in * cos_in, s2 = 1 - c2;
  Rgb reflectance;
  for (int i = 0; i < 3; ++i) {
    const float e2 = eta[i] * eta[i], k2 = k[i] * k[i];
    const float t0 = e2 - k2 - s2;
    const float a2b2 = std::sqrt(t0 * t0 + 4 * e2 * k2);
    const float a = std::sqrt(std::max(0.0f, 0.5f * (a2b2 + t0)));
    const float t1 = a2b2 + c2, t2 = 2 * a * cos_in;
    const float perpendicular = (t1 - t2) / (t1 + t2);
    const float t3 = c2 * a2b2 + s2 * s2, t4 = t2 * s2;
    reflectance[i] = 0.5f * perpendicular * (1 + (t3 - t4) / (t3 + t4));
  }
  return reflectance;
}

// Hemispherical average of fresnel_dielectric over cosine-weighted directions arriving from outside, eta > 1: the closed form
// of [Duntley1942].
inline float fresnel_average(float eta) {
  const double n = eta;
  if (n < 1.001) return 0;
  const double n2 = n * n, n4 = n2 * n2;
  return static_cast<float>(0.5 + (n - 1) * (3 * n + 1) / (6 * (n + 1) * (n + 1)) +
                            n2 * (n2 - 1) * (n2 - 1) / std::pow(n2 + 1, 3) * std::log((n - 1) / (n + 1)) -
                            2 * n2 * n * (n2 + 2 * n - 1) / ((n2 + 1) * (n4 - 1)) +
                            8 * n4 * (n4 + 1) / ((n2 + 1) * (n4 - 1) * (n4 - 1)) * std::log(n));
}

}  // namespace etendue
