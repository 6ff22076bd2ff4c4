// The part of a triangle between axis-parallel planes ([Sutherland1974]), in double precision: its rounding is far below the
// slack with which cells list what touches them (cell_slack).
#pragma once

#include "framework/core/vec.h"

#include <array>
#include <utility>

namespace etendue {

// A structure that subdivides space enlarges its cells by this much when it lists what touches them. A ray and the triangle
// that the watertight test says it hits can lie apart by some epsilon of the coordinates involved; 16 of the largest (an extent
// is at most twice as large) keep the hit in a cell that the ray visits. Origins far outside are covered by the padding of
// distances (TraversalLimit).
inline double cell_slack(const Bounds& b) {
  double largest = 0;
  for (int axis = 0; axis < 3; ++axis) largest = std::max<double>({largest, std::abs(b.lower[axis]), std::abs(b.upper[axis])});
  return 16.0 * std::numeric_limits<float>::epsilon() * largest + std::numeric_limits<float>::denorm_min();
}

// The box enlarged by `slack` on all sides, within the range of float.
inline Bounds grown(const Bounds& b, double slack) {
  constexpr double most = std::numeric_limits<float>::max();
  Bounds g;
  for (int axis = 0; axis < 3; ++axis) {
    g.lower[axis] = static_cast<float>(std::max(b.lower[axis] - slack, -most));
    g.upper[axis] = static_cast<float>(std::min(b.upper[axis] + slack, most));
  }
  return g;
}

class ClippedPolygon {
 public:
  ClippedPolygon(const vec3& a, const vec3& b, const vec3& c) : vertices_{dvec3(a), dvec3(b), dvec3(c)}, count_(3) {}

  bool empty() const { return count_ == 0; }
  // Cuts off what lies below `low` or above `high` on the axis.
  void clip(int axis, double low, double high) {
    keep(axis, low, 1);
    keep(axis, high, -1);
  }
  double area() const {
    dvec3 sum(0);
    for (std::size_t i = 2; i < count_; ++i) sum += glm::cross(vertices_[i - 1] - vertices_[0], vertices_[i] - vertices_[0]);
    return 0.5 * glm::length(sum);
  }
  // The extent along the axis. The polygon must not be empty.
  dvec2 extent(int axis) const {
    dvec2 extent(vertices_[0][axis]);
    for (std::size_t i = 1; i < count_; ++i)
      extent = {std::min(extent.x, vertices_[i][axis]), std::max(extent.y, vertices_[i][axis])};
    return extent;
  }

 private:
  // A convex polygon gains one vertex at most per plane; rounding can bend it, so there is room to spare.
  static constexpr std::size_t most_vertices = 24;

  // Keeps the part with sign * (coordinate - plane) >= 0.
  void keep(int axis, double plane, double sign) {
    const auto old = vertices_;
    const std::size_t old_count = std::exchange(count_, 0);
    for (std::size_t i = 0; i < old_count; ++i) {
      const dvec3 &from = old[i], &to = old[i + 1 < old_count ? i + 1 : 0];
      const double a = sign * (from[axis] - plane), b = sign * (to[axis] - plane);
      if (a >= 0) add(from);
      if ((a < 0) == (b < 0)) continue;
      dvec3 crossing = from + (to - from) * (a / (a - b));
      crossing[axis] = plane;
      add(crossing);
    }
  }
  void add(const dvec3& vertex) {
    if (count_ < most_vertices) vertices_[count_++] = vertex;
  }

  std::array<dvec3, most_vertices> vertices_;
  std::size_t count_;
};

}  // namespace etendue
