// Irradiance and its gradients from one stratified hemisphere of samples ([Ward1992]).
//
// M x N strata of equal cosine-weighted solid angle: sin^2(theta) in M steps, phi in N. Gradients cost nothing beyond the
// samples: rotation from their angles, translation from the differences between neighbouring strata, each taken to lie at the
// nearer of the two distances. One deviation: where [Ward1992] has the tangent of the sampled angle, whose variance grows
// without bound towards the horizon, stands its mean over the stratum.
#pragma once

#include "framework/core/vec.h"

#include <span>

namespace etendue {

struct HemisphereSample {
  Rgb radiance{0};
  float distance = infinity;  // to what was seen
};

struct HemisphereStrata {
  int theta = 1, phi = 1;

  // About `samples` strata, as square as they can be: N ~ pi M.
  static HemisphereStrata of(int samples);
  int count() const { return theta * phi; }
  // Unit, about +z; stratum i = j * phi + k, `u` jitters within it.
  vec3 direction(int i, const vec2& u) const;
};

struct IrradianceEstimate {
  Rgb irradiance{0};
  float harmonic_distance = infinity;  // harmonic mean of the samples' distances
  // Column c belongs to channel c, world space: at normal n' and displacement d (in the tangent plane) the irradiance is
  // E_c + dot(cross(n, n'), rotation[c]) + dot(d, translation[c]) to first order.
  mat3 rotation{0}, translation{0};
};

// `samples`: one per stratum, in order.
IrradianceEstimate estimate_irradiance(const HemisphereStrata& strata, std::span<const HemisphereSample> samples,
                                       const Frame& frame);

}  // namespace etendue
