// Metal: a mirror, or microfacets of mirrors.
#pragma once

#include "framework/materials/fresnel.h"
#include "framework/materials/lobe.h"
#include "framework/materials/microfacet.h"

namespace etendue {

// alpha = roughness (no remapping); 0 in both: a perfect mirror. `eta` and `k` are relative to the outside, per channel.
// With `k` 0 and `eta` 1 the Fresnel factor would be 0, so a perfect mirror of given colour uses `tint` with `ideal`.
struct Conductor {
  Rgb eta{1}, k{0};
  Rgb tint{1};         // multiplies the Fresnel factor
  bool ideal = false;  // Fresnel factor 1
  vec2 alpha{0};
  NormalDistribution distribution = NormalDistribution::ggx;

  bool has_specular() const { return alpha == vec2(0); }
  bool has_non_specular() const { return alpha != vec2(0); }
  bool is_anisotropic() const { return alpha.x != alpha.y; }  // turns with the surface's tangent
  bool uses_uvs() const { return is_anisotropic(); }

  template <class F>
  struct Lobes;
};

template <class F>
struct Conductor::Lobes {
  static constexpr bool transmits = false;
  const Conductor& m;

  template <class Colours>
  Lobes(const Conductor& material, const Colours&) : m(material) {}

  Microfacets facets() const { return {m.alpha, m.distribution}; }
  Vec3<F> fresnel(F cosine) const { return m.ideal ? Vec3<F>(1.0f) : fresnel_conductor(cosine, m.eta, m.k); }

  Vec3<F> evaluate(const Vec3<F>& wo, const Vec3<F>& wi, Mask<F>) const {
    const Mask<F> up = wi.z > 0;
    if (m.has_specular() || !any(up)) return Vec3<F>(0.0f);
    const Microfacets facets = this->facets();
    const Vec3<F> h = normalize(wo + wi);
    return select(up, m.tint * fresnel(dot(wo, h)) * (facets.density(h) * facets.masking_shadowing(wo, wi) / (4 * wo.z)),
                  Vec3<F>(0.0f));
  }
  F pdf(const Vec3<F>& wo, const Vec3<F>& wi, Mask<F>) const {
    const Mask<F> up = wi.z > 0;
    if (m.has_specular() || !any(up)) return 0.0f;
    const Vec3<F> h = normalize(wo + wi);
    return select(up, facets().normal_density(wo, h) / (4 * dot(wo, h)), F(0.0f));
  }
  BsdfSampleOf<F> sample(const Vec3<F>& wo, Mask<F> below, F, const Vec2<F>& u, TransportMode) const {
    if (!m.has_specular()) {
      const Vec3<F> wi = mirrored_at(wo, facets().sample_normal(wo, u));
      return weighed<F>(*this, wo, wi, below, wi.z > 0);
    }
    BsdfSampleOf<F> s;
    s.wi = reflect_about_normal(wo);
    s.weight = m.tint * fresnel(wo.z);
    s.specular = true;
    return s;
  }
};

}  // namespace etendue
