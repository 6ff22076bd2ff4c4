#include "integrators/caches/cache_params.h"

namespace etendue {

Gradients parse_gradients(const std::string& name) {
  return name == "none"       ? Gradients::none
         : name == "rotation" ? Gradients::rotation
         : name == "mesh"     ? Gradients::mesh
                              : Gradients::both;
}

CacheSettings cache_settings(const CacheParams& params, SamplerKind sampler, const std::string& structure) {
  return {.metric = cache_metric(params.metric),
          .gradients = parse_gradients(params.gradients),
          .clamping = params.neighbour_clamping,
          .accuracy = params.accuracy,
          .min_spacing = params.min_spacing,
          .max_spacing = params.max_spacing,
          .strata = HemisphereStrata::of(params.samples),
          .sampler = sampler,
          .structure = structure,
          .at_point = {}};
}

}  // namespace etendue
