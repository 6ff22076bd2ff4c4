// Fresnel reflectance of interfaces, over lanes.
#pragma once

#include "framework/core/elementary.h"
#include "framework/core/lanes.h"

namespace etendue {

// Unpolarised reflectance of a dielectric. cos_in > 0 is the incident cosine, eta the index beyond the interface over the index
// before it. `cos_transmitted` gets the refracted cosine, 0 at total internal reflection.
template <class F>
F fresnel_dielectric(F cos_in, std::type_identity_t<F> eta, F* cos_transmitted = nullptr) {
  const F sin2_t = (1 - cos_in * cos_in) / (eta * eta);
  const Mask<F> total = sin2_t >= 1;
  const F cos_t = select(total, F(0.0f), sqrt(1 - sin2_t));
  if (cos_transmitted) *cos_transmitted = cos_t;
  const F parallel = (eta * cos_in - cos_t) / (eta * cos_in + cos_t);
  const F perpendicular = (cos_in - eta * cos_t) / (cos_in + eta * cos_t);
  return select(total, F(1.0f), 0.5f * (parallel * parallel + perpendicular * perpendicular));
}

// Unpolarised reflectance of a conductor with complex index eta + i k ([BornWolf1999] 14.4).
template <class F>
F fresnel_conductor(F cos_in, float eta, float k) {
  const float e2 = eta * eta, k2 = k * k;
  const F c2 = cos_in * cos_in, s2 = 1 - c2;
  const F t0 = e2 - k2 - s2;
  const F a2b2 = sqrt(t0 * t0 + 4 * e2 * k2);
  const F a = sqrt(max(0.0f, 0.5f * (a2b2 + t0)));
  const F t1 = a2b2 + c2, t2 = 2 * a * cos_in;
  const F perpendicular = (t1 - t2) / (t1 + t2);
  const F t3 = c2 * a2b2 + s2 * s2, t4 = t2 * s2;
  return 0.5f * perpendicular * (1 + (t3 - t4) / (t3 + t4));
}

// The same per channel.
template <class F>
Vec3<F> fresnel_conductor(F cos_in, const Rgb& eta, const Rgb& k) {
  return {fresnel_conductor(cos_in, eta.x, k.x), fresnel_conductor(cos_in, eta.y, k.y), fresnel_conductor(cos_in, eta.z, k.z)};
}

// Hemispherical average of fresnel_dielectric over cosine-weighted directions arriving from outside, eta > 1: the closed form
// of [Duntley1942].
inline float fresnel_average(float eta) {
  const double n = eta;
  if (n < 1.001) return 0;
  const double n2 = n * n, n4 = n2 * n2;
  return static_cast<float>(0.5 + (n - 1) * (3 * n + 1) / (6 * (n + 1) * (n + 1)) +
                            n2 * (n2 - 1) * (n2 - 1) / math::pow(n2 + 1, 3) * math::log((n - 1) / (n + 1)) -
                            2 * n2 * n * (n2 + 2 * n - 1) / ((n2 + 1) * (n4 - 1)) +
                            8 * n4 * (n4 + 1) / ((n2 + 1) * (n4 - 1) * (n4 - 1)) * math::log(n));
}

}  // namespace etendue
