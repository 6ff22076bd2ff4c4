// Uniform grid over points, storing the occupied cells alone in a hash table ([Teschner2003]).
//
// The table keeps each cell's own key, so two cells never share a bucket: without that, points of colliding cells are found
// twice. A query may use any radius; the cell size is chosen at the build from the points' density (`points_per_cell` in a cell
// that holds any), and a query that covers more cells than are occupied scans all points. Queries outside the points' bounds
// reach in by their radius. Coordinates should stay below 1e18.
#pragma once

#include "accel/point/neighbourhood.h"

namespace etendue {

class HashGrid {
 public:
  void build(std::span<const vec3> points);
  void within(const vec3& p, float r, Neighbours& out) const;
  void nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const;
  std::uint64_t bytes() const { return points_.size() * sizeof(Point) + slots_.size() * sizeof(Slot); }

 private:
  using Key = std::uint64_t;
  struct Point {
    vec3 position;
    std::uint32_t id;
  };
  struct Slot {
    Key key = 0;
    std::uint32_t first = 0, count = 0;  // a run of points_; count 0: free
  };

  static constexpr int points_per_cell = 8;

  uvec3 cell(const vec3& p) const;
  static Key key(const uvec3& cell);
  std::size_t slot_of(Key key) const;
  void count_cells(std::span<const vec3> points, std::vector<Key>& keys);
  void grow_table();
  void collect(const Point* begin, const Point* end, const vec3& p, float r, Neighbours& out) const;

  Bounds bounds_;
  float cell_size_ = 1;
  std::vector<Point> points_;  // cell by cell, in each by id
  std::vector<Slot> slots_;    // open addressing, a power of two
  std::size_t cell_count_ = 0;
};

}  // namespace etendue
