// Light tracing: particles from the lights, each vertex joined to the camera ([Dutre1993], [Veach1997] 10.3 with t = 1).
//
// Unbiased in scenes without specular surfaces. Where there are any, they stay black, and so does what is seen through them:
// the paths it can sample are light that the camera sees directly, and those whose last surface before the camera is not
// specular. It shares neither direct-light sampling nor camera-side scattering with the path tracer, which makes it the second
// opinion for references.
#pragma once

#include "framework/integrator.h"

#include <string>

namespace etendue {

struct LightTraceParams {
  int max_depth = 0;
  int roulette_depth = 5;
  int paths = 0;
};

template <class Visitor>
void describe(Visitor& v, LightTraceParams& p) {
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.integer("roulette_depth", p.roulette_depth, 0, 65536, "scattering events", "where Russian roulette begins");
  v.integer("paths", p.paths, 0, 1000000000, "per iteration", "light paths; 0: one for each pixel");
}

IntegratorEntry light_trace_entry();

}  // namespace etendue
