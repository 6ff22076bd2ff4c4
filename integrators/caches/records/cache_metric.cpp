#include "integrators/caches/records/cache_metric.h"

#include "integrators/caches/records/irradiance_hessian.h"

namespace etendue {

CacheMetric cache_metric(const std::string& name) {
  for (std::size_t i = 0; i < std::size(cache_metric_names); ++i)
    if (name == cache_metric_names[i]) return static_cast<CacheMetric>(i);
  return CacheMetric::occlusion_hessian;
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

ValidityRadius metric_radius(CacheMetric metric, const IrradianceEstimate& estimate, const Frame& frame,
                             const MetricContext& context) {
  switch (metric) {
    case CacheMetric::split_sphere:
      return split_sphere_radius(estimate);
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
