// Glass, water: reflection and refraction, smooth or through microfacets ([Walter2007]); and panes of it.
#pragma once

#include "framework/materials/fresnel.h"
#include "framework/materials/lobe.h"
#include "framework/materials/microfacet.h"

namespace etendue {

// eta: inside over outside, the outside being where the geometric normal points.
struct Dielectric {
  float eta = 1.5f;
  float alpha = 0;
  Rgb reflect_tint{1}, transmit_tint{1};
  NormalDistribution distribution = NormalDistribution::ggx;
  bool thin = false;  // both sides of a smooth pane: light passes straight on, and eta is that of the pane from either side

  bool has_specular() const { return alpha == 0; }
  bool has_non_specular() const { return alpha != 0; }
  bool uses_uvs() const { return false; }

  template <class F>
  struct Lobes;
};

template <class F>
struct Dielectric::Lobes {
  static constexpr bool transmits = true;
  const Dielectric& m;

  template <class Colours>
  Lobes(const Dielectric& material, const Colours&) : m(material) {}

  Microfacets facets() const { return {vec2(m.alpha), m.distribution}; }
  // The index beyond the surface over the one that wo is in.
  F eta(Mask<F> below) const { return select(below, F(1 / m.eta), F(m.eta)); }

  // The half vector of refraction, or of reflection; z > 0. Zero where no microfacet serves ([Walter2007] eq. 13, 16).
  static Vec3<F> half_vector(const Vec3<F>& wo, const Vec3<F>& wi, F eta) {
    const Vec3<F> h = select(wi.z > 0, wo + wi, wo + eta * wi);
    const F far = length(h);
    const Vec3<F> unit = h / far;
    return select(far > 0, select(unit.z < 0, -unit, unit), Vec3<F>(0.0f));
  }
  // Solid angle of h per solid angle of wi at refraction ([Walter2007] eq. 17).
  static F refraction_jacobian(F out_h, F in_h, F eta) { return eta * eta * abs(in_h) / square(out_h + eta * in_h); }

  Vec3<F> evaluate(const Vec3<F>& wo, const Vec3<F>& wi, Mask<F> below) const {
    if (m.has_specular()) return Vec3<F>(0.0f);
    const Microfacets facets = this->facets();
    const F eta = this->eta(below);
    const Vec3<F> h = half_vector(wo, wi, eta);
    const F out_h = dot(wo, h), in_h = dot(wi, h);
    const Mask<F> met = (out_h > 0) & (in_h * wi.z > 0), reflected = wi.z > 0;
    Vec3<F> value{0.0f};
    if (!any(met)) return value;
    const F fresnel = fresnel_dielectric(out_h, eta);
    if (any(reflected))
      value = Vec3<F>(m.reflect_tint) * (fresnel * facets.density(h) * facets.masking_shadowing(wo, wi) / (4 * wo.z));
    if (!all(reflected)) {
      const F masking = facets.masking_shadowing(wo, Vec3<F>(wi.x, wi.y, -wi.z));
      // [Walter2007] eq. 21 times |cos wi|, over eta^2: radiance spreads as it leaves the denser side.
      const F refracted =
          (1 - fresnel) * facets.density(h) * masking * out_h * refraction_jacobian(out_h, in_h, eta) / (wo.z * eta * eta);
      value = select(reflected, value, Vec3<F>(m.transmit_tint) * refracted);
    }
    return select(met, value, Vec3<F>(0.0f));
  }
  F pdf(const Vec3<F>& wo, const Vec3<F>& wi, Mask<F> below) const {
    if (m.has_specular()) return 0.0f;
    const F eta = this->eta(below);
    const Vec3<F> h = half_vector(wo, wi, eta);
    const F out_h = dot(wo, h), in_h = dot(wi, h);
    const Mask<F> met = (out_h > 0) & (in_h * wi.z > 0);
    if (!any(met)) return 0.0f;
    const F fresnel = fresnel_dielectric(out_h, eta);
    const F density = facets().normal_density(wo, h);
    return select(
        met, select(wi.z > 0, fresnel * density / (4 * out_h), (1 - fresnel) * density * refraction_jacobian(out_h, in_h, eta)),
        F(0.0f));
  }
  // With what passes to and fro inside, a pane reflects R + (1 - R)^2 (R + R^3 + ...) = 2 R / (1 + R), R being that of a side.
  BsdfSampleOf<F> sample_pane(const Vec3<F>& wo, F u_lobe) const {
    const F once = fresnel_dielectric(wo.z, F(m.eta));
    const Mask<F> reflects = u_lobe < 2 * once / (1 + once);
    BsdfSampleOf<F> s;
    s.wi = select(reflects, reflect_about_normal(wo), -wo);
    s.specular = true;
    s.transmitted = !reflects;
    s.weight = select(wo.z > 0, select(reflects, Vec3<F>(m.reflect_tint), Vec3<F>(m.transmit_tint)), Vec3<F>(0.0f));
    return s;
  }
  BsdfSampleOf<F> sample(const Vec3<F>& wo, Mask<F> below, F u_lobe, const Vec2<F>& u, TransportMode mode) const {
    if (m.thin) return sample_pane(wo, u_lobe);
    const F eta = this->eta(below);
    const bool smooth = m.has_specular();
    const Vec3<F> h = smooth ? Vec3<F>(0.0f, 0.0f, 1.0f) : facets().sample_normal(wo, u);
    const F out_h = dot(wo, h);
    F cos_t = 0.0f;
    const F fresnel = fresnel_dielectric(out_h, eta, &cos_t);
    const Mask<F> reflects = u_lobe < fresnel;
    const Vec3<F> wi = select(reflects, mirrored_at(wo, h), (out_h / eta - cos_t) * h - wo / eta);
    const Mask<F> valid = (out_h > 0) & (wi.z != 0) & ((wi.z > 0) == reflects);
    if (!smooth) return weighed<F>(*this, wo, wi, below, valid, eta, mode);
    BsdfSampleOf<F> s;
    s.wi = wi;
    s.specular = true;
    s.transmitted = !reflects;
    s.eta = select(reflects, F(1.0f), eta);
    Vec3<F> refracted = m.transmit_tint;
    if (mode == TransportMode::radiance) refracted /= eta * eta;
    s.weight = select(valid, select(reflects, Vec3<F>(m.reflect_tint), refracted), Vec3<F>(0.0f));
    return s;
  }
};

}  // namespace etendue
