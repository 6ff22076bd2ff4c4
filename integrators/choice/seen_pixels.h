// What warnings beside an image ask of the pixels: for how many of them something holds.
#pragma once

#include "framework/core/parallel.h"
#include "framework/integrator.h"

#include <fmt/format.h>

#include <numeric>
#include <string>
#include <vector>

namespace etendue {

inline constexpr double fewest_pixels = 0.01;  // that a warning is worth
inline constexpr int asked_lines = 32, asked_pixels = asked_lines * asked_lines;

// The share of a few pixels, evenly placed, of whose rays from the lens's middle, and numbers, this holds.
template <class Test>
double share_of_pixels(const RenderContext& context, const Test& holds_of) {
  std::vector<int> holds(asked_pixels);
  parallel_for(holds.size(), 16, [&](std::size_t i) {
    const ivec2 pixel = ivec2(i % asked_lines, i / asked_lines) * context.resolution / asked_lines;
    holds[i] = holds_of(context.scene.camera.ray(context.resolution, vec2(pixel) + 0.5f, vec2(0.5f)), i);
  });
  return std::accumulate(holds.begin(), holds.end(), 0.0) / static_cast<double>(holds.size());
}

inline std::string percent(double share) { return fmt::format("{:.{}f} %", 100 * share, share < 0.0995 ? 1 : 0); }

}  // namespace etendue
