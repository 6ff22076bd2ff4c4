#include "accel/points/placed_points.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace etendue {

Bounds finite_bounds(std::span<const vec3> points) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, points.size(), 1 << 14), Bounds(),
      [&](const auto& range, Bounds bounds) {
        for (std::size_t i = range.begin(); i != range.end(); ++i)
          if (is_finite(points[i])) bounds.extend(points[i]);
        return bounds;
      },
      [](Bounds a, const Bounds& b) {
        a.extend(b);
        return a;
      });
}

std::vector<PlacedPoint> finite_placed_points(std::span<const vec3> points) {
  std::vector<PlacedPoint> placed;
  placed.reserve(points.size());
  for (std::uint32_t id = 0; id < points.size(); ++id)
    if (is_finite(points[id])) placed.push_back({points[id], id});
  return placed;
}

}  // namespace etendue
