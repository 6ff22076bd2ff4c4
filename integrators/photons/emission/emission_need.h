// Do photons need to be led to what is seen?
//
// Where the camera looks into a room that is lit from without, or at a small part of what lights shine on, nearly all photons
// that are emitted by power land elsewhere. Those few that land in view then lie so far apart that kernels blur, and lose, what
// is small. Markov chains of paths that are seen (photon_chains.h) bring many times as many, for twice the time. Where photons
// land in view by themselves, the chains' noise and time are for nothing.
#pragma once

#include "integrators/photons/emission/visible_region.h"

namespace etendue {

// What `asked` stands for: by need, that is by visibility where fewer than one photon in a hundred lands in view, if any does,
// and else by power. `options`: of the paths that are seen. All seeds decide alike.
PhotonEmission emission_by_need(const RenderContext& context, const RoughMaterials& rough_materials, PhotonEmission asked,
                                SeenOptions options);

}  // namespace etendue
