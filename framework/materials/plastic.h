// A diffuse base under a smooth or rough dielectric coat.
#pragma once

#include "framework/materials/coat.h"
#include "framework/materials/fresnel.h"
#include "framework/materials/lobe.h"
#include "framework/materials/microfacet.h"
#include "framework/materials/texture.h"

namespace etendue {

// The base is lit and seen through the coat's Fresnel transmission, with the light reflected back inside summed as a geometric
// series. Lossless for albedo 1 when smooth and clear; a rough coat keeps the smooth one's transmission. (pbrt-v4's
// coateddiffuse walks the layers at random instead.)
struct Plastic {
  TexturedRgb reflectance{Rgb(0.5f)};
  Coat coat = 1.5f;
  float alpha = 0;  // of the coat; 0: smooth
  NormalDistribution distribution = NormalDistribution::ggx;

  bool has_specular() const { return alpha == 0; }
  bool has_non_specular() const { return true; }
  bool uses_uvs() const { return !reflectance.is_constant(); }

  template <class F>
  struct Lobes;
};

template <class F>
struct Plastic::Lobes {
  static constexpr bool transmits = false;
  const Coat& coat;
  const float eta, alpha;
  const NormalDistribution distribution;
  const Vec3<F> albedo;
  const Vec3<F> base_gain;  // albedo / (eta^2 (1 - albedo F_internal))

  template <class Colours>
  Lobes(const Plastic& m, const Colours& colour)
      : coat(m.coat),
        eta(coat.eta()),
        alpha(m.alpha),
        distribution(m.distribution),
        albedo(colour(m.reflectance)),
        base_gain(albedo / (eta * eta * (1.0f - albedo * coat.internal_reflectance()))) {}

  Microfacets facets() const { return {vec2(alpha), distribution}; }
  // The coat is chosen by what it reflects against what the base does under a clear one.
  F coat_probability(F fresnel) const {
    const F base = (1 - fresnel) * mean_component(albedo);
    return select(base == 0, F(1.0f), min(max(fresnel / (fresnel + base), 0.05f), 0.95f));
  }
  Vec3<F> evaluate(const Vec3<F>& wo, const Vec3<F>& wi, Mask<F>) const {
    const Mask<F> up = wi.z > 0;
    if (!any(up)) return Vec3<F>(0.0f);
    // The base: transmission both ways, internal reflections summed.
    F cos_o, cos_i;
    F through = (1 - fresnel_dielectric(wo.z, eta, &cos_o)) * (1 - fresnel_dielectric(wi.z, eta, &cos_i)) * inv_pi;
    if (coat.depth() > 0) through *= coat.passing(1 / cos_o + 1 / cos_i);
    const Vec3<F> base = base_gain * through * wi.z;
    if (alpha == 0) return select(up, base, Vec3<F>(0.0f));
    const Microfacets facets = this->facets();
    const Vec3<F> h = normalize(wo + wi);
    const F lobe = fresnel_dielectric(dot(wo, h), eta) * facets.density(h) * facets.masking_shadowing(wo, wi) / (4 * wo.z);
    return select(up, base + lobe, Vec3<F>(0.0f));
  }
  F pdf(const Vec3<F>& wo, const Vec3<F>& wi, Mask<F>) const {
    const Mask<F> up = wi.z > 0;
    if (!any(up)) return 0.0f;
    const F chance = coat_probability(fresnel_dielectric(wo.z, eta));
    const F base = (1 - chance) * inv_pi * wi.z;
    if (alpha == 0) return select(up, base, F(0.0f));
    const Vec3<F> h = normalize(wo + wi);
    return select(up, base + chance * facets().normal_density(wo, h) / (4 * dot(wo, h)), F(0.0f));
  }
  BsdfSampleOf<F> sample(const Vec3<F>& wo, Mask<F> below, F u_lobe, const Vec2<F>& u, TransportMode) const {
    const F fresnel = fresnel_dielectric(wo.z, eta);
    const F chance = coat_probability(fresnel);
    const Mask<F> in_base = u_lobe >= chance;
    Vec3<F> wi{0.0f};
    if (any(in_base)) wi = sample_cosine_hemisphere(u);
    if (alpha != 0) {
      if (!all(in_base)) wi = select(in_base, wi, mirrored_at(wo, facets().sample_normal(wo, u)));
      return weighed<F>(*this, wo, wi, below, (wi.z > 0) | in_base);
    }
    BsdfSampleOf<F> s = weighed<F>(*this, wo, wi, below, in_base);
    s.specular = !in_base;
    s.wi = select(in_base, s.wi, reflect_about_normal(wo));
    s.weight = select(in_base, s.weight, Vec3<F>(fresnel / chance));
    s.pdf_solid_angle = select(in_base, s.pdf_solid_angle, F(0.0f));
    return s;
  }
};

}  // namespace etendue
