// A hemisphere in M x N strata, for paths that begin over it: one direction in each.
//
// Over lanes (framework/core/lanes.h): one direction, or one in each lane.
#pragma once

#include "framework/core/sampling.h"

namespace etendue {

struct HemisphereStrata {
  int theta = 1, phi = 1;

  // About `samples` strata, as square as they can be: N ~ pi M.
  static HemisphereStrata of(int samples) {
    const int theta = std::max(1, static_cast<int>(std::lround(std::sqrt(static_cast<float>(samples) / pi))));
    return {theta, std::max(1, static_cast<int>(std::lround(static_cast<float>(samples) / static_cast<float>(theta))))};
  }
  int count() const { return theta * phi; }
  // Unit, about +z; stratum i = j * phi + k, `u` jitters within it.
  vec3 direction(int i, const vec2& u) const {
    return cosine_direction(static_cast<float>(i / phi), static_cast<float>(i % phi), u);
  }
  // The same of ring j and sector k, over lanes (framework/core/lanes.h).
  template <class F>
  Vec3<F> cosine_direction(F ring, F sector, const Vec2<F>& u) const {
    const F sin2 = min((ring + u.x) / static_cast<float>(theta), F(0x1.fffffep-1f)), sine = sqrt(sin2);
    const CosSin<F> turn = cos_sin_of_turn((sector + u.y) / static_cast<float>(phi));
    return {sine * turn.cosine, sine * turn.sine, sqrt(1 - sin2)};
  }
  // Likewise of strata whose rings are equal steps in cos(theta): uniform over solid angle.
  vec3 even_direction(int i, const vec2& u) const {
    return even_direction(static_cast<float>(i / phi), static_cast<float>(i % phi), u);
  }
  template <class F>
  Vec3<F> even_direction(F ring, F sector, const Vec2<F>& u) const {
    const F z = 1 - (ring + u.x) / static_cast<float>(theta), sine = safe_sqrt(1 - z * z);
    const CosSin<F> turn = cos_sin_of_turn((sector + u.y) / static_cast<float>(phi));
    return {sine * turn.cosine, sine * turn.sine, z};
  }
};

}  // namespace etendue
