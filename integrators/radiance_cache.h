// Radiance caching in spherical harmonics ([Krivanek2005]): an irradiance cache that glossy surfaces can use.
//
// Incident indirect radiance is path-traced over the hemisphere of few points and kept in spherical harmonics with gradients
// (radiance_cache_records.h). Diffuse surfaces and rough metals and plastics are answered by interpolation; a glossy lobe is
// projected for its outgoing direction by `lobe_samples` samples of the BSDF, anew at each camera sample, so that no table
// limits what materials there may be. Direct light is sampled. All else (delta lobes, dielectrics, lobes below `roughness`) is
// followed by path tracing until a cached surface, and so is a camera sample on a spot that no record covers.
//
// The records are made before the first iteration, over pixel centres on grids of 64, 32, ... 1 pixels; each pass takes the
// points that no record covers in an order drawn by hash, in batches of 64, and after them a last one all pixels, since
// clamping shortens what records reach. So they depend on no thread.
//
// Biased: interpolation, the records' noise, which iterations do not average, and the order n: incident radiance is known no
// finer than some pi / n, which blurs what narrow lobes reflect: hence `roughness`, 2.5 / n. Depth: records serve the camera
// depth they were made at; where the limit is above 16 all depths share them.
#pragma once

#include "framework/integrator.h"

#include <string>

namespace etendue {

struct RadianceCacheParams {
  float accuracy = 0.3f;
  int samples = 512;
  int order = 10;
  float roughness = 0.25f;
  int lobe_samples = 16;
  bool gradients = true;
  float min_spacing = 1.5f;
  float max_spacing = 0.1f;
  int max_depth = 0;
  std::string structure = "octree";
  std::string sampler = "sobol";
};

template <class Visitor>
void describe(Visitor& v, RadianceCacheParams& p) {
  v.number("accuracy", p.accuracy, 0.001, 1, "1",
           "Ward's a: the error at which a record no longer serves; smaller, more records");
  v.integer("samples", p.samples, 1, 100000000, "rays", "over the hemisphere of a record");
  v.integer("order", p.order, 3, 16, "bands", "of spherical harmonics; its square is the number of coefficients");
  v.number("roughness", p.roughness, 0, 1, "GGX alpha", "from which on glossy surfaces use the cache");
  v.integer("lobe_samples", p.lobe_samples, 1, 65536, "directions", "that project a glossy lobe");
  v.flag("gradients", p.gradients, "records are extrapolated by their translation gradients");
  v.number("min_spacing", p.min_spacing, 0, 1000, "pixels", "a record serves at least this far");
  v.number("max_spacing", p.max_spacing, 0, 1, "scene diagonals", "and at most this far");
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.choice("structure", p.structure, {"octree", "brute"}, "what finds the records");
  v.choice("sampler", p.sampler, {"sobol", "independent"}, "random numbers");
}

IntegratorEntry radiance_cache_entry();

}  // namespace etendue
