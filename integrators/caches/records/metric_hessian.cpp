// The validity radius from second derivatives ([Schwarzhaupt2012] eqs. for total error and radius): a record extrapolated to
// first order errs by lambda r^2 / 2 at distance r, which integrated over the disc of radius R is pi lambda R^4 / 4. Every
// record is given the same integral of relative error, hence R = (4 error / (pi lambda))^(1/4), with one lambda for each axis
// of the ellipse.
//
// That error has the unit of an area; here it is (accuracy^2 c D)^2 with D the scene's diagonal, so that spacings go with the
// accuracy as in the other metrics.
//
// Relative to what the record holds ([Schwarzhaupt2012]), or, for the metrics of [Jarosz2012], to the irradiance pi of unit
// radiance: the radiometric one is of absolute error, so that twice the light makes more records. Where the surroundings are
// black, or nearly, the occlusion Hessian falls back on a small share of the geometric one: what is black now may uncover light
// a step on.
#include "integrators/caches/records/cache_metric.h"
#include "integrators/caches/records/irradiance_hessian.h"

namespace etendue {

namespace {

constexpr double calibration = 0.7;       // c: as many records as the bounded split sphere makes in a Cornell box, about
constexpr double geometric_share = 1e-3;  // of the geometric Hessian, in the fall-back
constexpr double longest_ellipse = 2;     // ratio of its axes ([Schwarzhaupt2012])

}  // namespace

ValidityRadius hessian_radius(const TangentMatrix& relative, const Frame& frame, const MetricContext& context) {
  const TangentEigen e = eigen(relative);
  const double size = context.scene_size, largest = size / context.accuracy;
  const double least = std::max(1e-6 * size, static_cast<double>(context.min_spacing * context.pixel_width)) / context.accuracy;
  const auto radius = [&](double lambda) {
    const double r = calibration * size * std::pow(4 / (std::numbers::pi * std::abs(lambda) * size * size), 0.25);
    return std::clamp(r, least, largest);
  };
  const double narrow = radius(e.first), wide = std::min(radius(e.second), longest_ellipse * narrow);
  const vec3 axis = static_cast<float>(e.axis.x) * frame.tangent + static_cast<float>(e.axis.y) * frame.bitangent;
  const double ratio = wide / narrow;
  return {static_cast<float>(wide), static_cast<float>(std::sqrt(std::max(0.0, ratio * ratio - 1))) * axis,
          static_cast<float>(least)};
}

ValidityRadius occlusion_radius(const IrradianceEstimate& estimate, const Frame& frame, const MetricContext& context) {
  const TangentMatrix geometric = estimate.geometric * std::numbers::inv_pi;
  const double brightness = luminance(estimate.irradiance);
  if (!(brightness > 0)) return hessian_radius(geometric, frame, context);
  const TangentEigen e = eigen(estimate.hessian * (1 / brightness));
  const double floor = geometric_share * std::abs(eigen(geometric).first);
  const double a = std::abs(e.first) + floor, b = std::abs(e.second) + floor;
  const dvec2 u = e.axis;
  return hessian_radius({a * u.x * u.x + b * u.y * u.y, (a - b) * u.x * u.y, a * u.y * u.y + b * u.x * u.x}, frame, context);
}

}  // namespace etendue
