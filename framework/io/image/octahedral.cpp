#include "framework/io/image/octahedral.h"

#include "framework/core/check.h"
#include "framework/core/elementary.h"
#include "framework/core/fuzzing.h"
#include "framework/core/memory.h"
#include "framework/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace etendue {

namespace {

// Past an edge of the square the sphere goes on at that edge, mirrored about its middle.
Rgb texel(const RgbImage& square, int x, int y) {
  const int n = square.size.x;
  if (x < 0 || x >= n) {
    x = x < 0 ? -1 - x : 2 * n - 1 - x;
    y = n - 1 - y;
  }
  if (y < 0 || y >= n) {
    x = n - 1 - x;
    y = y < 0 ? -1 - y : 2 * n - 1 - y;
  }
  return square.texels[static_cast<std::size_t>(y) * n + x];
}

Rgb bilinear(const RgbImage& square, const vec2& p) {
  const vec2 position = p * static_cast<float>(square.size.x) - 0.5f, base = glm::floor(position), f = position - base;
  const int x = static_cast<int>(base.x), y = static_cast<int>(base.y);
  return glm::mix(glm::mix(texel(square, x, y), texel(square, x + 1, y), f.x),
                  glm::mix(texel(square, x, y + 1), texel(square, x + 1, y + 1), f.x), f.y);
}

}  // namespace

vec3 octahedral_to_direction(const vec2& p) {
  const float u = 2 * p.x - 1, v = 2 * p.y - 1, up = std::abs(u), vp = std::abs(v);
  const float to_diagonal = 1 - (up + vp), r = 1 - std::abs(to_diagonal);
  const float phi = (r == 0 ? 1 : (vp - up) / r + 1) * (pi / 4);
  const float sine = r * safe_sqrt(2 - r * r);
  return {std::copysign(math::cos(phi), u) * sine, std::copysign(math::sin(phi), v) * sine,
          std::copysign(1 - r * r, to_diagonal)};
}

vec2 direction_to_octahedral(const vec3& d) {
  const float r = safe_sqrt(1 - std::abs(d.z));
  const float azimuth = math::atan2(std::abs(d.y), std::abs(d.x)) * (2 * inv_pi);  // [0, 1] over the quadrant
  vec2 p(r - azimuth * r, azimuth * r);
  if (d.z < 0) p = vec2(1 - p.y, 1 - p.x);
  return {0.5f + 0.5f * std::copysign(p.x, d.x), 0.5f + 0.5f * std::copysign(p.y, d.y)};
}

RgbImage octahedral_to_equirectangular(const RgbImage& square) {
  CHECK_EQ(square.size.x, square.size.y);
  const ivec2 size(2 * square.size.x, square.size.y);
  RgbImage result{size, std::vector<Rgb>(static_cast<std::size_t>(size.x) * size.y)};
  // Four points per texel, as a texel at the equator is about as large as one of the square. Each counts by its share of the
  // texel's solid angle, which near a pole is mostly that of the points farther from it.
  parallel_for(static_cast<std::size_t>(size.y), 1, [&](std::size_t y) {
    for (int x = 0; x < size.x; ++x) {
      Rgb sum(0);
      float sines = 0;
      for (int i = 0; i < 4; ++i) {
        const float phi =
            2 * pi * (static_cast<float>(x) + 0.25f + 0.5f * static_cast<float>(i % 2)) / static_cast<float>(size.x);
        const float theta =
            pi * (static_cast<float>(y) + 0.25f + 0.5f * static_cast<float>(i / 2)) / static_cast<float>(size.y);
        const float sine = math::sin(theta);
        sum +=
            sine * bilinear(square, direction_to_octahedral({sine * math::cos(phi), sine * math::sin(phi), math::cos(theta)}));
        sines += sine;
      }
      result.texels[y * static_cast<std::size_t>(size.x) + static_cast<std::size_t>(x)] = sum / sines;
    }
  });
  return result;
}

void interpolate_environment(ivec2& size, std::vector<Rgb>& texels, const Location& where, RowsOf rows) {
  constexpr double most_texels = unless_fuzzed(1 << 21, 1 << 10);
  const double affordable = std::sqrt(most_texels / (static_cast<double>(size.x) * size.y));
  const int times = static_cast<int>(std::clamp(affordable, 1.0, 8.0));
  if (times == 1) return;
  const ivec2 coarse = size, fine = times * coarse;
  const std::size_t count = texels.size() * static_cast<std::size_t>(times) * times;
  require_memory(static_cast<double>(count * sizeof(Rgb)), where, "an environment whose texels are interpolated",
                 "fewer of them");
  std::vector<Rgb> refined(count);
  parallel_for(static_cast<std::size_t>(fine.y), 8, [&](std::size_t row) {
    const auto split = [](float place) { return std::pair(static_cast<int>(std::floor(place)), place - std::floor(place)); };
    const auto between = [&](std::size_t at) {
      return split((static_cast<float>(at) + 0.5f) / static_cast<float>(times) - 0.5f);
    };
    const float from_pole = (static_cast<float>(row) + 0.5f) / static_cast<float>(fine.y);
    const auto [y, share_y] = rows == RowsOf::poles ? split(from_pole * static_cast<float>(coarse.y - 1)) : between(row);
    const std::size_t above = static_cast<std::size_t>(std::max(y, 0)) * coarse.x,
                      below = static_cast<std::size_t>(std::min(y + 1, coarse.y - 1)) * coarse.x;
    for (int i = 0; i < fine.x; ++i) {
      const auto [x, share_x] = between(static_cast<std::size_t>(i));
      const auto left = static_cast<std::size_t>((x + coarse.x) % coarse.x),  // a turn goes on at the other edge
          right = static_cast<std::size_t>((x + 1) % coarse.x);
      refined[row * static_cast<std::size_t>(fine.x) + static_cast<std::size_t>(i)] =
          glm::mix(glm::mix(texels[above + left], texels[above + right], share_x),
                   glm::mix(texels[below + left], texels[below + right], share_x), share_y);
    }
  });
  size = fine;
  texels = std::move(refined);
}

}  // namespace etendue
