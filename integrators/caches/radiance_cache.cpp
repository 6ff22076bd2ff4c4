#include "integrators/caches/radiance_cache.h"

#include "integrators/caches/irradiance_cache.h"

namespace etendue {

IntegratorEntry radiance_cache_entry() {
  return integrator_entry<RadianceCacheParams>(
      "radiance-cache", "radiance caching: irradiance where diffuse, spherical harmonics where rough",
      [](const RadianceCacheParams& p) {
        IrradianceCacheParams diffuse;
        static_cast<RecordParams&>(diffuse) = p;
        static_cast<CausticParams&>(diffuse) = p;
        diffuse.gradients = p.gradients ? Gradients::both : Gradients::none;
        diffuse.structure = p.structure;
        RoughCacheSettings rough{record_settings(p, p.structure), p.order, p.left_out, p.lobe_samples, p.gradients};
        if (p.refine) rough.overlap = CacheProgress::overlap;
        return make_irradiance_cache(diffuse, RoughExtension{rough, "radiance-cache", param_texts(p)});
      },
      350);
}

}  // namespace etendue
