// Error metrics of irradiance caching: how far a record serves, from what its hemisphere of samples saw.
//
//   split-sphere          harmonic mean distance ([Ward1988]), without bounds
//   bounded-split-sphere  kept between a least and a largest spacing, and no farther than the gradient can be extrapolated
//                         ([Ward1992], [Tabellion2004] for the bounds in pixels)
//   tabellion             least distance, between 1.5 and 10 pixels, and a normal's turn by 10 degrees at most
//                         ([Tabellion2004])
//   radiometric-hessian   second derivatives of patches fixed in space ([Jarosz2012])
//   geometric-hessian     the same with their absolute values, all of unit radiance ([Jarosz2012])
//   occlusion-hessian     second derivatives of the mesh of samples, so that occlusion counts ([Schwarzhaupt2012])
//
// All are stated as a validity radius: at accuracy a a record serves within a times its radius (an ellipse for Hessians).
#pragma once

#include "integrators/caches/records/hemisphere.h"

#include <array>
#include <cstdint>

namespace etendue {

enum class CacheMetric : std::uint8_t {
  split_sphere,
  bounded_split_sphere,
  tabellion,
  radiometric_hessian,
  geometric_hessian,
  occlusion_hessian
};

constexpr auto names_of(CacheMetric) {
  return std::array{"split-sphere",        "bounded-split-sphere", "tabellion",
                    "radiometric-hessian", "geometric-hessian",    "occlusion-hessian"};
}

// Accuracy at which [Tabellion2004]'s kappa is one, and about which [Ward1988]'s a is chosen.
inline constexpr float usual_accuracy = 0.2f;

// Does the metric need second derivatives?
inline bool is_hessian(CacheMetric metric) { return metric >= CacheMetric::radiometric_hessian; }

// An ellipse over the tangent plane: displacement d is as far as sqrt(d.d + (d.anisotropy)^2) along its longer axis.
struct ValidityRadius {
  float length = 0;  // of the longer semi-axis, metres
  vec3 anisotropy{0};
  float least = 0;  // to which neighbours may shorten it
};

struct MetricContext {
  float accuracy = 0.2f;     // at which the spacings below hold
  float scene_size = 1;      // metres, the scene's diagonal
  float pixel_width = 0;     // metres per pixel where the record lies
  float min_spacing = 0;     // pixels
  float max_spacing = 0;     // scene diagonals
  bool extrapolates = true;  // translation gradients are used
};

// Fills the estimate's second derivatives, where the metric needs them, and with `mesh_gradient` its translation gradient by
// the mesh of the samples ([Schwarzhaupt2012]) in place of that by strata.
void estimate_hessian(CacheMetric metric, const HemisphereStrata& strata, std::span<const HemisphereSample> samples,
                      const Frame& frame, bool mesh_gradient, IrradianceEstimate& estimate);

ValidityRadius metric_radius(CacheMetric metric, const IrradianceEstimate& estimate, const Frame& frame,
                             const MetricContext& context);

// The validity radius from second derivatives ([Schwarzhaupt2012] eqs. for total error and radius): a record extrapolated to
// first order errs by lambda r^2 / 2 at distance r, which integrated over the disc of radius R is pi lambda R^4 / 4. Every
// record is given the same integral of relative error, hence R = (4 error / (pi lambda))^(1/4), with one lambda for each axis
// of the ellipse.
//
// That error has the unit of an area; here it is (accuracy^2 c^2 D)^2 with D the scene's diagonal, so that spacings go with the
// accuracy as in the other metrics. For the metrics of [Jarosz2012] `relative` is to the irradiance pi of unit radiance: the
// radiometric one is of absolute error, so that twice the light makes more records.
ValidityRadius hessian_radius(const TangentMatrix& relative, const Frame& frame, const MetricContext& context);

// The length of the translation gradient, |grad E| of the luminance.
float steepness(const IrradianceEstimate& estimate);

}  // namespace etendue
