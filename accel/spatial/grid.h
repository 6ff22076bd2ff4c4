// Uniform grid: the box of the geometry in equal cells, each listing what touches it, traversed cell by cell
// ([Amanatides1987]).
//
// Resolution: `density` cells per primitive, the cells as near to cubes as the box allows ([Cleary1988]). Triangles are listed
// in the cells that they really meet, found by clipping; quadrics in those that their box meets. The lists lie in one array,
// addressed by one index per cell ([Lagae2008]): 4 bytes per cell and 4 per reference, beside the geometry, which is not
// copied. Memory is bounded by max_cells and by 32 references per primitive: beyond either the grid is made coarser.
//
// No hit is lost: lists are enlarged by cell_slack; distances of planes are computed afresh at each step, from the planes, so
// rounding does not add up; where planes are met at distances too close to tell their order, all the cells around the edge or
// corner are visited, however many; traversal ends only beyond the TraversalLimit (box_test.h), so ties go to the lowest id. A
// primitive of several cells is tested once, thanks to mailboxes (reference_test.h).
//
// Limits: where detail is uneven ("teapot in a stadium") all of it falls into few cells.
#pragma once

#include "accel/kernels/box_test.h"
#include "accel/kernels/reference_test.h"
#include "accel/scene/memory_budget.h"

namespace etendue {

struct GridParams {
  float density = 5;
  int max_cells = 1 << 24;
  const MemoryWatch* watch = nullptr;  // checked before cells and references are allocated
};

template <class Visitor>
void describe(Visitor& v, GridParams& params) {
  v.number("density", params.density, 0.01, 1000, "cells per primitive", "resolution of the grid");
  v.integer("max_cells", params.max_cells, 1, 1 << 28, "cells", "the grid is coarser where the density asks for more");
}

class Grid : public LeafQueries<Grid, ReferenceTest> {
 public:
  // `geometry` must outlive the structure.
  Grid(const Geometry& geometry, const GridParams& params);

  template <class Count, class Leaf>
  void traverse(const Ray& ray, const float& t_best, Count& count, const Leaf& leaf) const;
  const Geometry& leaves() const { return *geometry_; }
  // Nodes are cells.
  RayStructureStats stats() const;

 private:
  class Builder;
  class Traversal;

  std::span<const std::uint32_t> listed(const std::array<int, 3>& cell) const {
    const std::size_t i = (static_cast<std::size_t>(cell[2]) * size(1) + cell[1]) * size(0) + cell[0];
    return std::span(references_).subspan(starts_[i], starts_[i + 1] - starts_[i]);
  }
  int size(int axis) const { return static_cast<int>(planes_[axis].size()) - 1; }

  const Geometry* geometry_;
  Bounds bounds_;
  std::array<std::vector<float>, 3> planes_;  // by axis, ascending: cell i lies between planes i and i + 1
  std::vector<std::uint32_t> starts_;         // by cell, x fastest: its first reference; one more at the end
  std::vector<std::uint32_t> references_;
  double sah_cost_ = 0;
};

// The traversal of a ray from cell to cell.
class Grid::Traversal {
 public:
  Traversal(const Grid& grid, const Ray& ray, const SlabRay& slab, float entry) : grid_(grid), slab_(slab), passed_(entry) {
    for (int axis = 0; axis < 3; ++axis) start(axis, ray);
  }

  const std::array<int, 3>& cell() const { return cell_; }
  // The distance at which the ray leaves the cell.
  float exit() const { return std::min({next_[0], next_[1], next_[2]}); }

  // Goes on to the cell behind exit(), having shown `visit` the cells beside the way, if any; false at the end of the grid or
  // where `visit` returns true.
  template <class Visit>
  bool advance(const Visit& visit) {
    const std::array<int, 3> from = cell_;
    if (cross() > 1 && visit_between(from, visit)) return false;
    return inside(cell_);
  }

 private:
  float distance(int axis, int plane) const {
    return (grid_.planes_[axis][plane] - component(slab_.origin, axis)) * component(slab_.reciprocal, axis);
  }

  // The cell that holds the point of entry, or one before it where rounding leaves that open. Along an axis with a direction of
  // zero (or so small that its reciprocal overflows) the ray stays where its origin is.
  void start(int axis, const Ray& ray) {
    const std::vector<float>& planes = grid_.planes_[axis];
    const int last = grid_.size(axis) - 1;
    const bool parallel = !std::isfinite(slab_.reciprocal[axis]);
    const float at = parallel ? ray.origin[axis] : ray.origin[axis] + passed_ * ray.direction[axis];
    int i = std::clamp(static_cast<int>(std::upper_bound(planes.begin(), planes.end(), at) - planes.begin()) - 1, 0, last);
    next_[axis] = infinity;
    step_[axis] = parallel ? 0 : slab_.is_negative(axis) ? -1 : 1;
    if (step_[axis] > 0) {
      while (i > 0 && distance(axis, i) * slab_pad >= passed_) --i;
      next_[axis] = distance(axis, i + 1);
    } else if (step_[axis] < 0) {
      while (i < last && distance(axis, i + 1) * slab_pad >= passed_) ++i;
      next_[axis] = distance(axis, i);
    }
    cell_[axis] = i;
  }

  // Crosses the next plane, and with it those whose order rounding leaves open: within the padding of slab tests of the nearest
  // or of each other. Says how many. Far from the grid, as compared with its size, that can be all.
  int cross() {
    passed_ = std::max(passed_, exit());
    int crossed = 0, before;
    do {
      before = crossed;
      for (int axis = 0; axis < 3; ++axis)
        while (next_[axis] <= passed_ * slab_pad && next_[axis] < infinity) {
          passed_ = std::max(passed_, next_[axis]);
          cell_[axis] += step_[axis];
          const bool left = cell_[axis] < 0 || cell_[axis] >= grid_.size(axis);
          next_[axis] = left ? infinity : distance(axis, cell_[axis] + (step_[axis] > 0));
          ++crossed;
        }
    } while (crossed != before);
    return crossed;
  }

  // Shows all cells of the box between two corners but the corners themselves.
  template <class Visit>
  bool visit_between(const std::array<int, 3>& from, const Visit& visit) const {
    std::array<int, 3> low, high, cell;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::max(std::min(from[axis], cell_[axis]), 0);
      high[axis] = std::min(std::max(from[axis], cell_[axis]), grid_.size(axis) - 1);
    }
    for (cell[2] = low[2]; cell[2] <= high[2]; ++cell[2])
      for (cell[1] = low[1]; cell[1] <= high[1]; ++cell[1])
        for (cell[0] = low[0]; cell[0] <= high[0]; ++cell[0])
          if (cell != from && cell != cell_ && visit(cell)) return true;
    return false;
  }

  bool inside(const std::array<int, 3>& cell) const {
    for (int axis = 0; axis < 3; ++axis)
      if (cell[axis] < 0 || cell[axis] >= grid_.size(axis)) return false;
    return true;
  }

  const Grid& grid_;
  const SlabRay& slab_;
  float passed_;  // no plane before this distance is still to come
  std::array<int, 3> cell_{}, step_{};
  float next_[3];  // distances of the planes at which the ray leaves the cell
};

template <class Count, class Leaf>
void Grid::traverse(const Ray& ray, const float& t_best, Count& count, const Leaf& leaf) const {
  if (references_.empty()) return;
  const SlabRay slab(ray);
  const TraversalLimit limit_beyond(ray, largest_coordinate(bounds_));
  const BoxInterval interval = box_interval(slab, bounds_, limit_beyond(t_best));
  if (interval.empty()) return;
  const auto visit = [&](const std::array<int, 3>& cell) {
    count.node();
    const std::span<const std::uint32_t> ids = listed(cell);
    return !ids.empty() && leaf(ids);
  };
  Traversal walk(*this, ray, slab, interval.entry);
  do {
    if (visit(walk.cell())) return;
    if (const float exit = walk.exit(); exit == infinity || exit > limit_beyond(t_best)) return;
  } while (walk.advance(visit));
}

struct RayEntry grid_entry();  // its row of the registry

}  // namespace etendue
