// Paths whose directions are drawn from a mixture of BSDF and guide, with next-event estimation as in path tracing.
//
// At every surface with a lobe that is not a delta, the BSDF is sampled with a probability that the guide has learnt, else the
// guide. Both densities are known, so the mixture has a proper density wherever the BSDF has one: unbiased whatever the guide
// has learnt (one-sample model, balance heuristic, [Veach1995]). The light sample is MIS-weighted with the mixture.
//
// Russian roulette compares what the path is worth, its throughput times the indirect light that the cache knows of the place,
// with what it was worth at its first diffuse surface ([Vorba2016], with that in place of the pixel's value, without
// splitting), and begins below a third. Where nothing is known, it survives with the throughput that BSDF sampling would have
// had: the guided throughput is smallest where the guide sends paths towards the light, and would end just those.
#pragma once

#include "integrators/guiding/sd_tree.h"
#include "integrators/paths/path.h"

namespace etendue {

// Like trace_paths from the camera; appends the records of all events, path by path, in order.
void trace_guided_paths(const RenderContext& context, std::span<PathSample> paths, const PathSettings& settings,
                        const SdTree& guide, std::vector<GuideRecord>& records);

}  // namespace etendue
