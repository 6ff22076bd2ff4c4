// Where a ray lies within a box: entry and exit, by the rules of slab_entry (framework/scene/intersect.h): planes picked by the
// sign of the direction, a NaN restricts nothing, exits padded ([Ize2013]).
#pragma once

#include "accel/kernels/traversal_limit.h"
#include "framework/scene/intersect.h"

namespace etendue {

struct BoxInterval {
  float entry, exit;

  bool empty() const { return entry > exit; }
};

inline BoxInterval box_interval(const SlabRay& ray, const Bounds& box, float t_min, float t_max) {
  BoxInterval interval{t_min, t_max};
  for (int axis = 0; axis < 3; ++axis) {
    const float near_plane = ray.negative[axis] ? box.upper[axis] : box.lower[axis];
    const float far_plane = ray.negative[axis] ? box.lower[axis] : box.upper[axis];
    const float t_near = (near_plane - ray.origin[axis]) * ray.reciprocal[axis];
    const float t_far = (far_plane - ray.origin[axis]) * ray.reciprocal[axis] * slab_pad;
    interval.entry = t_near > interval.entry ? t_near : interval.entry;
    interval.exit = t_far < interval.exit ? t_far : interval.exit;
  }
  return interval;
}

}  // namespace etendue
