// Direct light at a vertex: one light sample, MIS-weighted with BSDF sampling.
#pragma once

#include "framework/core/sampler.h"
#include "framework/integrator.h"
#include "framework/transport/bsdf.h"
#include "framework/transport/mis.h"

#include <optional>

namespace etendue {

// The light that one light sample sends through `point` towards wo, with its MIS weight, if nothing blocks its shadow ray.
struct DirectLight {
  Rgb radiance;
  Ray shadow_ray;
};

// One light sample; none where no light can come of it. With MisMode::light its mean is the whole direct light. It always draws
// one 2-D number. Directions of a BSDF density below `followed_above` (1/sr) are left to light samples: the caller follows no
// BSDF sample there. `followed`: the share of vertices at which it follows one; emission it meets there counts 1 / followed
// times.
std::optional<DirectLight> sample_direct_light(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf,
                                               const vec3& wo, Sampler& sampler, MisMode mode, float followed_above = 0,
                                               float followed = 1);

// Its radiance, or black where the shadow ray is blocked.
Rgb direct_light(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, Sampler& sampler,
                 MisMode mode, float followed_above = 0);

}  // namespace etendue
