#include "accel/points/sorted_grid.h"

#include "accel/points/cell_size.h"
#include "accel/points/placed_points.h"

namespace etendue {

static_assert(PointStructure<SortedGrid>);

namespace {

// The first of the run whose coordinate is not below `low`. Bisection without a branch, which could not be predicted.
const PlacedPoint* first_from(const PlacedPoint* begin, std::size_t count, int axis, float low) {
  while (count > 1) {
    const std::size_t half = count / 2;
    begin += begin[half - 1].position[axis] < low ? half : 0;
    count -= half;
  }
  return begin + (count == 1 && begin->position[axis] < low);
}

// The first behind those whose coordinates are not above `high`, which are expected to be few.
const PlacedPoint* first_above(const PlacedPoint* begin, const PlacedPoint* end, int axis, float high) {
  std::ptrdiff_t step = 8;
  for (; end - begin > step && begin[step].position[axis] <= high; step *= 2) begin += step;
  end = std::min(end, begin + step);
  while (begin != end && begin->position[axis] <= high) {
    const PlacedPoint* const middle = begin + (end - begin) / 2;
    if (middle->position[axis] <= high)
      begin = middle + 1;
    else
      end = middle;
  }
  return begin;
}

}  // namespace

void SortedGrid::build(std::span<const vec3> points) {
  points_.clear();
  first_.clear();
  bounds_ = finite_bounds(points);
  if (bounds_.empty()) return;
  const vec3 extent = bounds_.diagonal();
  along_ = bounds_.longest_axis();
  u_ = (along_ + 1) % 3;
  v_ = (along_ + 2) % 3;

  const double most_rows = 2.0 * static_cast<double>(points.size()) + 16;
  width_ = cell_size_for(points, bounds_, points_per_cell, std::max(max_component(extent) * 1e-6f, 1e-30f));
  const auto rows = [&](int axis) { return std::floor(static_cast<double>(extent[axis]) / width_) + 1; };
  while (rows(u_) * rows(v_) > most_rows) width_ *= 1.1f;
  per_width_ = 1 / width_;
  last_u_ = static_cast<float>(rows(u_) - 1);
  last_v_ = static_cast<float>(rows(v_) - 1);

  const auto rows_u = static_cast<std::uint32_t>(last_u_) + 1, rows_v = static_cast<std::uint32_t>(last_v_) + 1;
  CellRuns runs =
      sort_into_cells(points, rows_u * rows_v, [&](const vec3& p) { return row(p[u_], u_) * rows_v + row(p[v_], v_); });
  points_ = std::move(runs.points);
  first_ = std::move(runs.first);
  parallel_for(std::size_t{rows_u} * rows_v, 256, [&](std::size_t i) {
    std::sort(points_.begin() + first_[i], points_.begin() + first_[i + 1],
              [axis = along_](const PlacedPoint& a, const PlacedPoint& b) {
                return a.position[axis] < b.position[axis] || (a.position[axis] == b.position[axis] && a.id < b.id);
              });
  });
}

// Monotone along each axis, so that an interval of coordinates covers an interval of rows.
std::uint32_t SortedGrid::row(float coordinate, int axis) const {
  return static_cast<std::uint32_t>(
      std::clamp((coordinate - bounds_.lower[axis]) * per_width_, 0.0f, axis == u_ ? last_u_ : last_v_));
}

bool SortedGrid::find(const vec3& p, float r, std::size_t most, Neighbours& out) const {
  out.clear();
  if (points_.empty() || !can_find(p, r)) return true;
  const vec3 lower = glm::max(p - reach(r), bounds_.lower), upper = glm::min(p + reach(r), bounds_.upper);
  if (lower.x > upper.x || lower.y > upper.y || lower.z > upper.z) return true;
  const std::uint32_t u_end = row(upper[u_], u_), v_begin = row(lower[v_], v_), v_end = row(upper[v_], v_);
  const auto rows_v = static_cast<std::uint32_t>(last_v_) + 1;
  PointFinder finder(p, r * r, most, out);
  for (std::uint32_t u = row(lower[u_], u_); u <= u_end; ++u)
    for (std::uint32_t v = v_begin; v <= v_end; ++v) {
      const std::uint32_t* const first = first_.data() + std::size_t{u} * rows_v + v;
      const PlacedPoint* const end = points_.data() + first[1];
      const PlacedPoint* const begin = first_from(points_.data() + first[0], first[1] - first[0], along_, lower[along_]);
      if (!finder.look(begin, first_above(begin, end, along_, upper[along_]))) return false;
    }
  return true;
}

void SortedGrid::nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const {
  out.clear();
  if (points_.empty() || k == 0 || !can_find(p, r_max)) return;
  nearest_by_growing_balls(*this, points_.size(), bounds_, 0.25f * width_, p, k, r_max, out);
}

}  // namespace etendue
