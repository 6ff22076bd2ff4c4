// Do caustics need a map of photons of their own beside paths?
//
// Light of delta lights by way of specular surfaces does, since no ray can meet such lights, and that of lamps far brighter
// than any that paths meet there. That of other lights is brought by paths as well, with the more noise the more seldom they
// meet it: where they meet it soon, photons blur it and take time for nothing (experiments/ledger.toml).
#pragma once

#include "integrators/photons/caustic_light.h"
#include "integrators/pilot/pilot.h"

namespace etendue {

// This share of the rays that leave a diffuse surface must meet a light by way of specular surfaces if paths are to bring such
// light: a tenth of its share in all light, or, for records, whose rays many pixels share, four in the 256 rays of one if that
// is less.
inline constexpr double enough_hits_of_records = 4.0 / 256, enough_hits_of_cells = 0.1;

// Is there frosted glass that paths leave in the right direction by chance alone? Caustic maps take no photons from it.
bool has_nearly_smooth_glass(const Scene& scene);

// Can light come to what is seen by way of mirrors or glass, or of frosted glass that is nearly smooth?
bool may_cast_caustics(const RenderContext& context);

bool caustics_need_photons(const RenderContext& context, const PilotFindings& findings, double enough_hits);

// `auto` becomes on or off, by a pilot where the scene's needs do not tell. That has a seed of its own, so that images of all
// seeds decide alike, and leaves another choice of lights behind: a method makes its own after it.
void decide_caustic_map(RenderContext& context, CausticParams& params, double enough_hits);

}  // namespace etendue
