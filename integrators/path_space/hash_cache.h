// Path-space filtering through a hash grid: paths share the indirect light that their neighbours have found ([Binder2018],
// [Binder2019], after [Keller2014]).
//
// Each camera path follows its lobes until it meets a diffuse surface. Direct light is sampled there. Indirect light is read
// from the surface's cell (path_space_grid.h): a plane fitted to all values that paths have contributed to the cell, among them
// this path's own, found by following one cosine-distributed direction. Where that direction meets another diffuse surface, the
// value ends with what this surface's cell had before the current sample, or goes on where the cell has seen too little. Values
// exclude the albedo, so textures stay sharp. Nothing must be set per scene: cells are sized by pixels, and shrink.
//
// A share s of the paths that end with a cell goes on from there, so that cells the camera does not see keep learning. What
// such a path finds counts for the cells that it meets from then on, and no more for those before, which have taken the cell's
// value. Where all depths share their cells, it takes further cells' values, or ends with them, in the same way: like temporal
// differences ([Dahm2017]), each cell learns from what it leads to, by values with the noise of one event.
//
// Where each depth has cells of its own (see below), it asks no further cell once one has answered: those that paths end with
// then hold means of nearly whole paths. Else the cells of the n-th depth would learn from s^n of the paths, and each from what
// the next one knew at the time, so that errors of the first samples would stay, and be those of the whole image: through a
// door ajar, means of images of 64 samples at 160 x 90 would scatter by 3.4 % and not by 1.0 % (one standard deviation, eight
// and six seeds). The stated standard error is that of a pixel's own samples and cells: it leaves out what all have in common.
//
// A path that ends with a cell inherits that cell's error, and so do all others that end there; the n-th bounce rests on
// s^(n-1) of the paths where cells are shared, on s of them else. So s = `trace_on` times the relative scatter of values about
// their cells' means (at least 1), taken over the whole scene: if each cell decided by its own values, paths would end with
// means that are too low and go on from those that are too high. Roulette compares an event's value with the event before, not
// with the pixel, because the value counts in full in its own cell. Light that a direction meets is MIS-weighted with the light
// sample at its origin. Where a value ends with a cell, a share s follows a direction, and the weights count it as s samples
// ([Veach1995]): near the rim of a lamp light samples alone would have no bound, and one of them would be seen for long.
//
// A cache can be saved and loaded. It then continues for any view of the scene as if its earlier samples had been the first of
// this image, whose mean is over the new ones alone. The parameters that decide which cells answer (`enough`, `finest`) may
// differ, and so may `light_samples`. With a pixel filter that has negative parts none is loaded: of samples in the middle of a
// pixel's the weights may cancel (framework/scene/pixel_filter.h).
//
// Where the scene needs it, caustics come from a map of photons that is new in every iteration (caustic_light.h): paths gather
// it wherever they meet a diffuse or rough surface, and cells hold all else.
//
// Consistent: a cell blurs indirect light that is not linear within its size (and over normals that differ by some 20 degrees,
// where it is larger than the radius of curvature), more where few paths come; this vanishes as cells shrink. Sampled light is
// the mean over all samples of a pixel. What the cache adds is weighted by the number n of samples so far (alike, under a
// pixel filter with negative parts), since each lookup rests on the paths of all of them, which weigh as much as the paths of
// 0.69 n to 0.78 n samples would if all weighed the same: the larger cells of the first samples soon count for little. Rough
// lobes of any width are followed by path tracing, so that a glossy surface has the noise of one bounce. Depth: values hold
// light of a bounded number of events, so that cells are kept per depth where the limit is at most 16, shared where it is
// above (a path may then be too long by the events before the lookup).
#pragma once

#include "integrators/photons/caustic_light.h"

#include <string>

namespace etendue {

struct HashCacheParams : CausticParams {
  int max_depth = 0;
  int roulette_depth = 5;
  int light_samples = 2;
  float finest = 4;
  float enough = 5;
  float trace_on = 0.05f;
  SamplerKind sampler = SamplerKind::sobol;
  LightChoice lights = LightChoice::by_need;
};

template <class Visitor>
void describe(Visitor& v, HashCacheParams& p) {
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.integer("roulette_depth", p.roulette_depth, 0, 65536, "scattering events", "where Russian roulette begins");
  v.integer("light_samples", p.light_samples, 1, 1024, "shadow rays", "where the cache is asked, whose answer has less noise");
  v.number("finest", p.finest, 0.1, 1000, "pixels", "edge of the smallest cells of the first sample; later ones shrink");
  v.number("enough", p.enough, 1, 1e6, "values",
           "a cell answers that has seen so many at the first sample; later more. Older ones weigh less");
  v.number("trace_on", p.trace_on, 0, 1, "1",
           "share of paths that go on where they could end with a cell, times the scatter of all values over cells' means "
           "where that is "
           "above 1");
  describe_caustics(v, p);
  v.choice("sampler", p.sampler, "random numbers");
  describe_lights(v, p.lights);
}

IntegratorEntry hash_cache_entry();

}  // namespace etendue
