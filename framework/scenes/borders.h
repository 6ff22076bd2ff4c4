// Exact scenes of even light that ends at a border: where density estimates darken, leak through a plate, or take light from
// the wrong wall. The sun lights them through a veil (exact_stage.h), so its light is a caustic to every method.
#pragma once

#include "framework/core/params.h"
#include "framework/scene/scene.h"

namespace etendue {

struct VeilParams {
  bool veil = true;
};

template <class Visitor>
void describe(Visitor& v, VeilParams& p) {
  v.flag("veil", p.veil, "before the light, a pane of index 1: no shadow ray gets through, the image stays the same");
}

struct EdgeParams : VeilParams {
  float size = 2;
};

template <class Visitor>
void describe(Visitor& v, EdgeParams& p) {
  v.number("size", p.size, 1e-3, 1e3, "m", "side of the patch; the image is the same at any");
  describe(v, static_cast<VeilParams&>(p));
}

struct ThinPlateParams : VeilParams {
  float thickness = 0.01f;
};

template <class Visitor>
void describe(Visitor& v, ThinPlateParams& p) {
  v.number("thickness", p.thickness, 1e-4, 0.5, "m", "of the plate, two metres wide");
  describe(v, static_cast<VeilParams&>(p));
}

Scene make_edge(const EdgeParams& params);    // a square patch: a density estimate keeps 1 - (acos x - x sqrt(1 - x^2)) / pi
Scene make_corner(const VeilParams& params);  // two walls that meet; paths end before they light each other
// Lit from above, seen from below, where it glows faintly: without a test of sides 1 - (t/r)^2 of the light leaks.
Scene make_thin_plate(const ThinPlateParams& params);

}  // namespace etendue
