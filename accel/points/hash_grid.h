// Uniform grid over points whose cells are kept in a table of fixed size by a hash of their coordinates ([Teschner2003]).
//
// The hash is linear, (x + a y + b z) modulo the table's size, so that the cells of a row along x lie side by side: a query
// reads one run of points for each row it touches. Cells that share an entry cost a query points from elsewhere, which fail the
// test of distance. Two rows of one query must not overlap in the table, or their points would be found twice. Whether they do
// depends only on their difference: the build computes how long rows may be for a given number of rows, and queries beyond that
// first merge their runs.
//
// A query may use any radius; the cell size is chosen at the build from the points' density (`points_per_cell` in a cell that
// holds any), and a query that covers the table scans all points. Queries outside the points' bounds reach in by their radius.
// Coordinates should stay below 1e18. The build is parallel.
#pragma once

#include "accel/points/neighbourhood.h"

namespace etendue {

class HashGrid {
 public:
  void build(std::span<const vec3> points);
  void within(const vec3& p, float r, Neighbours& out) const { find(p, r, no_limit, out); }
  bool find(const vec3& p, float r, std::size_t most, Neighbours& out) const;  // neighbourhood.h
  void nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const;
  std::uint64_t bytes() const { return points_.size() * sizeof(PlacedPoint) + first_.size() * sizeof(std::uint32_t); }

 private:
  static constexpr float points_per_cell = 16;
  static constexpr std::uint32_t most_rows = 32;  // along y or z, for which separation_ is known

  struct Run {
    std::uint32_t first, last;  // entries of the table
  };

  vec3 cell(const vec3& p) const;
  std::uint32_t row_of(std::uint32_t y, std::uint32_t z) const { return y * step_y_ + z * step_z_; }
  void find_separation();
  bool look_at(const Run& run, PointFinder& finder) const;
  bool look_at_joined(const uvec3& begin, const uvec3& end, PointFinder& finder) const;

  Bounds bounds_;
  float cell_size_ = 1, per_cell_size_ = 1;
  std::uint32_t mask_ = 0, step_y_ = 0, step_z_ = 0;
  std::uint32_t separation_[most_rows] = {};  // entry n: cells between the starts of rows up to n apart, at least
  std::vector<PlacedPoint> points_;           // entry by entry, in each by id
  std::vector<std::uint32_t> first_;          // of each entry of the table, and behind them the number of points
};

}  // namespace etendue
