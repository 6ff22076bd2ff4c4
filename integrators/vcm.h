// Bidirectional path tracing ([Lafortune1993], [Veach1994]) and light tracing ([Dutre1993]), as settings of vertex connection
// and merging ([Georgiev2012a]; [Hachisuka2012] found the same): see integrators/vcm_mis.h for what is joined to what.
//
//   light-trace   splats alone: particles from the lights, each vertex joined to the lens
//   bdpt          all strategies but merging, weighed by the balance heuristic
//
// An iteration traces `paths` light paths, then one camera path a pixel. Camera path i is joined to the vertices of light path
// i (modulo their number); each light path is joined to the lens.
//
// bdpt is unbiased. What it cannot sample (and no other method without merging can) is light from a point, spot or directional
// light through delta lobes, seen through delta lobes; from an area light it finds that by chance alone.
// light-trace is unbiased in scenes without specular surfaces. Where there are any, they stay black, and so does what is seen
// through them: the paths it can sample are light that the camera sees directly, and those whose last surface before the camera
// is not specular. It shares neither direct-light sampling nor camera-side scattering with the path tracer.
//
// Memory: 104 bytes a vertex of all light paths of an iteration (bdpt), 28 a splat.
#pragma once

#include "framework/integrator.h"

#include <string>

namespace etendue {

struct LightTraceParams {
  int max_depth = 0;
  int roulette_depth = 5;
  int paths = 0;
  std::string sampler = "sobol";
};

template <class Visitor>
void describe(Visitor& v, LightTraceParams& p) {
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.integer("roulette_depth", p.roulette_depth, 0, 65536, "scattering events", "where Russian roulette begins");
  v.integer("paths", p.paths, 0, 1000000000, "per iteration", "light paths; 0: one for each pixel");
  v.choice("sampler", p.sampler, {"sobol", "independent"}, "random numbers");
}

struct BdptParams : LightTraceParams {};

IntegratorEntry light_trace_entry();
IntegratorEntry bdpt_entry();

}  // namespace etendue
