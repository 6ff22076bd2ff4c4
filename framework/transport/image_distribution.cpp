#include "framework/transport/image_distribution.h"

#include "framework/core/elementary.h"
#include "framework/transport/cumulative.h"

#include <cmath>

namespace etendue {

ImageDistribution::ImageDistribution(const EnvironmentLight& light) : size_(light.size) {
  const std::size_t count = light.texels.size();
  rows_.resize(size_.y);
  columns_.resize(count);
  density_.resize(count);
  double total = 0;
  for (int y = 0; y < size_.y; ++y) {
    const float sine = math::sin(pi * (static_cast<float>(y) + 0.5f) / static_cast<float>(size_.y));
    double row = 0;
    for (int x = 0; x < size_.x; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * size_.x + x;
      density_[i] = luminance(light.texels[i]) * sine;
      row += density_[i];
      columns_[i] = static_cast<float>(row);
    }
    for (int x = 0; x < size_.x; ++x) {
      float& c = columns_[static_cast<std::size_t>(y) * size_.x + x];
      c = row > 0 ? static_cast<float>(c / row) : static_cast<float>(x + 1) / static_cast<float>(size_.x);
    }
    total += row;
    rows_[y] = static_cast<float>(total);
  }
  for (float& r : rows_) r = static_cast<float>(r / total);
  for (float& d : density_) d = static_cast<float>(d * static_cast<double>(count) / total);
}

vec2 ImageDistribution::sample(vec2 u) const {
  const auto y = static_cast<int>(pick(rows_.data(), rows_.size(), u.y));
  const auto x = static_cast<int>(pick(columns_.data() + static_cast<std::size_t>(y) * size_.x, size_.x, u.x));
  return (vec2(x, y) + u) / vec2(size_);
}

float ImageDistribution::pdf(const vec2& uv) const {
  const ivec2 t = texel_at(size_, uv);
  const float sine = math::sin(pi * uv.y);
  return sine > 0 ? density_[pixel_index(t, size_)] / (2 * pi * pi * sine) : 0;
}

}  // namespace etendue
