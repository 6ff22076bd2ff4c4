// [Tabellion2004] section 4.3: half the least distance to what is seen, between 1.5 and 10 times the width of a pixel; the
// error is the greater of the displacement's share of that and the normal's turn in units of 10 degrees (see `weight` in
// irradiance_records.cpp).
//
// There a record serves where kappa times that error is below 1. Here kappa = usual_accuracy / accuracy, so that the usual
// accuracy is the paper's kappa = 1.
#include "integrators/caches/records/cache_metric.h"

namespace etendue {

ValidityRadius tabellion_radius(const IrradianceEstimate& estimate, const MetricContext& context) {
  const float pixel = std::max(context.pixel_width, 1e-7f * context.scene_size);
  return {std::clamp(0.5f * estimate.nearest, 1.5f * pixel, 10 * pixel) / usual_accuracy};
}

}  // namespace etendue
