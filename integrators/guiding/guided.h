// Practical path guiding: path tracing that learns where light comes from ([Mueller2017]).
//
// It renders blocks of 2, 4, 8, ... samples per pixel; each samples from a mixture of the BSDF and a spatio-directional tree
// (sd_tree.h) of the light that the block before has seen, and trains the next. The first block is path tracing. All samples
// count towards the image, blocks by the inverse of their variance (image_blocks.h). What paths do is in guided_paths.h.
//
// Deviations from [Mueller2017]: the first block has 2 samples, so that its variance is known; blocks go on doubling as long as
// the caller asks; a spatial leaf divides at 2,000 records, not 12,000, and directions at a fiftieth of the flux; light is
// sampled directly too, and the tree learns what that leaves to BSDF and guide; the tree distinguishes normals, and learns
// radiance times cosine with the help of a cache (sd_tree.h); roulette uses that cache. From [Mueller2019]: the learnt share of
// BSDF sampling (by one sum per candidate, for the least variance), the combination of blocks and, if asked for, the stochastic
// spatial filter; with leaves this small it costs more at edges than it saves in noise. The directional filter is
// left out.
//
// Unbiased up to the depth limit, but for what image_blocks.h says of the weights, which no test finds (combination = mean or
// last: exactly).
// Limits: there is no product with glossy lobes, and a tenth of their directions or more come from what was learnt; in scenes
// with easy light it is slower than path tracing.
#pragma once

#include "framework/integrator.h"
#include "integrators/guiding/image_blocks.h"

#include <string>

namespace etendue {

enum class BsdfFraction : std::uint8_t { learnt, fixed };
constexpr auto names_of(BsdfFraction) { return std::array{"learnt", "fixed"}; }

enum class SpatialFilter : std::uint8_t { nearest, stochastic };
constexpr auto names_of(SpatialFilter) { return std::array{"nearest", "stochastic"}; }

struct GuidedParams {
  int max_depth = 0;
  int roulette_depth = 5;
  float bsdf_fraction = 0.5f;
  BsdfFraction fraction = BsdfFraction::learnt;
  int split = 2000;
  float flux = 0.02f;
  SpatialFilter spatial_filter = SpatialFilter::nearest;
  BlockCombination combination = BlockCombination::inverse_variance;
  std::string mis = "power";
  SamplerKind sampler = SamplerKind::sobol;
  LightChoice lights = LightChoice::by_need;
};

template <class Visitor>
void describe(Visitor& v, GuidedParams& p) {
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.integer("roulette_depth", p.roulette_depth, 0, 65536, "scattering events", "where Russian roulette may begin");
  v.number("bsdf_fraction", p.bsdf_fraction, 0.01, 1, "1",
           "directions that the BSDF samples, not the tree; where learnt, to begin with");
  v.choice("fraction", p.fraction, "bsdf_fraction: learnt per place, or fixed");
  v.integer("split", p.split, 1, 1000000000, "records",
            "a place divides where it has more, times the square root of the block's samples");
  v.number("flux", p.flux, 1e-4, 1, "1", "share of a place's light that directions divide at");
  v.choice("spatial_filter", p.spatial_filter, "records teach their own place, or those beside it too");
  v.choice("combination", p.combination, "of the blocks of samples into one image");
  v.choice("mis", p.mis, {"power", "balance"}, "how light sampling and the mixture share the work");
  v.choice("sampler", p.sampler, "random numbers");
  describe_lights(v, p.lights);
}

IntegratorEntry guided_entry();

}  // namespace etendue
