// Vertex connection and merging ([Georgiev2012a]; [Hachisuka2012] found the same), with bidirectional path tracing
// ([Lafortune1993], [Veach1994]) and light tracing ([Dutre1993]) as settings. The ways of joining paths are listed in
// integrators/bidirectional/vcm_mis.h.
//
//   light-trace   splats alone: particles from the lights, each vertex joined to the lens
//   bdpt          all strategies but merging, weighted by the balance heuristic
//   vcm           all strategies
//
// An iteration traces `paths` light paths, then one camera path a pixel. Camera path i is joined to the vertices of light path
// i (modulo their number); each light path is joined to the lens.
//
// bdpt is unbiased. What it cannot sample (and no other method without merging can) is light from a point, spot or directional
// light through delta lobes, seen through delta lobes; from an area light it finds such paths only by chance.
//
// vcm is consistent: it samples those paths too, by merging, whose blur vanishes as the radius r_i does. r_i shrinks without
// memory ([Knaus2011]); r_1 is the median over visible points of the distance to the `neighbours`-th light vertex of a pilot
// pass: by default the fourth where light can reach specular surfaces, whose caustics merges find best, and among 128 or more
// lamps that stand apart, of which a connection asks one and a merge finds those whose light arrives; and the first where only
// narrow rough lobes may throw caustics, of lights that no ray can meet. By default r_1 is at most a twentieth of the scene's
// diagonal, and halved, up to ten times, while more than 2 % of the light of the pilot's paths lands where less than half of a
// disc is on the surface, as within a small lamp, or more than a tenth of the visible points lie so, as in a room into which
// hardly any light path gets. The same is asked of discs a quarter and an eighth as wide, which tell low steps apart. Merges
// there would find little, and weights count on them. Elsewhere nothing is merged unless it is asked for: the other strategies
// bring the same light with less noise, in less time and without a blur (experiments/ledger.toml), and vcm is bdpt. There is
// one radius for the whole image, since weights along light paths depend on it. Hence discs cannot end at walls that hide a
// brighter part of the same floor, as those of progressive photon mapping do; instead each merge is tested by a shadow ray
// (`wall_test`) and does not count if something is in the way. The weights, which assume whole discs, stay as they are: the
// light lost at walls is of the order of r, as at all borders of a surface, and vanishes with it. There is no side test: merges
// across a corner make up for what is lost beyond it, and a BSDF rejects light from behind.
//
// Merges that share a camera path are not independent. Weights that account for this (mis = "correlation-aware") are those of
// integrators/bidirectional/vcm_correlation.h, the same but for these factors.
//
// light-trace is unbiased in scenes without specular surfaces. Specular surfaces stay black, and so does what is seen through
// them: the paths it can sample are light that the camera sees directly, and those whose last surface before the camera is not
// specular. It shares neither direct-light sampling nor camera-side scattering with the path tracer.
//
// Memory: 144 bytes a vertex of all light paths of an iteration (vcm: and 64 more; correlation-aware: and 56 more), 28 a splat.
#pragma once

#include "framework/integrator.h"
#include "framework/structure_names.h"

#include <string>

namespace etendue {

struct LightTraceParams {
  int max_depth = 0;
  int roulette_depth = 5;
  int paths = 0;
  SamplerKind sampler = SamplerKind::sobol;
};

template <class Visitor>
void describe(Visitor& v, LightTraceParams& p) {
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.integer("roulette_depth", p.roulette_depth, 0, 65536, "scattering events", "where Russian roulette begins");
  v.integer("paths", p.paths, 0, 1000000000, "per iteration", "light paths; 0: one for each pixel");
  v.choice("sampler", p.sampler, "random numbers");
}

struct BdptParams : LightTraceParams {
  LightChoice lights = LightChoice::by_need;
};

template <class Visitor>
void describe(Visitor& v, BdptParams& p) {
  describe(v, static_cast<LightTraceParams&>(p));
  describe_lights(v, p.lights);
}

enum class VcmMis : std::uint8_t { balance, correlation_aware };
constexpr auto names_of(VcmMis) { return std::array{"balance", "correlation-aware"}; }

struct VcmParams : BdptParams {
  float radius = 0;
  int neighbours = 0;
  float alpha = 0.75f;
  bool wall_test = true;
  VcmMis mis = VcmMis::balance;
  std::string structure = "hash-grid";
};

template <class Visitor>
void describe(Visitor& v, VcmParams& p) {
  describe(v, static_cast<BdptParams&>(p));
  v.number("radius", p.radius, 0, 1e12, "m", "within which vertices are merged, at first; 0: from the light paths' density");
  v.integer("neighbours", p.neighbours, 0, 1000000, "vertices",
            "of one iteration's light paths within the first radius; 0: 4 where light can reach specular surfaces, and "
            "among 128 lamps that stand apart, 1 where that of delta lights can reach narrow rough lobes, and "
            "elsewhere, unless radius is given, no merges");
  v.number("alpha", p.alpha, 0.01, 1, "", "the larger, the slower the radius shrinks; 1: it stays");
  v.flag("wall_test", p.wall_test, "refuse merges where something stands between the two vertices");
  v.choice("mis", p.mis, "the MIS weights of strategies");
  v.choice("structure", p.structure, point_structure_names, "what finds the vertices to merge with");
}

// The `neighbours` of vcm where they are not given; 0: nothing is merged.
int neighbours_by_need(const RenderContext& context);

IntegratorEntry light_trace_entry();
IntegratorEntry bdpt_entry();
IntegratorEntry vcm_entry();

}  // namespace etendue
