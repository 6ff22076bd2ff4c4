#include "integrators/pilot/caustic_need.h"

#include <algorithm>

namespace etendue {

bool caustics_need_photons(const RenderContext& context, const PilotFindings& findings, double enough_hits) {
  if (!context.needs.caustic_map) return false;
  if (context.lights.any_delta()) return true;
  constexpr double rare_hits = 0.1;  // over the share of all light that comes by that way
  return findings.unmet_caustics >= least_caustic_light ||
         (findings.caustic_light >= least_caustic_light &&
          findings.caustic_hits < std::min(rare_hits * findings.caustic_light, enough_hits));
}

bool wants_caustic_map(const RenderContext& context, const CausticParams& params, double enough_hits) {
  if (params.caustic_map != CausticMap::where_needed) return params.caustic_map == CausticMap::on;
  if (!context.needs.caustic_map) return false;
  if (context.lights.any_delta() || params.caustic_photons > 0) return true;
  RenderContext asked = context;
  asked.seed = 0;
  return caustics_need_photons(context, run_pilot(asked), enough_hits);
}

}  // namespace etendue
