// Everything that the materials of this room have in common.
//
// A material is one file: a struct of its parameters, and `Lobes<F>`, what light does at a point of it, over a lane type
// (framework/core/lanes.h): the point is one, or one in each lane, all of the same material.
//
//   evaluate(wo, wi, below)                  f |cos wi| for radiance
//   pdf(wo, wi, below)                       density of `sample`, over solid angle
//   sample(wo, below, u_lobe, u, mode)       a direction by which light arrives
//
// Directions point away from the surface and are local, z along the shading normal, mirrored so that wo.z > 0: `below` says
// where that was done, which matters to what transmits. Delta lobes are reported by `sample` alone.
#pragma once

#include "framework/core/sampling.h"

namespace etendue {

// Radiance travels to the camera, importance to the lights; they differ at refraction (eta^2) and where the shading normal is
// not the geometric one ([Veach1997] 5.2, 5.3).
enum class TransportMode : std::uint8_t { radiance, importance };

template <class F>
struct BsdfSampleOf {
  Vec3<F> wi{0.0f};
  Vec3<F> weight{0.0f};     // f |cos| / pdf; for delta lobes the same with their discrete probability; black: no sample
  F pdf_solid_angle{0.0f};  // 0 for delta lobes
  Mask<F> specular{false};
  Mask<F> transmitted{false};
  F eta{1.0f};  // relative index crossed, for Russian roulette

  explicit operator bool() const { return !is_black(weight); }
};

template <class V>
V reflect_about_normal(const V& w) {
  return {-w.x, -w.y, w.z};
}
template <class V>
V mirrored_at(const V& w, const V& h) {
  return 2 * dot(w, h) * h - w;
}

// A sample of lobes with a density, where `valid`: its weight is the whole BSDF over the whole density. `eta`: the index that
// is crossed by directions with z < 0.
template <class F, class Lobes>
BsdfSampleOf<F> weighed(const Lobes& lobes, const Vec3<F>& wo, const Vec3<F>& wi, Mask<F> below, Mask<F> valid, F eta = 1.0f,
                        TransportMode mode = TransportMode::radiance) {
  BsdfSampleOf<F> s;
  if (!any(valid)) return s;
  const F density = lobes.pdf(wo, wi, below);
  valid = valid & (density > 0);
  if (!any(valid)) return s;
  s.wi = wi;
  s.pdf_solid_angle = density;
  s.weight = select(valid, lobes.evaluate(wo, wi, below) / density, Vec3<F>(0.0f));
  if constexpr (Lobes::transmits) {
    s.transmitted = wi.z < 0;
    s.eta = select(s.transmitted, eta, F(1.0f));
    if (mode == TransportMode::importance && any(s.transmitted))
      s.weight = select(s.transmitted, s.weight * (s.eta * s.eta), s.weight);
  }
  return s;
}

}  // namespace etendue
