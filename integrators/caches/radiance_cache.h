// Radiance caching in spherical harmonics ([Krivanek2005]): an irradiance cache that rough surfaces can use.
//
// Each surface uses the simplest cache that serves it. Diffuse surfaces use records of irradiance (irradiance_cache.h). A metal
// or plastic uses records of incident radiance in spherical harmonics (rough_cache.h), if its lobe is so wide that `order`
// bands leave out no more than `left_out` of it: with the defaults from a roughness of 0.48 on, with ten bands from 0.24. All
// else (delta lobes, dielectrics, narrower lobes) is followed to the next surface, where the cache answers: sampling a narrow
// lobe adds little noise, and records that resolve it would cost more than following it. Direct light is sampled, by light
// samples alone at diffuse surfaces, by them and the BSDF's at rough ones ([Veach1995]).
//
// Both kinds of record are filled, refined and averaged alike (cache_progress.h); with `refine` off they are made before the
// first iteration and stay as they are.
//
// A cache can be saved and loaded, as irradiance_cache.h says; `lobe_samples` too may differ then.
//
// Consistent with `refine` except for the order n of the harmonics: incident radiance is resolved only to about pi / n, which
// blurs reflections by up to `left_out`. Biased without: by interpolation and the records' noise. Depth: as irradiance_cache.h.
#pragma once

#include "framework/integrator.h"
#include "framework/structure_names.h"

#include <string>

namespace etendue {

struct RadianceCacheParams {
  float accuracy = 0.2f;
  bool refine = true;
  int samples = 512;
  int order = 5;
  float left_out = 0.025f;
  int lobe_samples = 4;
  bool gradients = true;
  float min_spacing = 1.5f;
  float max_spacing = 0.1f;
  float extra_samples = 2;
  int max_depth = 0;
  std::string structure = "cells";
  std::string sampler = "sobol";
};

template <class Visitor>
void describe(Visitor& v, RadianceCacheParams& p) {
  v.number("accuracy", p.accuracy, 0.001, 1, "1",
           "Ward's a: the error at which a record no longer serves; smaller, more records");
  v.flag("refine", p.refine, "every iteration adds records and passes over them; off: filled once");
  v.integer("samples", p.samples, 1, 100000000, "rays", "over the hemisphere of a record, per pass");
  v.integer("order", p.order, 3, 16, "bands", "of spherical harmonics at most; its square is the number of coefficients");
  v.number("left_out", p.left_out, 0.0001, 0.9, "1",
           "share of a lobe's amplitude beyond its bands; narrower ones are followed");
  v.integer("lobe_samples", p.lobe_samples, 1, 65536, "directions", "that project a rough lobe, per camera sample");
  v.flag("gradients", p.gradients, "records are extrapolated by their gradients");
  v.number("min_spacing", p.min_spacing, 0, 1000, "pixels", "a record serves at least this far");
  v.number("max_spacing", p.max_spacing, 0, 1, "scene diagonals", "and at most this far");
  v.number("extra_samples", p.extra_samples, 0, 31, "camera samples",
           "beyond one per pixel and iteration, at most on the mean: given to the pixels that scatter most");
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.choice("structure", p.structure, record_structure_names, "what finds the records");
  v.choice("sampler", p.sampler, {"sobol", "independent"}, "random numbers");
}

IntegratorEntry radiance_cache_entry();

}  // namespace etendue
