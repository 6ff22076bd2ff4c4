// Distributions of microfacets' normals with Smith's height-correlated masking ([Heitz2014]): GGX ([Walter2007]), sampled by
// visible normals ([Heitz2018]), and Beckmann's ([Walter2007] eq. 25 to 29), sampled in proportion to D cos.
// Directions are local, z along the macroscopic normal; wo.z > 0 throughout. Half vectors have z > 0.
#pragma once

#include "framework/core/elementary.h"
#include "framework/core/sampling.h"

namespace etendue {

enum class NormalDistribution : std::uint8_t { ggx, beckmann };

// Calls the function for each lane. Few surfaces need what no instruction set has, and those take it lane by lane.
template <class F, class Function>
[[gnu::noinline]] F each_lane(F x, Function function) {
  F y = 0.0f;
  for_lanes(Mask<F>(true), [&](int i) { set_lane(y, i, function(lane(x, i))); });
  return y;
}

class Microfacets {
 public:
  Microfacets(const vec2& alpha, NormalDistribution distribution)
      : alpha_(glm::max(alpha, vec2(1e-4f))), beckmann_(distribution == NormalDistribution::beckmann) {}

  // D(h), per solid angle of h, with integral of D cos = 1.
  template <class V>
  auto density(const V& h) const {
    using F = LaneOf<V>;
    const auto x = h.x / alpha_.x, y = h.y / alpha_.y;
    if (beckmann_) [[unlikely]] {
      const F cos2 = h.z * h.z, gauss = each_lane<F>(-(x * x + y * y) / cos2, [](float e) { return math::exp(e); });
      return select(cos2 > 1e-9f, gauss / (pi * alpha_.x * alpha_.y * cos2 * cos2), F(0.0f));
    }
    const auto s = x * x + y * y + h.z * h.z;
    return 1 / (pi * alpha_.x * alpha_.y * s * s);
  }
  template <class V>
  auto lambda(const V& w) const {
    using F = LaneOf<V>;
    const auto a = square(w.x * alpha_.x) + square(w.y * alpha_.y);
    if (beckmann_) [[unlikely]] {
      // [Walter2007] eq. 27, their fit of the masking function; c is 1 / (alpha tan).
      const F c = abs(w.z) / sqrt(a);
      return select(c < 1.6f, (1 - 1.259f * c + 0.396f * c * c) / (3.535f * c + 2.181f * c * c), F(0.0f));
    }
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

  // Density of `sample_normal`: of the visible normals seen from wo, D(h) G1(wo) (wo.h) / wo.z, or D(h) cos.
  template <class V>
  auto normal_density(const V& wo, const V& h) const {
    if (beckmann_) [[unlikely]]
      return density(h) * h.z;
    return density(h) * masking(wo) * max(0.0f, dot(wo, h)) / wo.z;
  }
  template <class V>
  V sample_normal(const V& wo, const Vec2<LaneOf<V>>& u) const {
    using F = LaneOf<V>;
    if (beckmann_) [[unlikely]] {
      const F slope = sqrt(each_lane<F>(u.x, [](float share) { return -math::log(1 - share); }));
      const CosSin<F> turn = cos_sin_of_turn(u.y);
      return normalize(V(alpha_.x * slope * turn.cosine, alpha_.y * slope * turn.sine, 1.0f));
    }
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
  bool beckmann_;
};

}  // namespace etendue
