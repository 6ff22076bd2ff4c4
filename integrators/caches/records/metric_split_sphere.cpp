// The split sphere ([Ward1988]): at most, irradiance changes as it would if one half of a sphere were bright and one dark, that
// is within the sphere's radius; the harmonic mean distance stands for that radius.
//
// Unbounded it wastes records in corners and starves open surfaces; the bounded form keeps the spacing between a number of
// pixels and a share of the scene and, with gradients, within where E extrapolates to no less than 0.
#include "integrators/caches/records/cache_metric.h"

namespace etendue {

float steepness(const IrradianceEstimate& estimate) {
  const mat3& g = estimate.translation;
  return glm::length(0.2126f * g[0] + 0.7152f * g[1] + 0.0722f * g[2]);
}

ValidityRadius split_sphere_radius(const IrradianceEstimate& estimate) { return {estimate.harmonic_distance()}; }

ValidityRadius bounded_split_sphere_radius(const IrradianceEstimate& estimate, const MetricContext& context) {
  float validity_radius = estimate.harmonic_distance();
  if (context.extrapolates)
    if (const float slope = steepness(estimate); slope > 0)
      validity_radius = std::min(validity_radius, luminance(estimate.irradiance) / slope);
  const float largest = context.max_spacing * context.scene_size;
  const float least = std::max(context.min_spacing * context.pixel_width, 1e-6f * largest);
  return {std::clamp(validity_radius, least / context.accuracy, std::max(least, largest) / context.accuracy)};
}

}  // namespace etendue
