// Radiance caching in spherical harmonics ([Krivanek2005]): an irradiance cache that rough surfaces can use.
//
// Each surface uses the simplest cache that serves it. Diffuse surfaces use records of irradiance (irradiance_cache.h). A metal
// or plastic uses records of incident radiance in spherical harmonics (rough_cache.h), if its lobe is so wide that `order`
// bands leave out no more than `left_out` of it: with the defaults from a roughness of 0.48 on, with ten bands from 0.24. All
// else (delta lobes, dielectrics, narrower lobes) is followed to the next surface, where the cache answers: sampling a narrow
// lobe adds little noise, and records that resolve it would cost more than following it. Direct light is sampled, by light
// samples alone at diffuse surfaces, by them and the BSDF's at rough ones ([Veach1995]).
//
// Both kinds of record are filled, refined and averaged alike (record_cache.h).
//
// It is saved and loaded as irradiance-cache is; `lobe_samples` too may differ when it is loaded.
//
// It is consistent with `refine` except for the order n of the harmonics: incident radiance is resolved only to about pi / n,
// which blurs reflections by up to `left_out`. Without `refine` it is biased by interpolation and the records' noise. Depth is
// as in irradiance_cache.h.
#pragma once

#include "framework/structure_names.h"
#include "integrators/caches/record_cache.h"
#include "integrators/photons/caustic_light.h"

namespace etendue {

struct RadianceCacheParams : RecordParams, CausticParams {
  int order = 5;
  float left_out = 0.025f;
  int lobe_samples = 4;
  bool gradients = true;
  std::string structure = "cells";
};

template <class Visitor>
void describe(Visitor& v, RadianceCacheParams& p) {
  describe_records(v, p);
  v.integer("order", p.order, 3, 16, "bands", "of spherical harmonics at most; its square is the number of coefficients");
  v.number("left_out", p.left_out, 0.0001, 0.9, "1",
           "share of a lobe's amplitude beyond its bands; narrower ones are followed");
  v.integer("lobe_samples", p.lobe_samples, 1, 65536, "directions", "that project a rough lobe, per camera sample");
  v.flag("gradients", p.gradients, "records are extrapolated by their gradients");
  describe_caustics(v, p);
  v.choice("structure", p.structure, record_structure_names, "what finds the records");
}

IntegratorEntry radiance_cache_entry();

}  // namespace etendue
