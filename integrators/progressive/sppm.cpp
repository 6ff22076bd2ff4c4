#include "integrators/progressive/sppm.h"

namespace etendue {

namespace {

std::unique_ptr<Integrator> make(const SharedStatisticsParams& params, VisiblePoints points, Expectation expected) {
  const double alpha = params.alpha;
  return std::make_unique<ProgressivePhotonMapping<SharedStatistics>>(
      params, points, [alpha](InitialRadii radii) { return SharedStatistics(std::move(radii), alpha); }, std::move(expected));
}

}  // namespace

IntegratorEntry sppm_entry() {
  return {"sppm", "stochastic progressive photon mapping: new visible points in every pass, statistics shared by pixel",
          list_params<SppmParams>(), [](const ParamMap& map) {
            const auto params = read_params<SppmParams>(map, "sppm");
            return make(params, {},
                        {params.alpha < 1 ? Bias::consistent : Bias::biased, progressive_exponent(params.alpha), 0.02,
                         "blur by the radius and loss at edges, which vanish with it [Hachisuka2009]"});
          }};
}

IntegratorEntry ppm_entry() {
  return {"ppm", "progressive photon mapping: fixed visible points, statistics of each", list_params<PpmParams>(),
          [](const ParamMap& map) {
            const auto params = read_params<PpmParams>(map, "ppm");
            return make(params, {static_cast<std::uint32_t>(params.points)},
                        {Bias::biased, progressive_exponent(params.alpha), 0.02,
                         "blur and loss at edges vanish with the radius [Hachisuka2008]; the fixed points' aliasing stays"});
          }};
}

}  // namespace etendue
