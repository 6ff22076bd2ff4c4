#include "integrators/progressive/ppm_memoryless.h"

namespace etendue {

IntegratorEntry ppm_memoryless_entry() {
  return {"ppm-memoryless", "progressive photon mapping by a fixed sequence of radii", list_params<MemorylessParams>(),
          [](const ParamMap& map) -> std::unique_ptr<Integrator> {
            const auto params = read_params<MemorylessParams>(map, "ppm-memoryless");
            const double alpha = params.alpha;
            return std::make_unique<ProgressivePhotonMapping<MemorylessRadius>>(
                params, VisiblePoints{}, [alpha](InitialRadii radii) { return MemorylessRadius(std::move(radii), alpha); },
                Expectation{alpha < 1 ? Bias::consistent : Bias::biased, progressive_exponent(alpha), 0.02,
                            "blur by the radius and loss at edges, which vanish with it [Knaus2011]"});
          }};
}

}  // namespace etendue
