// A sheet that scatters light evenly to both sides, such as a leaf or paper: f = reflectance / pi on the side that the light
// comes from, and transmittance / pi beyond.
#pragma once

#include "framework/materials/lobe.h"
#include "framework/materials/texture.h"

namespace etendue {

// The same from both sides. In each channel the two should not exceed 1 together.
struct DiffuseTransmission {
  TexturedRgb reflectance{Rgb(0.25f)}, transmittance{Rgb(0.25f)};

  static constexpr float eta = 1;  // the sheet has no inside

  bool has_specular() const { return false; }
  bool has_non_specular() const { return true; }
  bool uses_uvs() const { return !reflectance.is_constant() || !transmittance.is_constant(); }

  template <class F>
  struct Lobes;
};

template <class F>
struct DiffuseTransmission::Lobes {
  static constexpr bool transmits = true;
  const DiffuseTransmission& m;
  Vec3<F> reflected, passed;

  template <class Colours>
  Lobes(const DiffuseTransmission& material, const Colours& colour)
      : m(material), reflected(colour(material.reflectance)), passed(colour(material.transmittance)) {}

  F reflection_probability() const {
    const F r = mean_component(reflected), sum = r + mean_component(passed);
    return select(sum > 0, r / sum, F(0.5f));
  }
  Vec3<F> evaluate(const Vec3<F>&, const Vec3<F>& wi, Mask<F>) const {
    return select(wi.z > 0, reflected, passed) * (inv_pi * abs(wi.z));
  }
  F pdf(const Vec3<F>&, const Vec3<F>& wi, Mask<F>) const {
    const F up = reflection_probability();
    return select(wi.z > 0, up, 1 - up) * (inv_pi * abs(wi.z));
  }
  BsdfSampleOf<F> sample(const Vec3<F>&, Mask<F>, F u_lobe, const Vec2<F>& u, TransportMode) const {
    const F up = reflection_probability();
    const Mask<F> reflects = u_lobe < up;
    const F share = select(reflects, up, 1 - up);
    BsdfSampleOf<F> s;
    s.wi = sample_cosine_hemisphere(u);
    s.pdf_solid_angle = share * (inv_pi * s.wi.z);
    s.weight = select((s.wi.z > 0) & (share > 0), select(reflects, reflected, passed) / share, Vec3<F>(0.0f));
    s.wi.z = select(reflects, s.wi.z, -s.wi.z);
    s.transmitted = !reflects;
    return s;
  }
};

}  // namespace etendue
