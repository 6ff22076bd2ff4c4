// Directions of an environment's image in proportion to its luminance.
#pragma once

#include "framework/scene/light.h"

namespace etendue {

// A piecewise-constant density over the image's square: chooses a row (its texels weighted by sin theta), then a texel within
// the row. Empty where the environment is constant.
class ImageDistribution {
 public:
  explicit ImageDistribution(const EnvironmentLight& light);

  bool empty() const { return density_.empty(); }
  vec2 sample(vec2 u) const;
  // The density is over solid angle.
  float pdf(const vec2& uv) const;

 private:
  ivec2 size_{0};
  std::vector<float> rows_;     // cumulative
  std::vector<float> columns_;  // cumulative within each row
  std::vector<float> density_;  // per texel, over the unit square of uv
};

inline ivec2 texel_at(ivec2 size, const vec2& uv) { return glm::clamp(ivec2(uv * vec2(size)), ivec2(0), size - 1); }

}  // namespace etendue
