#include "integrators/progressive/appm.h"

#include "integrators/progressive/adaptive_bandwidth.h"

namespace etendue {

IntegratorEntry appm_entry() {
  return {"appm", "adaptive progressive photon mapping: the radius that variance and curvature ask for",
          list_params<AppmParams>(), [](const ParamMap& map) -> std::unique_ptr<Integrator> {
            const auto params = read_params<AppmParams>(map, "appm");
            const Kernel kernel = kernel_from_name(params.kernel);
            return std::make_unique<ProgressivePhotonMapping<AdaptiveBandwidth>>(
                params, VisiblePoints{}, [kernel](InitialRadii radii) { return AdaptiveBandwidth(std::move(radii), kernel); },
                Expectation{Bias::consistent, -2.0 / 3, 0.02, "bias and noise in balance, both vanish [Kaplanyan2013]"});
          }};
}

}  // namespace etendue
