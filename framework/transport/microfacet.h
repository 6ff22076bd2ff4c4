// The GGX distribution of normals with Smith's height-correlated masking ([Walter2007], [Heitz2014]), sampled by visible
// normals ([Heitz2018]).
// Directions are local, z along the macroscopic normal; wo.z > 0 and the half vector's z > 0 throughout.
#pragma once

#include "framework/core/vec.h"

namespace etendue {

class Ggx {
 public:
  explicit Ggx(const vec2& alpha) : alpha_(glm::max(alpha, vec2(1e-4f))) {}

  // D(h), per solid angle of h, with integral of D cos = 1.
  float density(const vec3& h) const {
    const float x = h.x / alpha_.x, y = h.y / alpha_.y;
    const float s = x * x + y * y + h.z * h.z;
    return 1 / (pi * alpha_.x * alpha_.y * s * s);
  }
  float lambda(const vec3& w) const {
    const float a = square(w.x * alpha_.x) + square(w.y * alpha_.y);
    return 0.5f * (std::sqrt(1 + a / (w.z * w.z)) - 1);
  }
  float masking(const vec3& w) const { return 1 / (1 + lambda(w)); }
  float masking_shadowing(const vec3& wo, const vec3& wi) const { return 1 / (1 + lambda(wo) + lambda(wi)); }

  // Density of the visible normals seen from wo: D(h) G1(wo) (wo.h) / wo.z.
  float visible_density(const vec3& wo, const vec3& h) const {
    return density(h) * masking(wo) * std::max(0.0f, glm::dot(wo, h)) / wo.z;
  }
  vec3 sample_visible(const vec3& wo, const vec2& u) const {
    const vec3 v = glm::normalize(vec3(alpha_.x * wo.x, alpha_.y * wo.y, wo.z));
    const float length2 = v.x * v.x + v.y * v.y;
    const vec3 t1 = length2 > 0 ? vec3(-v.y, v.x, 0) / std::sqrt(length2) : vec3(1, 0, 0);
    const vec3 t2 = glm::cross(v, t1);
    const float r = std::sqrt(u.x), phi = 2 * pi * u.y, s = 0.5f * (1 + v.z);
    const float p1 = r * std::cos(phi);
    const float p2 = (1 - s) * safe_sqrt(1 - p1 * p1) + s * r * std::sin(phi);
    const vec3 n = p1 * t1 + p2 * t2 + safe_sqrt(1 - p1 * p1 - p2 * p2) * v;
    return glm::normalize(vec3(alpha_.x * n.x, alpha_.y * n.y, std::max(1e-6f, n.z)));
  }

 private:
  vec2 alpha_;
};

}  // namespace etendue
