// Path-space filtering through a hash grid: indirect light that neighbouring paths have found is shared ([Binder2018],
// [Binder2019], after [Keller2014]).
//
// Each camera path goes on by its lobes until it meets a diffuse surface. There the direct light is sampled, and the indirect
// light is what a plane fitted to all that paths so far have brought home to the surface's cell says (path_space_grid.h), this
// path's own contribution among it: one direction, cosine distributed, followed on. Where that meets a diffuse surface in turn,
// it ends with that surface's cell as of the samples before, but for a share of paths; these, and those that find no cell which
// has seen enough, are traced on, so that cells the camera does not see go on learning too. Values are without the albedo:
// textures stay sharp. There is nothing to set per scene: cells are sized by pixels, and shrink.
//
// A path that ends with a cell takes that cell's error along, and so do all others that end there: with a share s traced on,
// the n-th bounce rests on s^(n-1) of the paths. The image as a whole, and light that needs many bounces, then have the noise
// of few paths, where light is rare. So s = `trace_on` times how much values scatter about their cells' means (1 at least),
// over the scene as a whole: what a cell itself has seen must not decide, or paths would end with means that are too low and go
// on from those that are too high. Roulette weighs an event by what its value is worth to the event before, not to the pixel:
// its value counts in full in its own cell. Light that a direction meets is weighed against the light sample it left behind,
// except where a path ends with a cell and follows none.
//
// A cache can be saved and loaded: with all that its cells have learnt it goes on for any view of the scene, as if the samples
// behind it had been the first of this image, whose mean is that of the new ones alone. What decides which cells answer
// (`enough`, `finest`) may differ then, and so may `light_samples`.
//
// Consistent: a cell blurs what of indirect light is not even or sloping within its size (and over normals that differ by some
// 20 degrees where it is larger than the curvature), coarser where few paths come; both vanish as cells shrink. What is sampled
// is averaged over all samples of a pixel, what the cache adds with weights that grow with their number, since each lookup
// rests on all paths before it: the larger cells of the first samples soon count for little. Rough lobes of any width are
// followed by path tracing, so that a glossy surface has the noise of one bounce. Depth: values hold light of a bounded number
// of events, so that cells are kept per depth where the limit is at most 16, shared where it is above (a path may then be too
// long by the events before the lookup).
#pragma once

#include "framework/integrator.h"

#include <string>

namespace etendue {

struct HashCacheParams {
  int max_depth = 0;
  int roulette_depth = 5;
  int light_samples = 2;
  float finest = 3;
  float enough = 20;
  float trace_on = 0.05f;
  std::string sampler = "sobol";
};

template <class Visitor>
void describe(Visitor& v, HashCacheParams& p) {
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.integer("roulette_depth", p.roulette_depth, 0, 65536, "scattering events", "where Russian roulette begins");
  v.integer("light_samples", p.light_samples, 1, 1024, "shadow rays", "where the cache is asked, whose answer has less noise");
  v.number("finest", p.finest, 0.1, 1000, "pixels", "edge of the smallest cells of the first sample; later ones shrink");
  v.number("enough", p.enough, 1, 1e6, "values", "a cell answers that has seen so many at the first sample; later more");
  v.number("trace_on", p.trace_on, 0, 1, "1",
           "share of paths that go on where they could end with a cell, times the scatter of all values over cells' means "
           "where that is "
           "above 1");
  v.choice("sampler", p.sampler, {"sobol", "independent"}, "random numbers");
}

IntegratorEntry hash_cache_entry();

}  // namespace etendue
