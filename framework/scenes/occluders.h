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

struct HiddenOccluderParams : VeilParams {
  float light = 0.5f;
};

template <class Visitor>
void describe(Visitor& v, HiddenOccluderParams& p) {
  v.number("light", p.light, 0.01, 4, "m",
           "side of the light, of the same power at any size: a fifth of it is the width of the penumbra");
  describe(v, static_cast<VeilParams&>(p));
}

struct SlitLightParams : VeilParams {
  float width = 0.04f;
};

template <class Visitor>
void describe(Visitor& v, SlitLightParams& p) {
  v.number("width", p.width, 1e-4, 3, "m", "of the slit, of the same power at any width");
  describe(v, static_cast<VeilParams&>(p));
}

struct ThinWallParams : VeilParams {
  float day = 1;
};

template <class Visitor>
void describe(Visitor& v, ThinWallParams& p) {
  v.number("day", p.day, 0.001, 1000, "1", "times the light of the bright side: at 1, it is 15 times as bright as the other");
  describe(v, static_cast<VeilParams&>(p));
}

struct BlackSurroundingsParams : VeilParams {
  float walls = 0;
};

template <class Visitor>
void describe(Visitor& v, BlackSurroundingsParams& p) {
  v.number("walls", p.walls, 0, 100, "W/(m^2 sr)", "radiance of walls and ceiling; that of the light is 13");
  describe(v, static_cast<VeilParams&>(p));
}

Scene make_broad_light(const BroadLightParams& params);      // no occluder: smooth everywhere, for rates of convergence
Scene make_two_occluders(const TwoOccludersParams& params);  // a wide light, two plates between: penumbrae across each other
// A small far light behind a plate: a shadow with hardly a penumbra.
Scene make_hidden_occluder(const HiddenOccluderParams& params);
Scene make_slit_light(const SlitLightParams& params);  // a slit in a wall: few rays find it
Scene make_thin_wall(const ThinWallParams& params);    // bright on one side, dim on the other
// All black but for a small light: nothing to take a distance from, unless the walls glow.
Scene make_black_surroundings(const BlackSurroundingsParams& params);

}  // namespace etendue
