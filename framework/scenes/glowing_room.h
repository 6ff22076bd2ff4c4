// A closed room whose walls, and two boxes on its floor, glow evenly, each in its own colour, and reflect once: what indirect
// light in a room is to a cache, but known exactly. A square of the ceiling is brighter than the rest. No place is black; the
// boxes make penumbrae and dark corners.
#pragma once

#include "framework/core/params.h"
#include "framework/scene/scene.h"

namespace etendue {

struct GlowingRoomParams {
  float panel = 1;
  float walls = 1;
};

template <class Visitor>
void describe(Visitor& v, GlowingRoomParams& p) {
  v.number("panel", p.panel, 0.05, 2, "m", "side of the bright square of the ceiling, of the same power at any size");
  v.number("walls", p.walls, 0, 10, "1", "times their glow: of all but that square, the boxes' too");
}

Scene make_glowing_room(const GlowingRoomParams& params);

}  // namespace etendue
