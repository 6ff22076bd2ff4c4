// Decisions that methods make by looking at a scene: which samples are to find direct light, and how early roulette may
// end paths.
#pragma once

#include "integrators/paths/path.h"

namespace etendue {

struct MisChoice {
  MisMode mode = MisMode::power;
  const char* why = "";
};

// BSDF samples are alone where light is the same in all directions, as light samples cannot bring more, and where flat panes or
// spheres of delta lobes stand between all lights that rays can meet and all surfaces, as light samples end there. Light
// samples are alone where surfaces are diffuse or specular and so far from each light that these are everywhere denser than
// BSDF samples: their share of the weight would only add its noise. Else both have weights by the power heuristic. The choice
// depends on the scene and on how its lights are chosen.
MisChoice choose_mis(const RenderContext& context);

// Which samples find direct light at surfaces that are seen, where no path goes on since photons or records bring the rest:
// light samples alone, or, where these have clearly the larger second moment, both kinds by the power heuristic. A few BSDF
// samples tell both moments: close to a large lamp, where light samples have no bound, they meet it most.
MisMode choose_direct(const RenderContext& context);

// How many times its throughput a path's chance to survive roulette may be: the mean of a pixel over the standard deviation of
// its paths, which is the ratio of least cost for a given error ([Veach1997] 10.4), where that is above `least_evenness`;
// else 1. Where every path brings the same, roulette is all the noise there is. It is estimated from few paths, and again
// from paths without roulette where those scatter little.
float roulette_evenness(const RenderContext& context, const PathSettings& settings);
constexpr float least_evenness = 4;

// Do pixels hardly scatter, by less than this relative deviation, as far as a few pixels and direct light tell? They do not
// tell where surfaces show light of other places, as all do that are not diffuse, or let rays through.
bool is_smooth(const RenderContext& context, double deviation);

}  // namespace etendue
