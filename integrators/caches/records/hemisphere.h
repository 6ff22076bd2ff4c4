// Irradiance and its gradients from one stratified hemisphere of samples ([Ward1992]).
//
// M x N strata of equal cosine-weighted solid angle: sin^2(theta) in M steps, phi in N. Gradients cost nothing beyond the
// samples: rotation from their angles, translation from the differences between neighbouring strata, each taken to lie at the
// nearer of the two distances. One deviation: the tangent of the sampled angle in [Ward1992], whose variance grows without
// bound towards the horizon, is replaced by its mean over the stratum.
#pragma once

#include "integrators/paths/hemisphere_strata.h"

#include <span>

namespace etendue {

struct HemisphereSample {
  Rgb radiance{0};
  float distance = infinity;   // to what was seen
  vec3 direction{0};           // unit, world; where it was sampled
  vec3 normal{0};              // geometric, of what was seen; 0 where nothing was
  float photon_footprint = 0;  // as PathSample::first_photon_footprint
};

// A symmetric matrix over the tangent plane, in the axes of Frame::from_normal.
struct TangentMatrix {
  double xx = 0, xy = 0, yy = 0;

  TangentMatrix& operator+=(const TangentMatrix& o) { return xx += o.xx, xy += o.xy, yy += o.yy, *this; }
  TangentMatrix operator*(double s) const { return {xx * s, xy * s, yy * s}; }
};

struct IrradianceEstimate {
  Rgb irradiance{0};
  float inverse_distance = 0;  // mean over the samples, of 1 / distance
  float nearest = infinity;    // least distance
  // The variance of the irradiance's luminance, from the differences of neighbouring strata. Their real contrast counts as
  // noise too, so this is an upper estimate.
  float variance = 0;
  // Likewise, of the noise that all estimates from one `source` have in common, which does not average out between them.
  float shared_variance = 0;
  std::uint32_t source = 0;
  // Column c belongs to channel c, world space: at normal n' and displacement d (in the tangent plane) the irradiance is
  // E_c + dot(cross(n, n'), rotation[c]) + dot(d, translation[c]) to first order.
  mat3 rotation{0}, translation{0};
  // Second derivatives by which an error metric judges, 1 / m^2 (see irradiance_hessian.h): of the irradiance's luminance, and
  // the geometric bound; zero where the metric has no use for them.
  TangentMatrix hessian, geometric;

  float harmonic_distance() const { return inverse_distance > 0 ? 1 / inverse_distance : infinity; }
  // Becomes the mean of `passes` equal estimates, of which `next` is the last.
  void average_in(const IrradianceEstimate& next, int passes);
};

// Variance of the irradiance's luminance due to the photon map in which the rays of a hemisphere, and of its neighbours, end. A
// stratum sees as many photons as its footprint holds at the area per photon there (photon_footprint); their number is Poisson
// distributed, whether or not the kernels of neighbouring rays share them.
float photon_variance(const HemisphereStrata& strata, std::span<const HemisphereSample> samples, const Frame& frame);

// `samples`: one per stratum, in order.
IrradianceEstimate estimate_irradiance(const HemisphereStrata& strata, std::span<const HemisphereSample> samples,
                                       const Frame& frame);

}  // namespace etendue
