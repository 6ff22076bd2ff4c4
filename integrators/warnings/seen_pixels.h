// Warnings beside an image ask of the pixels for how many of them something holds.
#pragma once

#include "framework/core/parallel.h"
#include "framework/integrator.h"

#include <numeric>
#include <vector>

namespace etendue {

inline constexpr double fewest_pixels = 0.01;  // that a warning is worth
inline constexpr int asked_lines = 32, asked_pixels = asked_lines * asked_lines;

// Calls visit(ray, number) for the rays of a few pixels, evenly placed, from the lens's middle.
template <class Visit>
void for_asked_pixels(const RenderContext& context, const Visit& visit) {
  parallel_for(asked_pixels, 16, [&](std::size_t i) {
    const ivec2 pixel = ivec2(i % asked_lines, i / asked_lines) * context.resolution / asked_lines;
    visit(context.scene.camera.ray(context.resolution, vec2(pixel) + 0.5f, vec2(0.5f)), i);
  });
}

// The share of these pixels of which this holds.
template <class Test>
double share_of_pixels(const RenderContext& context, const Test& holds_of) {
  std::vector<int> holds(asked_pixels);
  for_asked_pixels(context, [&](const Ray& ray, std::size_t i) { holds[i] = holds_of(ray, i); });
  return std::accumulate(holds.begin(), holds.end(), 0.0) / static_cast<double>(holds.size());
}

}  // namespace etendue
