// The padded slab test ([Williams2005], [Ize2013]): where a ray enters and leaves a box, with a box, or a ray, in each lane.
//
// The near and the far plane of each axis are picked by the sign bit of the direction, so -0 is as good as any negative number.
// A ray parallel to a slab and outside it gets the infinity that misses; inside, both are infinities that do not restrict; on a
// face 0 * infinity is NaN, and the comparisons are ordered so that a NaN restricts nothing: faces belong to the box. Far
// distances are padded by 4 epsilon, above the 2 gamma(3) by which rounding can part near from far, so that no box is lost
// whose content is hit.
#pragma once

#include "accel/kernels/floats.h"
#include "framework/query.h"

#include <array>

namespace etendue {

inline constexpr float slab_pad = 1.0f + 4 * std::numeric_limits<float>::epsilon();

// Reciprocals for slab tests. That of a subnormal component that overflows is NaN, which restricts nothing: the ray does cross
// the slab, though at distances of the order of 1e38 times the slab's, and an infinity would deny it.
inline vec3 slab_reciprocal(const vec3& direction) {
  vec3 reciprocal = 1.0f / direction;
  for (int axis = 0; axis < 3; ++axis)
    if (std::isinf(reciprocal[axis]) && direction[axis] != 0) [[unlikely]]
      reciprocal[axis] = std::numeric_limits<float>::quiet_NaN();
  return reciprocal;
}

// Holds what the test needs of a ray.
struct SlabRay {
  vec3 origin, reciprocal, padded_reciprocal;  // padded: for far planes
  float t_min;
  std::uint32_t negative;  // a bit per axis: the direction's sign

  SlabRay() = default;
  explicit SlabRay(const Ray& ray)
      : SlabRay(ray, slab_reciprocal(ray.direction),
                std::signbit(ray.direction.x) | std::signbit(ray.direction.y) << 1 | std::signbit(ray.direction.z) << 2) {}
  [[gnu::always_inline]] SlabRay(const Ray& ray, const vec3& slab_reciprocal, std::uint32_t signs)
      : origin(ray.origin),
        reciprocal(slab_reciprocal),
        padded_reciprocal(slab_reciprocal * slab_pad),
        t_min(ray.t_min),
        negative(signs) {}

  bool is_negative(int axis) const { return negative >> axis & 1; }
};

// Tells by the signs of a direction which of a box's six planes are the near and the far ones of each axis, each `stride`
// floats after the one before, in the order lower x, y, z, upper x, y, z.
struct PlanePlaces {
  std::uint32_t near[3], far[3];
};
template <int stride>
inline constexpr auto plane_places = [] {
  std::array<PlanePlaces, 8> places{};
  for (std::uint32_t signs = 0; signs < 8; ++signs)
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t negative = signs >> axis & 1;
      places[signs].near[axis] = (axis + 3 * negative) * stride;
      places[signs].far[axis] = (axis + 3 * (1 - negative)) * stride;
    }
  return places;
}();

template <class Lanes, int stride>
class BoxTest {
 public:
  // Holds what the planes of an axis take from the ray. Far distances are padded by padding the reciprocals they are multiplied
  // with, which takes no step of its own.
  struct Axis {
    Lanes origin, reciprocal, padded_reciprocal;
    [[gnu::always_inline]] Lanes near(const Lanes& planes) const { return (planes - origin) * reciprocal; }
    [[gnu::always_inline]] Lanes far(const Lanes& planes) const { return (planes - origin) * padded_reciprocal; }
  };

  [[gnu::always_inline]] explicit BoxTest(const SlabRay& ray)
      : BoxTest(plane_places<stride>[ray.negative], Lanes::set(ray.t_min), axis(ray, 0), axis(ray, 1), axis(ray, 2)) {}
  // Takes a ray in each lane; their directions have the same signs.
  [[gnu::always_inline]] BoxTest(const PlanePlaces& places, const Lanes& t_min, const Axis& x, const Axis& y, const Axis& z)
      : places_(places), t_min_(t_min), x_(x), y_(y), z_(z) {}

  // Narrows `far` from the limit of the search. `plane(place)` gives a plane of the boxes.
  template <class Plane>
  [[gnu::always_inline]] void interval(const Plane& plane, Lanes& near, Lanes& far) const {
    near = larger(x_.near(plane(places_.near[0])), t_min_);
    near = larger(y_.near(plane(places_.near[1])), near);
    near = larger(z_.near(plane(places_.near[2])), near);
    far = smaller(x_.far(plane(places_.far[0])), far);
    far = smaller(y_.far(plane(places_.far[1])), far);
    far = smaller(z_.far(plane(places_.far[2])), far);
  }
  // A bit per lane that the ray meets before `limit`; `near`: where it enters, infinite where it does not.
  template <class Plane>
  [[gnu::always_inline]] unsigned met(const Plane& plane, Lanes limit, Lanes& near) const {
    interval(plane, near, limit);
    const unsigned met = less_equal(near, limit);
    near = infinite_above(near, limit);
    return met;
  }

 private:
  [[gnu::always_inline]] static Axis axis(const SlabRay& ray, int axis) {
    return {Lanes::set(component(ray.origin, axis)), Lanes::set(component(ray.reciprocal, axis)),
            Lanes::set(component(ray.padded_reciprocal, axis))};
  }

  const PlanePlaces& places_;
  const Lanes t_min_;
  const Axis x_, y_, z_;
};

struct BoxInterval {
  float entry, exit;

  bool empty() const { return entry > exit; }
};

// One box before `limit`.
inline BoxInterval box_interval(const SlabRay& ray, const Bounds& box, float limit) {
  static_assert(sizeof(Bounds) == 6 * sizeof(float));
  using One = Floats<1, 1>;
  One near, far{limit};
  BoxTest<One, 1>(ray).interval([&](std::uint32_t plane) { return One{(&box.lower.x)[plane]}; }, near, far);
  return {near.v, far.v};
}

// How far a traversal must look to miss no hit nearer than the best so far, or tied with it.
//
// A triangle's t is rounded in proportion to the coordinates it is computed from, a box's entry in proportion to itself: close
// to a large triangle, t can be less than the entry of the very box the triangle lies in. So boxes are entered a little beyond
// the best distance: by 4 epsilon of it, and by 16 epsilon of the largest coordinate, as a distance along the ray.
class TraversalLimit {
 public:
  // `extent`: largest_coordinate of what the structure holds.
  TraversalLimit(const Ray& ray, float extent)
      : TraversalLimit(max_component(glm::abs(ray.origin)), extent, max_component(glm::abs(ray.direction))) {}
  // `origin` and `direction` are the largest components of a ray's.
  TraversalLimit(float origin, float extent, float direction)
      : slack_(16 * std::numeric_limits<float>::epsilon() * (origin + extent) / direction) {}

  float operator()(float t_best) const { return t_best * slab_pad + slack_; }

 private:
  float slack_;
};

inline float largest_coordinate(const Bounds& b) {
  return std::max(max_component(glm::abs(b.lower)), max_component(glm::abs(b.upper)));
}

}  // namespace etendue
