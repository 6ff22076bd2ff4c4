#include "integrators/progressive/radius_policy.h"

namespace etendue {

static_assert(RadiusPolicy<FixedRadius> && RadiusPolicy<NearestRadius> && RadiusPolicy<MemorylessRadius> &&
              RadiusPolicy<SharedStatistics>);

float memoryless_shrinkage(std::uint32_t pass, double alpha) {
  const double n = pass + 1.0;
  return static_cast<float>(std::exp(0.5 * (std::lgamma(n + alpha) - std::lgamma(1 + alpha) - std::lgamma(n + 1))));
}

void SharedStatistics::update(std::size_t pixel, std::uint32_t, const Observed& observed) {
  if (observed.photons == 0) return;
  const double m = observed.photons, kept = counts_[pixel] + alpha_ * m;
  radii_[pixel] *= static_cast<float>(std::sqrt(kept / (counts_[pixel] + m)));
  counts_[pixel] = kept;
}

}  // namespace etendue
