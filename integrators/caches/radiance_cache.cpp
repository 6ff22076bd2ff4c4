#include "integrators/caches/radiance_cache.h"

#include "integrators/caches/irradiance_cache.h"
#include "integrators/caches/records/cache_progress.h"

namespace etendue {

namespace {

IrradianceCacheParams diffuse_params(const RadianceCacheParams& p) {
  IrradianceCacheParams out;
  out.accuracy = p.accuracy;
  out.refine = p.refine;
  out.samples = p.samples;
  out.gradients = p.gradients ? "both" : "none";
  out.min_spacing = p.min_spacing;
  out.max_spacing = p.max_spacing;
  out.extra_samples = p.extra_samples;
  out.max_depth = p.max_depth;
  out.structure = p.structure;
  out.sampler = p.sampler;
  return out;
}

RoughCacheSettings rough_settings(const RadianceCacheParams& p) {
  return {.accuracy = p.accuracy,
          .min_spacing = p.min_spacing,
          .max_spacing = p.max_spacing,
          .highest_order = p.order,
          .left_out = p.left_out,
          .lobe_samples = p.lobe_samples,
          .gradients = p.gradients,
          .overlap = p.refine ? CacheProgress::overlap : 1,
          .strata = HemisphereStrata::of(p.samples),
          .sampler = parse_sampler(p.sampler),
          .structure = p.structure};
}

}  // namespace

IntegratorEntry radiance_cache_entry() {
  return {"radiance-cache", "radiance caching: irradiance where diffuse, spherical harmonics where rough",
          list_params<RadianceCacheParams>(), [](const ParamMap& map) {
            const auto params = read_params<RadianceCacheParams>(map, "radiance-cache");
            return make_irradiance_cache(diffuse_params(params),
                                         RoughExtension{rough_settings(params), "radiance-cache", param_texts(params)});
          }};
}

}  // namespace etendue
