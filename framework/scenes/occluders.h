// Exact scenes of irradiance that changes faster than what a hemisphere of rays tells of: where irradiance caches blur, leak or
// place too few records. One diffuse floor; all else is black or emits, so the floor's light is that of parts of rectangles and
// discs. It comes through a veil (exact_stage.h): irradiance caches take it for indirect light.
#pragma once

#include "framework/scenes/borders.h"

namespace etendue {

struct BroadLightParams : VeilParams {
  float height = 1.3f;
};

template <class Visitor>
void describe(Visitor& v, BroadLightParams& p) {
  v.number("height", p.height, 1.3, 100, "m",
           "of the light, which is 1.23 times as wide: the length on which irradiance changes");
  describe(v, static_cast<VeilParams&>(p));
}

struct TwoOccludersParams : VeilParams {
  float light = 1;
};

template <class Visitor>
void describe(Visitor& v, TwoOccludersParams& p) {
  v.number("light", p.light, 0.1, 10, "of 1.8 m x 1.4 m",
           "size of the light behind the plates: up to size 2, some of the floor is black; from 2.5 on, none");
  describe(v, static_cast<VeilParams&>(p));
}

Scene make_broad_light(const BroadLightParams& params);      // no occluder: smooth everywhere, for rates of convergence
Scene make_two_occluders(const TwoOccludersParams& params);  // a wide light, two plates between: penumbrae across each other
Scene make_hidden_occluder(const VeilParams& params);     // a small far light behind a plate: a shadow with hardly a penumbra
Scene make_slit_light(const VeilParams& params);          // a slit in a wall: few rays find it
Scene make_thin_wall(const VeilParams& params);           // bright on one side, dim on the other
Scene make_black_surroundings(const VeilParams& params);  // all black but for a small light: nothing to take a distance from

}  // namespace etendue
