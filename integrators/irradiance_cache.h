// Irradiance caching ([Ward1988]) with rotation and translation gradients ([Ward1992]).
//
// Indirect irradiance changes slowly over diffuse surfaces: it is computed by path tracing over a stratified hemisphere at few
// points and interpolated between. Cached are diffuse surfaces and the diffuse base of a smooth plastic (whose coat's
// transmission of the incoming light is taken at its hemispherical mean). Direct light is sampled per camera sample; delta
// lobes and all rough lobes are followed by path tracing until a cached surface.
//
// The cache is filled before the first iteration, in an overture over pixel centres on grids of 64, 32, ... 1 pixels. Each
// pass looks for points that no record covers and takes them in an order drawn by hash, in batches of 64: a batch is
// computed in parallel, then inserted in its order. Points of one batch do not see each other; the few records more cost
// nothing but room. As clamping shortens what records reach, a last pass looks at every pixel again. Thus the image does not
// depend on threads. Afterwards the cache is only read: a camera sample on a spot that no record covers (between the pixel
// centres, or behind a glossy bounce) is path-traced one bounce on, which is unbiased.
//
// Depth: the light a record holds has a bound on its scattering events, so records serve the camera depth they were made at.
// Where the limit is above 16 all depths share them, and a path seen through c carrying events may be c events too long.
//
// Biased: interpolation, and the records' noise, which the iterations do not average. An iteration is one sample per pixel.
#pragma once

#include "framework/integrator.h"
#include "framework/structure_names.h"

#include <string>

namespace etendue {

struct IrradianceCacheParams {
  float accuracy = 0.2f;
  int samples = 1024;
  float min_spacing = 1.5f;
  float max_spacing = 0.1f;
  std::string gradients = "both";
  bool neighbour_clamping = true;
  int max_depth = 0;
  std::string structure = "octree";
  std::string sampler = "sobol";
};

template <class Visitor>
void describe(Visitor& v, IrradianceCacheParams& p) {
  v.number("accuracy", p.accuracy, 0.001, 1, "1",
           "Ward's a: the error at which a record no longer serves; smaller, more records");
  v.integer("samples", p.samples, 1, 100000000, "rays", "over the hemisphere of a record");
  v.number("min_spacing", p.min_spacing, 0, 1000, "pixels", "a record serves at least this far");
  v.number("max_spacing", p.max_spacing, 0, 1, "scene diagonals", "and at most this far");
  v.choice("gradients", p.gradients, {"none", "rotation", "both"},
           "with which records are extrapolated: both adds translation");
  v.flag("neighbour_clamping", p.neighbour_clamping, "records reach no farther than their neighbours and the way to them");
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.choice("structure", p.structure, ball_structure_names, "what finds the records");
  v.choice("sampler", p.sampler, {"sobol", "independent"}, "random numbers");
}

IntegratorEntry irradiance_cache_entry();

}  // namespace etendue
