// Exact scenes of lamps over a floor that are hard to find: behind glass, where no shadow ray gets through, or among many that
// light nothing.
#pragma once

#include "framework/scenes/borders.h"

namespace etendue {

struct VeiledLampParams : VeilParams {
  float radius = 0.1f;
  std::string seen = "directly";
};

template <class Visitor>
void describe(Visitor& v, VeiledLampParams& p) {
  v.number("radius", p.radius, 1e-4, 0.3, "m", "of the lamp, a sphere a metre above the floor, of the same power at any size");
  v.choice("seen", p.seen, {"directly", "through"}, "the floor; through: a second pane, before the camera");
  describe(v, static_cast<VeilParams&>(p));
}

struct ManyLampsParams {
  int lamps = 1;
};

template <class Visitor>
void describe(Visitor& v, ManyLampsParams& p) {
  v.integer("lamps", p.lamps, 1, 1'000'000, "lamps", "of the same power; all but one hang below the floor");
}

// What finds the lamp by chance, with directions in proportion to the cosine, does so with a chance of (radius / distance)^2
// cos: the relative variance of n samples is (1 - p) / (n p).
Scene make_veiled_lamp(const VeiledLampParams& params);
// Where lamps are chosen in proportion to their power, the relative variance of n samples is (lamps - 1) / n.
Scene make_many_lamps(const ManyLampsParams& params);

}  // namespace etendue
