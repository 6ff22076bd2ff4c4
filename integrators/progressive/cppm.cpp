#include "integrators/progressive/cppm.h"

#include "integrators/progressive/chi_squared_radius.h"

namespace etendue {

IntegratorEntry cppm_entry() {
  return {"cppm", "chi-squared progressive photon mapping: the radius shrinks where photons prove uneven",
          list_params<CppmParams>(), [](const ParamMap& map) -> std::unique_ptr<Integrator> {
            const auto params = read_params<CppmParams>(map, "cppm");
            const ChiSquaredRadius::Rules rules{params.beta, params.hypothesis == "odd"};
            return std::make_unique<ProgressivePhotonMapping<ChiSquaredRadius>>(
                params, VisiblePoints{}, [rules](InitialRadii radii) { return ChiSquaredRadius(std::move(radii), rules); },
                Expectation{Bias::consistent, -2.0 / 3, 0.02, "blur and loss at edges, until the test sees them [Lin2020]"});
          }};
}

}  // namespace etendue
