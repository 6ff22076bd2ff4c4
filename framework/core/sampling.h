// Warps of the unit square, each with its density, of a point or of a point in each lane (lanes.h).
#pragma once

#include "framework/core/lanes.h"

namespace etendue {

template <class F>
struct CosSin {
  F cosine, sine;
};

// Cosine and sine of an angle in [-pi/4, pi/4], within 8e-8: polynomials in its square, without a branch.
template <class F>
CosSin<F> cos_sin_within_eighth(F angle) {
  const F x = angle * angle;
  return {1 - 0.5f * x + x * x * (4.166664568e-2f + x * (-1.388731625e-3f + x * 2.443315712e-5f)),
          angle + angle * x * (-1.666665461e-1f + x * (8.332160874e-3f + x * -1.951529589e-4f))};
}

// Cosine and sine of 2 pi u for u in [0, 1]: those of what is left to the nearest quarter turn, rotated by that turn.
template <class F>
CosSin<F> cos_sin_of_turn(F u) {
  const F quarter = floor(4 * u + 0.5f);
  const CosSin<F> rest = cos_sin_within_eighth(2 * pi * (u - 0.25f * quarter));
  const Mask<F> odd = (quarter == 1) | (quarter == 3), back = (quarter == 1) | (quarter == 2);
  const F cosine = select(odd, rest.sine, rest.cosine), sine = select(odd, rest.cosine, rest.sine);
  return {select(back, -cosine, cosine), select((quarter == 2) | (quarter == 3), -sine, sine)};
}

// Concentric map of [Shirley1997]; uniform on the unit disk. The two pairs of wedges differ only by the order of the
// coordinates, which are swapped without a branch: it could not be predicted.
template <class V>
V sample_unit_disk(const V& u) {
  using F = LaneOf<V>;
  const V p = 2.0f * u - 1.0f;
  const Bits<F> steep = select(abs(p.y) >= abs(p.x), Bits<F>(0xffffffffu), Bits<F>(0u));
  const auto swapped = [steep](F x, F y) {
    const Bits<F> change = (bits_of(x) ^ bits_of(y)) & steep;
    return V(float_of(bits_of(x) ^ change), float_of(bits_of(y) ^ change));
  };
  const V q = swapped(p.x, p.y);  // the larger one first
  const CosSin<F> turn = cos_sin_within_eighth(0.25f * pi * (q.y / q.x));
  const Mask<F> centre = q.x == 0;
  return swapped(select(centre, F(0.0f), q.x * turn.cosine), select(centre, F(0.0f), q.x * turn.sine));
}

// Density cos / pi over the hemisphere about +z.
template <class V>
Vec3<LaneOf<V>> sample_cosine_hemisphere(const V& u) {
  const V d = sample_unit_disk(u);
  return {d.x, d.y, safe_sqrt(1 - d.x * d.x - d.y * d.y)};
}

// Density 1 / (4 pi).
template <class V>
Vec3<LaneOf<V>> sample_unit_sphere(const V& u) {
  const auto z = 1 - 2 * u.x, r = safe_sqrt(1 - z * z);
  const auto turn = cos_sin_of_turn(u.y);
  return {r * turn.cosine, r * turn.sine, z};
}

// Density 1 / (2 pi height) over the cone about +z whose cap of the unit sphere is so high: 1 - cos of its half angle. The sine
// is taken from the height, since the cosine of a narrow cone's directions is rounded to few values.
template <class V>
Vec3<LaneOf<V>> sample_cone(const V& u, LaneOf<V> height) {
  const auto below = u.x * height, r = safe_sqrt(below * (2 - below));
  const auto turn = cos_sin_of_turn(u.y);
  return {r * turn.cosine, r * turn.sine, 1 - below};
}

// Barycentric weights of the second and third vertex; uniform over the triangle.
template <class V>
V sample_triangle(const V& u) {
  const auto root = sqrt(u.x);
  return {root * (1 - u.y), root * u.y};
}

}  // namespace etendue
