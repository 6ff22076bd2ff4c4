// Paths whose directions are drawn from a mixture of BSDF and guide, with next-event estimation as in path tracing.
//
// At every event with a lobe that is no delta the BSDF is sampled with the guide's share, else the guide; both densities are
// known, so that the mixture's is a proper density wherever the BSDF's is: unbiased whatever the guide has learnt (one-sample
// model, balance heuristic, [Veach1995]). The light sample is weighed against the mixture.
//
// Russian roulette compares what the path is worth, its throughput times the indirect light that the cache knows of the place,
// with what it was worth at its first diffuse surface ([Vorba2016], with that in place of the pixel's value, without
// splitting), and begins below a third. Where nothing is known, it survives with the throughput that BSDF sampling would have
// had: the guided one is small just where the guide sends paths to the light, and would end those.
#pragma once

#include "integrators/path.h"
#include "integrators/sd_tree.h"

namespace etendue {

// As trace_paths from the camera on; appends what the events taught, path by path, in order.
void trace_guided_paths(const RenderContext& context, std::span<PathSample> paths, const PathSettings& settings,
                        const SdTree& guide, std::vector<GuideRecord>& records);

}  // namespace etendue
