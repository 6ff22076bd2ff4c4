// Direct light at a vertex: one light sample, MIS-weighted with BSDF sampling.
#pragma once

#include "framework/core/sampler.h"
#include "framework/integrator.h"
#include "framework/transport/bsdf.h"

#include <optional>
#include <string>

namespace etendue {

// How light sampling and BSDF sampling share the work ([Veach1995]): by the power heuristic (beta = 2) or the balance
// heuristic, or one of them alone. Lights that no ray can hit (point, spot, directional) are sampled in every mode.
enum class MisMode : std::uint8_t { power, balance, light, bsdf };

MisMode parse_mis(const std::string& name);  // of a checked parameter

// Weight of the strategy with density `mine` where another has `other`.
template <class F>
F mis_weight(MisMode mode, F mine, F other) {
  if (mode == MisMode::balance) return mine / (mine + other);
  return select(mine > 1e18f, F(1.0f), mine * mine / (mine * mine + other * other));
}

// Weight of emission found by a BSDF sample of density pdf_bsdf (not from a delta lobe) where light sampling has pdf_light.
inline float emission_weight(MisMode mode, float pdf_bsdf, float pdf_light) {
  if (mode == MisMode::light) return 0;
  if (mode == MisMode::bsdf) return 1;
  return mis_weight(mode, pdf_bsdf, pdf_light);
}

// What one light sample sends through `point` towards wo, with its MIS weight, if nothing blocks its shadow ray.
struct DirectLight {
  Rgb radiance;
  Ray shadow_ray;
  float pdf_solid_angle;  // of the light sample; 0: a light that no ray can hit
};

// One light sample; none where no light can come of it. With MisMode::light its mean is the whole direct light. It always draws
// one 2-D number. Directions of a BSDF density below `followed_above` (1/sr) are left to light samples: the caller follows no
// BSDF sample there.
std::optional<DirectLight> sample_direct_light(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf,
                                               const vec3& wo, Sampler& sampler, MisMode mode, float followed_above = 0);

// Its radiance, or black where the shadow ray is blocked.
Rgb direct_light(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, Sampler& sampler,
                 MisMode mode, float followed_above = 0);

}  // namespace etendue
