// An exact scene of a rough mirror in a glowing sphere, behind a veil (exact_stage.h): the radiance is the lobe's albedo, at
// any roughness.
#pragma once

#include "framework/core/params.h"
#include "framework/scene/scene.h"

namespace etendue {

struct GlossyFurnaceParams {
  float alpha = 0.3f;
  bool veil = true;
};

template <class Visitor>
void describe(Visitor& v, GlossyFurnaceParams& p) {
  v.number("alpha", p.alpha, 0.001, 1, "GGX alpha", "roughness of the mirror");
  v.flag("veil", p.veil, "a sphere of index 1 about the mirror: no shadow ray gets through, the image stays the same");
}

// Of n photons that arrive evenly within a kernel, a narrow lobe makes an estimate of relative variance
// 1 / (12 alpha^2 cos^2 n), cos to the viewer: pi times the integral of f^2 cos, over the albedo squared.
Scene make_glossy_furnace(const GlossyFurnaceParams& params);

// The share of light from `cosine` to the normal that microfacets of mirrors (GGX, height-correlated masking, one reflection)
// send back, in double precision and within 1e-5 for a cosine above 0.3.
double ggx_albedo(double alpha, double cosine);

}  // namespace etendue
