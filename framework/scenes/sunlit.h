// Exact scenes in the sun, each with a length on which a density estimate, or the precision of floats, depends.
#pragma once

#include "framework/scenes/borders.h"

namespace etendue {

struct SunlitFieldParams : VeilParams {
  float surroundings = 1;
};

template <class Visitor>
void describe(Visitor& v, SunlitFieldParams& p) {
  v.number("surroundings", p.surroundings, 1, 1e4, "of 2 m",
           "width of the field, of which the camera sees the middle: photons per area fall with its square");
  describe(v, static_cast<VeilParams&>(p));
}

struct SunlitBallParams : VeilParams {
  float radius = 1;
};

template <class Visitor>
void describe(Visitor& v, SunlitBallParams& p) {
  v.number("radius", p.radius, 1e-3, 1e3, "m", "of the ball; the image is the same at any");
  describe(v, static_cast<VeilParams&>(p));
}

struct FarKerbParams {
  float distance = 0;
};

template <class Visitor>
void describe(Visitor& v, FarKerbParams& p) {
  v.number("distance", p.distance, 0, 1e6, "m", "from the middle of the scene, where floats lie distance / 2^24 apart");
}

// Even light as far as the camera sees, so that a density estimate of n photons has a variance of 1 / n and no bias.
Scene make_sunlit_field(const SunlitFieldParams& params);
// Of the ball a kernel of radius r cuts out a cap of area pi r^2, whose mean cosine to the sun is 1 - (r / 2R)^2 of that in its
// middle: so much light a box kernel finds of what there is, as long as the sun reaches the whole cap.
Scene make_sunlit_ball(const SunlitBallParams& params);
// The low sun casts the shadow of a kerb of 5 cm over half of what is seen, one metre long. Rays leave the floor a height above
// it and look over the kerb from height / 5 cm of the shadow's end: 16 clearances for floors seen from above
// (SurfacePoint::retreat), of 6 / 2^24 of the distance each (framework/scene/clearance.h).
Scene make_far_kerb(const FarKerbParams& params);

}  // namespace etendue
