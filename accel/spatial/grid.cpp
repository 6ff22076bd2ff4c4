#include "accel/spatial/grid.h"

#include "accel/kernels/clipped_polygon.h"
#include "accel/plain_entry.h"
#include "framework/core/elementary.h"

namespace etendue {

static_assert(RayStructure<Grid>);

namespace {

using Size = std::array<int, 3>;

std::uint64_t product(const Size& size) {
  return static_cast<std::uint64_t>(size[0]) * static_cast<std::uint64_t>(size[1]) * static_cast<std::uint64_t>(size[2]);
}

// About `cells` cubes in a box. Along an axis shorter than the cube's edge there is one cell, and the other axes share the
// cells among them.
Size cubes(const dvec3& extent, double cells) {
  bool open[3] = {true, true, true};
  for (;;) {
    double volume = 1;
    int axes = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (!open[axis]) continue;
      volume *= extent[axis];
      ++axes;
    }
    if (axes == 0) return {1, 1, 1};
    const double per_length = math::pow(cells / volume, 1.0 / axes);
    Size size{1, 1, 1};
    bool all_hold = true;
    for (int axis = 0; axis < 3; ++axis) {
      if (!open[axis]) continue;
      const double number = extent[axis] * per_length;
      if (!(number >= 1))
        all_hold = open[axis] = false;
      else
        size[axis] = static_cast<int>(number + 0.5);
    }
    if (all_hold) return size;
  }
}

}  // namespace

class Grid::Builder {
 public:
  Builder(const Geometry& geometry, Grid& grid, const MemoryWatch* watch)
      : geometry_(geometry), grid_(grid), watch_(watch), valid_(geometry.valid_primitives()) {}

  void build(const GridParams& params) {
    if (valid_.empty()) return;
    Bounds bounds;
    for (const std::uint32_t id : valid_) bounds.extend(geometry_.primitive_bounds(id));
    slack_ = cell_slack(bounds);
    grid_.bounds_ = grown(bounds, slack_);
    const dvec3 extent = dvec3(grid_.bounds_.upper) - dvec3(grid_.bounds_.lower);
    double cells = std::min<double>(static_cast<double>(params.density) * static_cast<double>(valid_.size()), params.max_cells);
    Size size = cubes(extent, cells);
    // Rounding up can exceed the cap, and large primitives can touch too many cells.
    while (product(size) > static_cast<std::uint64_t>(params.max_cells) || !count_references(size)) {
      cells *= 0.5;
      size = cubes(extent, cells);
    }
    fill();
    grid_.sah_cost_ = cost();
  }

 private:
  void set_planes(const Size& size) {
    for (int axis = 0; axis < 3; ++axis) {
      const double lower = grid_.bounds_.lower[axis], upper = grid_.bounds_.upper[axis];
      grid_.planes_[axis].resize(static_cast<std::size_t>(size[axis]) + 1);
      for (int i = 0; i <= size[axis]; ++i)
        grid_.planes_[axis][static_cast<std::size_t>(i)] = static_cast<float>(lower + (upper - lower) * i / size[axis]);
    }
  }

  // The references of each cell into starts_[cell + 1]; false where there are too many in all.
  bool count_references(const Size& size) {
    set_planes(size);
    check_memory(product(size), 0);
    grid_.starts_.assign(product(size) + 1, 0);
    const std::uint64_t budget =
        product(size) == 1 ? valid_.size() : std::min<std::uint64_t>(references_per_primitive * valid_.size() + 1024, no_id);
    std::uint64_t total = 0;
    for (const std::uint32_t id : valid_) {
      for_rows(id, [&](std::size_t row, int first, int last) {
        for (int x = first; x <= last; ++x) ++grid_.starts_[row + static_cast<std::size_t>(x) + 1];
        return (total += static_cast<std::uint64_t>(last - first + 1)) <= budget;
      });
      if (total > budget) return false;
    }
    return true;
  }

  // A cell's start and, while it is filled, its next place.
  void check_memory(std::uint64_t cells, std::uint64_t references) const {
    if (watch_ != nullptr) watch_->check(sizeof(std::uint32_t) * (valid_.size() + 2 * cells + references));
  }

  // Ids ascend within a cell.
  void fill() {
    for (std::size_t i = 1; i < grid_.starts_.size(); ++i) grid_.starts_[i] += grid_.starts_[i - 1];
    check_memory(grid_.starts_.size(), grid_.starts_.back());
    grid_.references_.resize(grid_.starts_.back());
    std::vector<std::uint32_t> next(grid_.starts_.begin(), grid_.starts_.end() - 1);
    for (const std::uint32_t id : valid_)
      for_rows(id, [&](std::size_t row, int first, int last) {
        for (int x = first; x <= last; ++x) grid_.references_[next[row + static_cast<std::size_t>(x)]++] = id;
        return true;
      });
  }

  struct Range {
    int first, last;
  };
  // The cells along the axis that an interval, enlarged by the slack, touches.
  Range cells(int axis, double low, double high) const {
    const std::vector<float>& planes = grid_.planes_[axis];
    const auto below = [&](double x) {  // planes at or below x
      return static_cast<int>(std::upper_bound(planes.begin(), planes.end(), x) - planes.begin());
    };
    const int last = grid_.size(axis) - 1;
    int first = std::clamp(below(low - slack_) - 1, 0, last);
    while (first > 0 && planes[static_cast<std::size_t>(first)] >= low - slack_) --first;
    return {first, std::clamp(below(high + slack_) - 1, first, last)};
  }

  // Calls row(index of its first cell, first x, last x) for the cells that the primitive touches, until that returns false. The
  // triangle is clipped to each slice, and that to each row: so the work is in proportion to the cells found.
  template <class Row>
  void for_rows(std::uint32_t id, const Row& row) const {
    const Bounds b = geometry_.primitive_bounds(id);
    Range range[3];
    for (int axis = 0; axis < 3; ++axis) range[axis] = cells(axis, b.lower[axis], b.upper[axis]);
    const bool clips = geometry_.is_triangle(id);
    const auto polygon = [&] {
      const uvec3 v = geometry_.triangles[id];
      const auto& p = geometry_.positions;
      return ClippedPolygon(p[v.x], p[v.y], p[v.z]);
    };
    for (int z = range[2].first; z <= range[2].last; ++z) {
      const auto row_of = [&](int y) {
        return (static_cast<std::size_t>(z) * static_cast<std::size_t>(grid_.size(1)) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(grid_.size(0));
      };
      if (!clips) {
        for (int y = range[1].first; y <= range[1].last; ++y)
          if (!row(row_of(y), range[0].first, range[0].last)) return;
        continue;
      }
      ClippedPolygon slice = polygon();
      if (range[2].first < range[2].last) clip(slice, 2, z);
      if (slice.empty()) continue;
      const dvec2 across = slice.extent(1);
      const Range rows = cells(1, across.x, across.y);
      for (int y = rows.first; y <= rows.last; ++y) {
        ClippedPolygon strip = slice;
        if (rows.first < rows.last) clip(strip, 1, y);
        if (strip.empty()) continue;
        const dvec2 along = strip.extent(0);
        const Range run = cells(0, along.x, along.y);
        if (!row(row_of(y), run.first, run.last)) return;
      }
    }
  }

  void clip(ClippedPolygon& polygon, int axis, int cell) const {
    const std::vector<float>& planes = grid_.planes_[axis];
    const auto i = static_cast<std::size_t>(cell);
    polygon.clip(axis, planes[i] - slack_, planes[i + 1] + slack_);
  }

  // Every cell is as likely to be met as another of its shape, whose area is about that of all divided by the cells' number to
  // the power of 2/3: exactly, the area of one cell.
  double cost() const {
    const auto half_area = [](const dvec3& d) { return d.x * d.y + d.y * d.z + d.z * d.x; };
    const dvec3 extent = dvec3(grid_.bounds_.upper) - dvec3(grid_.bounds_.lower);
    const dvec3 cell = extent / dvec3(grid_.size(0), grid_.size(1), grid_.size(2));
    const double cells = static_cast<double>(grid_.starts_.size() - 1);
    const double sum = half_area(cell) / half_area(extent) * (cells + static_cast<double>(grid_.references_.size()));
    return std::isfinite(sum) ? sum : 0;
  }

  const Geometry& geometry_;
  Grid& grid_;
  const MemoryWatch* const watch_;
  const std::vector<std::uint32_t> valid_;
  double slack_ = 0;
};

Grid::Grid(const Geometry& geometry, const GridParams& params) : geometry_(&geometry) {
  Builder(geometry, *this, params.watch).build(params);
}

RayStructureStats Grid::stats() const {
  std::uint64_t bytes = starts_.size() * sizeof(std::uint32_t) + references_.size() * sizeof(std::uint32_t);
  for (const std::vector<float>& planes : planes_) bytes += planes.size() * sizeof(float);
  return {bytes, starts_.empty() ? 0 : starts_.size() - 1, references_.empty() ? 0u : 1u, references_.size(), sah_cost_};
}

RayEntry grid_entry() {
  return cells_entry<Grid, GridParams>(
      "grid", "equal cells, walked one after another",
      [](const Geometry& geometry, const GridParams& params) { return grid_need(geometry, params.density, params.max_cells); });
}

}  // namespace etendue
