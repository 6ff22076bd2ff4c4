// Visibility-driven photon tracing ([Hachisuka2011]): photon paths distributed in proportion to V, which is 1 where a path
// stores a photon in the visible region and else 0, by Markov chains on the numbers that paths are made of.
//
// Because V has two values, replica exchange between the chain and uniform sampling means that every visible uniform path
// becomes the chain's state. So here half of the pass's paths are uniform; each visible one of them, drawn from the target
// distribution itself, starts a stretch of chain, and the stretches share out the other half. A step changes every number by u
// +- r^(1 / m + 1) (r uniform, the sum wrapped) and is taken if the new path is visible. The size m adapts towards an
// acceptance rate of 0.234, after each step by (rate so far - 0.234) / steps ([Hachisuka2011], algorithm 2), along each of 16
// sequences of stretches, which run in parallel.
//
// The photons of a state carry power in proportion to the steps it was held, over all uniform paths, visible or not, over the
// length of the stretch: the visible share of uniform paths is the normalisation. Every state of a stretch follows the target
// distribution, whatever their number: there is no start-up bias, and the estimate is unbiased but for what the adaption of m
// leaves. No photon at all is stored where no uniform path was visible.
#pragma once

#include "integrators/photons/photons.h"

namespace etendue {

Photons trace_by_visibility(const RenderContext& context, const RoughMaterials& rough_materials, const PhotonPass& pass);

}  // namespace etendue
