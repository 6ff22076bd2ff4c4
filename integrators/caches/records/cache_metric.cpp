#include "integrators/caches/records/cache_metric.h"

#include "framework/core/elementary.h"
#include "integrators/caches/records/irradiance_hessian.h"

namespace etendue {

namespace {

constexpr double calibration = 0.7;       // c: as many records as the bounded split sphere makes in a Cornell box, about
constexpr double geometric_share = 1e-3;  // of the geometric Hessian, in the fall-back
constexpr double longest_ellipse = 2;     // ratio of its axes ([Schwarzhaupt2012])

// The split sphere ([Ward1988]): at most, irradiance changes as it would if one half of a sphere were bright and one dark, that
// is within the sphere's radius; the harmonic mean distance stands for that radius.
//
// Unbounded it wastes records in corners and starves open surfaces; the bounded form keeps the spacing between a number of
// pixels and a share of the scene and, with gradients, within where E extrapolates to no less than 0.
ValidityRadius bounded_split_sphere_radius(const IrradianceEstimate& estimate, const MetricContext& context) {
  float validity_radius = estimate.harmonic_distance();
  if (context.extrapolates)
    if (const float slope = steepness(estimate); slope > 0)
      validity_radius = std::min(validity_radius, luminance(estimate.irradiance) / slope);
  const float largest = context.max_spacing * context.scene_size;
  const float least = std::max(context.min_spacing * context.pixel_width, 1e-6f * largest);
  return {std::clamp(validity_radius, least / context.accuracy, std::max(least, largest) / context.accuracy)};
}

// [Tabellion2004] section 4.3: half the least distance to what is seen, between 1.5 and 10 times the width of a pixel; the
// error is the greater of the displacement's share of that and the normal's turn in units of 10 degrees (see `weight` in
// irradiance_records.cpp).
//
// There a record serves where kappa times that error is below 1. Here kappa = usual_accuracy / accuracy, so that the usual
// accuracy is the paper's kappa = 1.
ValidityRadius tabellion_radius(const IrradianceEstimate& estimate, const MetricContext& context) {
  const float pixel = std::max(context.pixel_width, 1e-7f * context.scene_size);
  return {std::clamp(0.5f * estimate.nearest, 1.5f * pixel, 10 * pixel) / usual_accuracy};
}

// Relative to what the record holds ([Schwarzhaupt2012]). Where the surroundings are black, or nearly, it falls back on a small
// share of the geometric Hessian: what is black now may uncover light a step on.
ValidityRadius occlusion_radius(const IrradianceEstimate& estimate, const Frame& frame, const MetricContext& context) {
  const TangentMatrix geometric = estimate.geometric * std::numbers::inv_pi;
  const double brightness = luminance(estimate.irradiance);
  if (!(brightness > 0)) return hessian_radius(geometric, frame, context);
  const TangentEigen e = eigen(estimate.hessian * (1 / brightness));
  const double floor = geometric_share * std::abs(eigen(geometric).first);
  const double a = std::abs(e.first) + floor, b = std::abs(e.second) + floor;
  return hessian_radius(tangent_matrix(a, b, e.axis), frame, context);
}

}  // namespace

float steepness(const IrradianceEstimate& estimate) {
  const mat3& g = estimate.translation;
  return glm::length(0.2126f * g[0] + 0.7152f * g[1] + 0.0722f * g[2]);
}

void estimate_hessian(CacheMetric metric, const HemisphereStrata& strata, std::span<const HemisphereSample> samples,
                      const Frame& frame, bool mesh_gradient, IrradianceEstimate& estimate) {
  if (mesh_gradient || metric == CacheMetric::occlusion_hessian) {
    const MeshDerivatives mesh = occlusion_derivatives(strata, samples, frame);
    if (mesh_gradient) estimate.translation = mesh.translation;
    if (metric == CacheMetric::occlusion_hessian) estimate.hessian = mesh.hessian;
  }
  if (metric == CacheMetric::radiometric_hessian) estimate.hessian = radiometric_hessian(strata, samples, frame);
  if (metric == CacheMetric::geometric_hessian || metric == CacheMetric::occlusion_hessian)
    estimate.geometric = geometric_hessian(strata, samples, frame);
}

ValidityRadius hessian_radius(const TangentMatrix& relative, const Frame& frame, const MetricContext& context) {
  const TangentEigen e = eigen(relative);
  const double size = context.scene_size, largest = size / context.accuracy;
  const double least = std::max(1e-6 * size, static_cast<double>(context.min_spacing * context.pixel_width)) / context.accuracy;
  const auto radius = [&](double lambda) {
    const double r = calibration * size * math::pow(4 / (std::numbers::pi * std::abs(lambda) * size * size), 0.25);
    return std::clamp(r, least, std::max(least, largest));
  };
  const double narrow = radius(e.first), wide = std::min(radius(e.second), longest_ellipse * narrow);
  const vec3 axis = static_cast<float>(e.axis.x) * frame.tangent + static_cast<float>(e.axis.y) * frame.bitangent;
  const double ratio = wide / narrow;
  return {static_cast<float>(wide), static_cast<float>(std::sqrt(std::max(0.0, ratio * ratio - 1))) * axis,
          static_cast<float>(least)};
}

ValidityRadius metric_radius(CacheMetric metric, const IrradianceEstimate& estimate, const Frame& frame,
                             const MetricContext& context) {
  switch (metric) {
    case CacheMetric::split_sphere:
      return {estimate.harmonic_distance()};
    case CacheMetric::bounded_split_sphere:
      return bounded_split_sphere_radius(estimate, context);
    case CacheMetric::tabellion:
      return tabellion_radius(estimate, context);
    case CacheMetric::radiometric_hessian:  // of absolute error ([Jarosz2012])
      return hessian_radius(estimate.hessian * std::numbers::inv_pi, frame, context);
    case CacheMetric::geometric_hessian:
      return hessian_radius(estimate.geometric * std::numbers::inv_pi, frame, context);
    case CacheMetric::occlusion_hessian:
      return occlusion_radius(estimate, frame, context);
  }
  return {};
}

}  // namespace etendue
