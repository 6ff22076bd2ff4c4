// The GGX distribution of normals with Smith's height-correlated masking ([Walter2007], [Heitz2014]), sampled by visible
// normals ([Heitz2018]).
// Directions are local, z along the macroscopic normal; wo.z > 0 and the half vector's z > 0 throughout.
#pragma once

#include "framework/core/sampling.h"

namespace etendue {

class Ggx {
 public:
  explicit Ggx(const vec2& alpha) : alpha_(glm::max(alpha, vec2(1e-4f))) {}

  // D(h), per solid angle of h, with integral of D cos = 1.
  template <class V>
  auto density(const V& h) const {
    const auto x = h.x / alpha_.x, y = h.y / alpha_.y;
    const auto s = x * x + y * y + h.z * h.z;
    return 1 / (pi * alpha_.x * alpha_.y * s * s);
  }
  template <class V>
  auto lambda(const V& w) const {
    const auto a = square(w.x * alpha_.x) + square(w.y * alpha_.y);
    return 0.5f * (sqrt(1 + a / (w.z * w.z)) - 1);
  }
  template <class V>
  auto masking(const V& w) const {
    return 1 / (1 + lambda(w));
  }
  template <class V>
  auto masking_shadowing(const V& wo, const V& wi) const {
    return 1 / (1 + lambda(wo) + lambda(wi));
  }

  // Density of the visible normals seen from wo: D(h) G1(wo) (wo.h) / wo.z.
  template <class V>
  auto visible_density(const V& wo, const V& h) const {
    return density(h) * masking(wo) * max(0.0f, dot(wo, h)) / wo.z;
  }
  template <class V>
  V sample_visible(const V& wo, const Vec2<LaneOf<V>>& u) const {
    using F = LaneOf<V>;
    const V v = normalize(V(alpha_.x * wo.x, alpha_.y * wo.y, wo.z));
    const F length2 = v.x * v.x + v.y * v.y;
    const V t1 = select(length2 > 0, V(-v.y, v.x, 0.0f) / sqrt(length2), V(1.0f, 0.0f, 0.0f));
    const V t2 = cross(v, t1);
    const CosSin<F> turn = cos_sin_of_turn(u.y);
    const F r = sqrt(u.x), s = 0.5f * (1 + v.z);
    const F p1 = r * turn.cosine;
    const F p2 = (1 - s) * safe_sqrt(1 - p1 * p1) + s * r * turn.sine;
    const V n = p1 * t1 + p2 * t2 + safe_sqrt(1 - p1 * p1 - p2 * p2) * v;
    return normalize(V(alpha_.x * n.x, alpha_.y * n.y, max(1e-6f, n.z)));
  }

 private:
  vec2 alpha_;
};

}  // namespace etendue
