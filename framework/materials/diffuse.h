// A Lambertian surface, the same on both sides: f = reflectance / pi.
#pragma once

#include "framework/materials/lobe.h"
#include "framework/materials/texture.h"

namespace etendue {

struct Diffuse {
  TexturedRgb reflectance{Rgb(0.5f)};

  bool has_specular() const { return false; }
  bool has_non_specular() const { return true; }
  bool uses_uvs() const { return !reflectance.is_constant(); }

  template <class F>
  struct Lobes;
};

template <class F>
struct Diffuse::Lobes {
  static constexpr bool transmits = false;
  Vec3<F> albedo;

  template <class Colours>
  Lobes(const Diffuse& m, const Colours& colour) : albedo(colour(m.reflectance)) {}

  Vec3<F> evaluate(const Vec3<F>&, const Vec3<F>& wi, Mask<F>) const {
    return select(wi.z > 0, albedo * (inv_pi * wi.z), Vec3<F>(0.0f));
  }
  F pdf(const Vec3<F>&, const Vec3<F>& wi, Mask<F>) const { return select(wi.z > 0, inv_pi * wi.z, F(0.0f)); }
  BsdfSampleOf<F> sample(const Vec3<F>&, Mask<F>, F, const Vec2<F>& u, TransportMode) const {
    BsdfSampleOf<F> s;
    s.wi = sample_cosine_hemisphere(u);
    s.weight = select(s.wi.z > 0, albedo, Vec3<F>(0.0f));
    s.pdf_solid_angle = inv_pi * s.wi.z;
    return s;
  }
};

}  // namespace etendue
