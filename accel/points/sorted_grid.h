// Points sorted by the cell of a grid in two dimensions, and within a cell along the third: the longest axis of their bounds. A
// cell is thus a row through the bounds, whose points a query finds by two binary searches, which leave no more of the row than
// its radius covers. Rows lie in a table of offsets; nothing is hashed, so no row holds points from elsewhere.
//
// The width of the rows follows from the points' density (`points_per_cell` in a cube of that edge, if not empty), but there
// are at most twice as many rows as points. Queries may have any radius; one that covers all rows scans all points. Coordinates
// should stay below 1e18. The build is parallel: a counting sort into rows, then each row by itself.
#pragma once

#include "accel/points/neighbourhood.h"

namespace etendue {

class SortedGrid {
 public:
  void build(std::span<const vec3> points);
  void within(const vec3& p, float r, Neighbours& out) const { find(p, r, no_limit, out); }
  bool find(const vec3& p, float r, std::size_t most, Neighbours& out) const;  // neighbourhood.h
  void nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const;
  std::uint64_t bytes() const { return points_.size() * sizeof(PlacedPoint) + first_.size() * sizeof(std::uint32_t); }

 private:
  static constexpr float points_per_cell = 4;

  std::uint32_t row(float coordinate, int axis) const;

  Bounds bounds_;
  int along_ = 0, u_ = 1, v_ = 2;  // axes
  float width_ = 1, per_width_ = 1;
  float last_u_ = 0, last_v_ = 0;     // rows along either axis, less one
  std::vector<PlacedPoint> points_;   // row by row, in each by the coordinate along it, then by id
  std::vector<std::uint32_t> first_;  // of each row, and behind them the number of points
};

}  // namespace etendue
