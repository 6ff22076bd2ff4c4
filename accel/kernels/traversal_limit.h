// How far a traversal must look to miss no hit nearer than the best so far, or tied with it.
//
// A triangle's t is rounded in proportion to the coordinates it is computed from, a box's entry in proportion to itself: close
// to a large triangle, t can be less than the entry of the very box the triangle lies in. So boxes are entered a little beyond
// the best distance: by 4 epsilon of it, and by 16 epsilon of the largest coordinate, as a distance along the ray.
#pragma once

#include "framework/query.h"

namespace etendue {

// The padding of distances to a slab's far plane: 4 epsilon is above the 2 gamma(3) by which rounding can part its two ends
// ([Ize2013]).
inline constexpr float slab_pad = 1.0f + 4 * std::numeric_limits<float>::epsilon();

inline float largest_coordinate(const Bounds& b) {
  return std::max(max_component(glm::abs(b.lower)), max_component(glm::abs(b.upper)));
}

class TraversalLimit {
 public:
  // `extent`: largest_coordinate of what the structure holds.
  TraversalLimit(const Ray& ray, float extent)
      : TraversalLimit(max_component(glm::abs(ray.origin)), extent, max_component(glm::abs(ray.direction))) {}
  // By the largest components of a ray's origin and direction.
  TraversalLimit(float origin, float extent, float direction)
      : slack_(16 * std::numeric_limits<float>::epsilon() * (origin + extent) / direction) {}

  float operator()(float t_best) const { return t_best * slab_pad + slack_; }

 private:
  float slack_;
};

}  // namespace etendue
