#include "accel/points/hash_grid.h"

#include "accel/points/cell_size.h"
#include "accel/points/placed_points.h"

#include <bit>

namespace etendue {

static_assert(PointStructure<HashGrid>);

namespace {

constexpr std::size_t most_runs = 32;
constexpr float max_cell = (1 << 21) - 1;
constexpr std::size_t largest_table = std::size_t{1} << 31;

}  // namespace

// Monotone along each axis, so that a box of positions covers a box of cells.
vec3 HashGrid::cell(const vec3& p) const { return glm::clamp((p - bounds_.lower) * per_cell_size_, vec3(0), vec3(max_cell)); }

void HashGrid::build(std::span<const vec3> points) {
  points_.clear();
  first_.clear();
  bounds_ = finite_bounds(points);
  if (bounds_.empty()) return;
  const float smallest = std::max(max_component(bounds_.diagonal()) / (max_cell / 2), 1e-30f);
  cell_size_ = cell_size_for(points, bounds_, points_per_cell, smallest);
  per_cell_size_ = 1 / cell_size_;

  // Irrational shares of the table: rows that are neighbours lie far apart, and walls along axes spread evenly ([Roberts2018]).
  const auto size = static_cast<std::uint32_t>(std::min(largest_table, std::bit_ceil(points.size() + 16)));
  mask_ = size - 1;
  step_y_ = static_cast<std::uint32_t>(0.7548776662466927 * size) | 1;
  step_z_ = static_cast<std::uint32_t>(0.5698402909980532 * size) | 1;
  find_separation();
  CellRuns runs = sort_into_cells(points, size, [this](const vec3& p) {
    const uvec3 c(cell(p));
    return (c.x + row_of(c.y, c.z)) & mask_;
  });
  points_ = std::move(runs.points);
  first_ = std::move(runs.first);
}

void HashGrid::find_separation() {
  std::uint32_t least = mask_ + 1;
  for (int n = 0; n < static_cast<int>(most_rows); ++n) {
    for (int dy = 0; dy <= n; ++dy)
      for (int dz = -n; dz <= n; ++dz) {
        if (std::max(dy, std::abs(dz)) != n || (dy == 0 && dz <= 0)) continue;
        const std::uint32_t apart = row_of(static_cast<std::uint32_t>(dy), static_cast<std::uint32_t>(dz)) & mask_;
        least = std::min({least, apart, mask_ + 1 - apart});
      }
    separation_[n] = least;
  }
}

bool HashGrid::look_at(const Run& run, PointFinder& finder) const {
  return finder.look(points_.data() + first_[run.first], points_.data() + first_[run.last + 1]);
}

bool HashGrid::find(const vec3& p, float r, std::size_t most, Neighbours& out) const {
  out.clear();
  if (points_.empty() || !can_find(p, r)) return true;
  const vec3 lower = glm::max(p - reach(r), bounds_.lower), upper = glm::min(p + reach(r), bounds_.upper);
  if (lower.x > upper.x || lower.y > upper.y || lower.z > upper.z) return true;
  const vec3 lower_cell = cell(lower), upper_cell = cell(upper);
  const uvec3 begin(lower_cell), end(upper_cell);
  const uvec3 extent = end - begin;
  PointFinder finder(p, r * r, most, out);
  if (static_cast<std::uint64_t>(extent.x + 1) * (extent.y + 1) * (extent.z + 1) > mask_)
    return finder.look(points_.data(), points_.data() + points_.size());
  const std::uint32_t apart = std::max(extent.y, extent.z);
  if (apart >= most_rows || extent.x >= separation_[apart]) return look_at_joined(begin, end, finder);
  // Rows at the corners that the ball does not reach are left out, by distances in cells, less what rounding may err.
  const vec3 at = (p - bounds_.lower) * per_cell_size_;
  const float slack = 1e-6f * (max_component(glm::abs(at)) + max_component(upper_cell) + 1);
  const float limit_in_cells = square(reach(r) * per_cell_size_ * (1 + 1e-6f));
  const auto beyond = [slack](float a, std::uint32_t i) {
    const auto low = static_cast<float>(i);
    return square(std::max(0.0f, std::max(low - a, a - (low + 1)) - slack));
  };
  // Runs are looked up before any is read, so that the waits for the table overlap.
  std::array<std::pair<const PlacedPoint*, const PlacedPoint*>, most_runs> runs;
  std::size_t count = 0;
  const auto look_at_runs = [&] {
    for (std::size_t i = 0; i < count; ++i)
      if (!finder.look(runs[i].first, runs[i].second)) return false;
    count = 0;
    return true;
  };
  const auto look_up = [&](std::uint32_t first, std::uint32_t last) {
    runs[count++] = {points_.data() + first_[first], points_.data() + first_[last + 1]};
  };
  for (std::uint32_t y = begin.y; y <= end.y; ++y) {
    const float left = limit_in_cells - beyond(at.y, y);
    for (std::uint32_t z = begin.z; z <= end.z; ++z) {
      if (beyond(at.z, z) > left) continue;
      const std::uint32_t row = row_of(y, z), first = (row + begin.x) & mask_, last = (row + end.x) & mask_;
      if (count + 2 > most_runs && !look_at_runs()) return false;
      if (first <= last) {
        look_up(first, last);
      } else {  // around the table's end
        look_up(first, mask_);
        look_up(0, last);
      }
    }
  }
  return look_at_runs();
}

bool HashGrid::look_at_joined(const uvec3& begin, const uvec3& end, PointFinder& finder) const {
  thread_local std::vector<Run> runs;
  runs.clear();
  for (std::uint32_t y = begin.y; y <= end.y; ++y)
    for (std::uint32_t z = begin.z; z <= end.z; ++z) {
      const std::uint32_t row = row_of(y, z), first = (row + begin.x) & mask_, last = (row + end.x) & mask_;
      if (first <= last) {
        runs.push_back({first, last});
      } else {
        runs.push_back({first, mask_});
        runs.push_back({0, last});
      }
    }
  std::sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) { return a.first < b.first; });
  Run joined = runs.front();
  for (const Run& run : runs) {
    if (run.first <= joined.last + 1) {
      joined.last = std::max(joined.last, run.last);
    } else {
      if (!look_at(joined, finder)) return false;
      joined = run;
    }
  }
  return look_at(joined, finder);
}

void HashGrid::nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const {
  out.clear();
  if (points_.empty() || k == 0 || !can_find(p, r_max)) return;
  // On a surface whose cells hold as many points as the usual one, the first ball holds k and half as many again.
  const float usual = std::sqrt(1.5f * static_cast<float>(k) * inv_pi / points_per_cell);
  nearest_by_growing_balls(*this, points_.size(), bounds_, usual * cell_size_, p, k, r_max, out);
}

}  // namespace etendue
