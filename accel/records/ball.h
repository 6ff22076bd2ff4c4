// A ball as the structures hold it, and the rule by which it covers a point.
#pragma once

#include "accel/points/neighbourhood.h"

namespace etendue {

struct Ball {
  vec3 centre;
  float radius;
  std::uint32_t id;
};

// Balls with a centre that is not finite, or a negative or NaN radius, cover nothing and are not kept. An infinite radius
// covers everything.
inline bool is_ball(const vec3& centre, float radius) { return is_finite(centre) && radius >= 0; }

inline void add_if_covering(const Ball& ball, const vec3& p, Neighbours& out) {
  const float d2 = distance_squared(ball.centre, p);
  if (d2 <= ball.radius * ball.radius && is_finite(p)) out.push_back({ball.id, d2});
}

inline void sort_by_id(Neighbours& found) {
  std::sort(found.begin(), found.end(), [](const Neighbour& a, const Neighbour& b) { return a.id < b.id; });
}

}  // namespace etendue
