// Exact scenes of a rough mirror (GGX, height-correlated masking, one reflection): in a glowing sphere behind a veil
// (exact_stage.h), where the radiance is the lobe's albedo, and before a lamp of any size, where it is the lobe's share of it.
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

struct GlossyLampParams {
  float alpha = 0.1f;
  float size = 0.1f;
};

template <class Visitor>
void describe(Visitor& v, GlossyLampParams& p) {
  v.number("alpha", p.alpha, 0.005, 1, "GGX alpha", "roughness of the mirror");
  v.number("size", p.size, 1e-4, 0.6, "1", "sine of the angle between the lamp's middle and its edge");
}

// Of n photons that arrive evenly within a kernel, a narrow lobe makes an estimate of relative variance
// 1 / (12 alpha^2 cos^2 n), cos to the viewer: pi times the integral of f^2 cos, over the albedo squared.
Scene make_glossy_furnace(const GlossyFurnaceParams& params);

// The camera sees a lamp in the mirror, at 45 degrees, of radiance 1 in the middle. A direction of a narrow lobe finds it with
// a chance of p = 1 / (1 + q), q = 4 alpha^2 cos / size^2, and thus has a relative variance of q; a point of the lamp has one
// of (1 + q)^2 / (3 q) - 1. By multiple importance sampling it is small in both cases.
Scene make_glossy_lamp(const GlossyLampParams& params);

// The share of light from `cosine` to the normal that the microfacets send back, in double precision and within 1e-5 for a
// cosine above 0.3.
double ggx_albedo(double alpha, double cosine);
// The share of a lamp's radiance that they send to the unit vector `to_viewer`, from a sphere that is seen in the direction
// `to_lamp` and of a size as above. The normal is z; the lamp lies above the horizon.
double ggx_lamp_share(double alpha, double size, const dvec3& to_viewer, const dvec3& to_lamp);

}  // namespace etendue
