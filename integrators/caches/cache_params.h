// Parameters that all caches of irradiance share, whatever fills their records.
#pragma once

#include "integrators/caches/cache_fill.h"

#include <string>

namespace etendue {

struct CacheParams {
  std::string metric = "bounded-split-sphere";
  float accuracy = 0.2f;
  bool refine = true;
  int samples = 256;
  float min_spacing = 1.5f;
  float max_spacing = 0.1f;
  std::string gradients = "both";
  bool neighbour_clamping = true;
  float extra_samples = 2;
};

template <class Visitor>
void describe_cache(Visitor& v, CacheParams& p) {
  v.choice(
      "metric", p.metric,
      {"split-sphere", "bounded-split-sphere", "tabellion", "radiometric-hessian", "geometric-hessian", "occlusion-hessian"},
      "how far a record serves, from what its hemisphere saw");
  v.number("accuracy", p.accuracy, 0.001, 1, "1",
           "Ward's a: the error at which a record no longer serves; smaller, more records");
  v.flag("refine", p.refine, "every iteration adds records and passes over them; off: filled once");
  v.integer("samples", p.samples, 1, 100000000, "rays", "over the hemisphere of a record, per pass");
  v.number("min_spacing", p.min_spacing, 0, 1000, "pixels",
           "bounded-split-sphere and the Hessians: a record serves at least this far");
  v.number("max_spacing", p.max_spacing, 0, 1, "scene diagonals", "bounded-split-sphere: and at most this far");
  v.choice("gradients", p.gradients, {"none", "rotation", "both", "mesh"},
           "with which records are extrapolated: both adds translation; mesh takes that from the mesh of samples");
  v.flag("neighbour_clamping", p.neighbour_clamping, "records reach no farther than their neighbours and the way to them");
  v.number("extra_samples", p.extra_samples, 0, 31, "camera samples",
           "beyond one per pixel and iteration, at most on the mean: given to the pixels that scatter most");
}

Gradients parse_gradients(const std::string& name);  // of a checked parameter

// `structure`: what finds the records.
CacheSettings cache_settings(const CacheParams& params, SamplerKind sampler, const std::string& structure);

}  // namespace etendue
