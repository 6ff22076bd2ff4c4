// Irradiance caching ([Ward1988]) with rotation and translation gradients ([Ward1992]).
//
// Indirect irradiance changes slowly over diffuse surfaces: it is computed by path tracing over a stratified hemisphere at few
// points and interpolated between. Cached are diffuse surfaces and the diffuse base of a smooth plastic (whose coat's
// transmission of the incoming light is taken at its hemispherical mean). Direct light is sampled per camera sample, by the
// samples that choose_direct (integrators/paths/path_choices.h) finds fit; delta lobes and all rough lobes are followed by path
// tracing until a cached surface.
//
// How the cache refines, and how it is saved and loaded: integrators/caches/record_cache.h. With `records` it is filled to that
// number before the first iteration, and only passes are added (and, loaded for another view, records for what is not covered
// there). `accuracy` (without `records`), `extra_samples`, `refine` and `structure` may differ when it is loaded; all other
// parameters decide what records hold, and must agree.
//
// A camera sample on a spot that no record covers is path-traced one bounce on, which is unbiased; with `records` the nearest
// record answers there as far as four times the accuracy, since a given number leaves gaps that paths would fill with noise.
//
// With `fill = "closed-form"` records are exact (closed_form_irradiance.h): what is left is the error of interpolation and of
// where records lie. It needs a scene whose answer is known, and `cache_direct`, since that answer holds all light. Here, too,
// the nearest record answers in a gap. Camera rays go through the centres of pixels, so that there is no noise at all and
// pixels do not average errors away (where light is smooth the centre's value is the pixel's mean, but for a second
// difference). Metrics that judge by the distances that a hemisphere saw cannot be used (the geometric Hessian, the split
// sphere, Tabellion's), and the occlusion Hessian is without its floor; the Hessian metrics judge by the true Hessian. There
// are no extra samples.
//
// With `fill = "exact-values"` records hold the same exact answer and gradients, but hemispheres are sampled as ever and say
// how far a record serves: every metric as it is, without the noise of what records hold. It needs the same scenes.
//
// With `fill = "records"` the paths of a hemisphere end at the first surface that the records so far cover, which answer for
// all further bounces; with "paths" they are traced to their end.
//
// Depth: the light a record holds has a bound on its scattering events, so records serve the camera depth they were made at.
// Where the limit is above 16 all depths share them, and a path seen through c specular-like events may be c events too long;
// where records answer for records, light may be so too.
//
// Where the scene needs it, caustics come from a map of photons that is new in every iteration (caustic_light.h): camera paths
// and the paths that fill records gather it wherever they meet a diffuse or rough surface, and records hold all else. Records
// of the exact answer hold caustics too, and there is no map.
//
// Consistent with `refine`, else biased: by interpolation, and the records' noise, which iterations do not average. Passes over
// records whose light ends in other records count alike, so that what early ones took over from coarse records fades more
// slowly than their noise.
#pragma once

#include "framework/structure_names.h"
#include "integrators/caches/record_cache.h"
#include "integrators/photons/caustic_light.h"

namespace etendue {

enum class RecordFill : std::uint8_t { records, paths, closed_form, exact_values };
constexpr auto names_of(RecordFill) { return std::array{"records", "paths", "closed-form", "exact-values"}; }

struct IrradianceCacheParams : CacheParams, CausticParams {
  int records = 0;
  bool overture = true;
  RecordFill fill = RecordFill::records;
  bool cache_direct = false;
  std::string structure = "cells";
};

template <class Visitor>
void describe(Visitor& v, IrradianceCacheParams& p) {
  describe_cache(v, p);
  v.integer("records", p.records, 0, 10000000, "records",
            "this many: the accuracy is found by bisection; 0: as many as it takes");
  v.flag("overture", p.overture,
         "pixels are looked at on coarse grids first; off: row by row on one thread, so that records lie where "
         "those before them end");
  v.choice("fill", p.fill,
           "what gives a hemisphere's light its further bounces; closed-form: no hemispheres, records hold the exact answer; "
           "exact-values: that too, but hemispheres say how far they serve");
  v.flag("cache_direct", p.cache_direct, "records hold direct light too, as far as rays can find it; no light samples there");
  describe_caustics(v, p);
  v.choice("structure", p.structure, record_structure_names, "what finds the records");
}

// Rough metals and plastics are answered too (radiance_cache.h), by an integrator of another name and parameters.
struct RoughExtension {
  RoughCacheSettings settings;
  std::string integrator;
  ParamTexts params;
};
std::unique_ptr<Integrator> make_irradiance_cache(const IrradianceCacheParams& params,
                                                  const std::optional<RoughExtension>& rough = std::nullopt);

IntegratorEntry irradiance_cache_entry();

}  // namespace etendue
