#include "integrators/pilot/caustic_need.h"

#include <algorithm>

namespace etendue {

bool has_nearly_smooth_glass(const Scene& scene) {
  constexpr float nearly_smooth = 0.05f;  // GGX alpha
  return std::ranges::any_of(scene.materials, [](const Material& material) {
    const auto* glass = std::get_if<Dielectric>(&material);
    return glass != nullptr && glass->alpha > 0 && glass->alpha < nearly_smooth;
  });
}

bool may_cast_caustics(const RenderContext& context) {
  return context.needs.caustic_map || has_nearly_smooth_glass(context.scene);
}

bool caustics_need_photons(const RenderContext& context, const PilotFindings& findings, double enough_hits) {
  if (!context.needs.caustic_map) return false;
  if (context.lights.any_delta()) return true;
  // The tenth is relative to the share of all light that comes by that way. It is more than that at which `auto` gives paths
  // up, as a map beside them is cheap.
  return findings.unmet_caustics >= least_caustic_light ||
         (findings.caustic_light >= least_caustic_light &&
          findings.caustic_hits < std::min(enough_hits_of_cells * findings.caustic_light, enough_hits));
}

void decide_caustic_map(RenderContext& context, CausticParams& params, double enough_hits) {
  if (params.caustic_map != CausticMap::where_needed) return;
  const auto by_pilot = [&] {
    RenderContext asked = context;
    asked.seed = 0;
    return caustics_need_photons(context, run_pilot(asked), enough_hits);
  };
  const bool in_any_case = context.lights.any_delta() || params.caustic_photons > 0;
  const bool needed = context.needs.caustic_map && (in_any_case || by_pilot());
  params.caustic_map = needed ? CausticMap::on : CausticMap::off;
}

}  // namespace etendue
