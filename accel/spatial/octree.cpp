#include "accel/spatial/octree.h"

#include "accel/kernels/clipped_polygon.h"
#include "accel/plain_entry.h"

#include <array>

namespace etendue {

static_assert(RayStructure<Octree>);

namespace {

// Which of eight cubes about a point does a triangle overlap? The axes of [AkenineMoeller2001] tell, in double precision; what
// they need of the triangle is computed once for all eight.
class CubeTests {
 public:
  // `half`: of a cube's edge, enlarged.
  CubeTests(const std::array<dvec3, 3>& triangle, double half) {
    const dvec3 edges[3] = {triangle[1] - triangle[0], triangle[2] - triangle[1], triangle[0] - triangle[2]};
    std::size_t i = 0;
    set(i++, glm::cross(edges[0], edges[1]), triangle, half);
    for (const dvec3& edge : edges) {
      set(i++, {0, -edge.z, edge.y}, triangle, half);
      set(i++, {edge.z, 0, -edge.x}, triangle, half);
      set(i++, {-edge.y, edge.x, 0}, triangle, half);
    }
  }

  bool overlaps(const dvec3& centre) const {
    for (const Axis& axis : axes_) {
      const double at = glm::dot(centre, axis.direction);
      if (at < axis.low || at > axis.high) return false;
    }
    return true;
  }

 private:
  struct Axis {
    dvec3 direction;
    double low, high;  // where a cube's centre may lie
  };

  void set(std::size_t i, const dvec3& direction, const std::array<dvec3, 3>& triangle, double half) {
    const double reach = half * (std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z));
    const double p0 = glm::dot(triangle[0], direction), p1 = glm::dot(triangle[1], direction),
                 p2 = glm::dot(triangle[2], direction);
    axes_[i] = {direction, std::min({p0, p1, p2}) - reach, std::max({p0, p1, p2}) + reach};
  }

  std::array<Axis, 10> axes_;
};

}  // namespace

// Builds breadth first, a level at a time, so that the budget of references is spent evenly without recursion.
class Octree::Builder {
 public:
  Builder(const Geometry& geometry, const OctreeParams& params, Octree& tree)
      : geometry_(geometry), params_(params), tree_(tree) {}

  void build() {
    Level level{{}, geometry_.valid_primitives()};
    if (level.references.empty()) return;
    Bounds bounds;
    for (const std::uint32_t id : level.references) bounds.extend(geometry_.primitive_bounds(id));
    slack_ = cell_slack(bounds);
    const vec3 half(0.5f * max_component(bounds.diagonal()));
    level.cells.push_back({0, grown({bounds.centre() - half, bounds.centre() + half}, slack_), 0,
                           static_cast<std::uint32_t>(level.references.size())});
    budget_ = std::min<std::uint64_t>(references_per_primitive * level.references.size() + 1024, no_id);
    references_ = level.references.size();
    tree_.cube_ = level.cells[0].bounds;
    tree_.nodes_.resize(1);
    for (int depth = 0; !level.cells.empty(); ++depth) {
      tree_.depth_ = static_cast<std::uint32_t>(depth);
      Level next;
      for (const Cell& cell : level.cells)
        if (depth == params_.max_depth || !cut(cell, level, next)) make_leaf(cell, level);
      level = std::move(next);
    }
    tree_.nodes_.shrink_to_fit();
    tree_.references_.shrink_to_fit();
  }

 private:
  struct Cell {
    std::uint32_t node;
    Bounds bounds;
    std::uint32_t first, count;  // references of the level
  };
  struct Level {
    std::vector<Cell> cells;
    std::vector<std::uint32_t> references;
  };

  double weight(const Cell& cell) const { return static_cast<double>(cell.bounds.half_area()) / tree_.cube_.half_area(); }

  void make_leaf(const Cell& cell, const Level& level) {
    tree_.sah_cost_ += weight(cell) * cell.count;
    tree_.nodes_[cell.node] = {static_cast<std::uint32_t>(tree_.references_.size()), cell.count};
    const auto first = level.references.begin() + cell.first;
    tree_.references_.insert(tree_.references_.end(), first, first + cell.count);
  }

  // All that is held: lists that grow by doubling.
  std::uint64_t bytes(const Level& level, const Level& next) const {
    return 2 * ((level.cells.size() + next.cells.size()) * sizeof(Cell) + tree_.nodes_.size() * sizeof(Node) +
                (level.references.size() + references_) * sizeof(std::uint32_t));
  }

  // Cuts the cell where that pays, its children joining the next level.
  bool cut(const Cell& cell, const Level& level, Level& next) {
    if (cell.count <= static_cast<std::uint32_t>(params_.leaf_size)) return false;
    const vec3 middle = 0.5f * cell.bounds.lower + 0.5f * cell.bounds.upper;  // as in the traversal
    std::array<std::uint32_t, 8> counts{};
    std::uint64_t total = 0;
    touched_.clear();
    for (std::uint32_t i = 0; i < cell.count; ++i) {
      touched_.push_back(touched(level.references[cell.first + i], cell.bounds, middle));
      for (unsigned child = 0; child < 8; ++child) counts[child] += touched_.back() >> child & 1;
      total += static_cast<std::uint64_t>(std::popcount(touched_.back()));
    }
    // The heuristic's costs, in node visits, of a ray that meets the cell: a child has a quarter of its parent's area.
    const double as_leaf = params_.primitive_cost * cell.count,
                 as_cut = 1 + params_.primitive_cost * static_cast<double>(total) / 4;
    if (as_cut >= as_leaf || references_ + total - cell.count > budget_) return false;
    references_ += total - cell.count;
    if (params_.watch != nullptr) params_.watch->check(bytes(level, next));
    tree_.sah_cost_ += weight(cell);
    const auto children = static_cast<std::uint32_t>(tree_.nodes_.size());
    tree_.nodes_[cell.node] = {children, inner};
    tree_.nodes_.resize(children + 8);
    for (unsigned child = 0; child < 8; ++child) {
      if (counts[child] == 0) continue;
      Cell part{children + child, cell.bounds, static_cast<std::uint32_t>(next.references.size()), counts[child]};
      for (int axis = 0; axis < 3; ++axis) (child >> axis & 1 ? part.bounds.lower : part.bounds.upper)[axis] = middle[axis];
      next.cells.push_back(part);
      for (std::uint32_t i = 0; i < cell.count; ++i)
        if (touched_[i] >> child & 1) next.references.push_back(level.references[cell.first + i]);
    }
    return true;
  }

  // The children (bits) that a primitive of the cell touches. Most lie within one by their box, and no more need be asked.
  std::uint8_t touched(std::uint32_t id, const Bounds& cell, const vec3& middle) const {
    static constexpr unsigned high_on[3] = {0xaa, 0xcc, 0xf0};  // children high on each axis
    const Bounds box = geometry_.primitive_bounds(id);
    unsigned children = 0xff;
    for (int axis = 0; axis < 3; ++axis) {
      if (box.upper[axis] < middle[axis] - slack_) children &= ~high_on[axis];
      if (box.lower[axis] > middle[axis] + slack_) children &= high_on[axis];
    }
    if ((children & (children - 1)) == 0 || !geometry_.is_triangle(id)) return static_cast<std::uint8_t>(children);
    const dvec3 centre(middle), quarter = 0.25 * (dvec3(cell.upper) - dvec3(cell.lower));
    const uvec3 v = geometry_.triangles[id];
    const auto& p = geometry_.positions;
    // The cube is the cell's child but for rounding, which the slack exceeds by far.
    const CubeTests tests({dvec3(p[v.x]) - centre, dvec3(p[v.y]) - centre, dvec3(p[v.z]) - centre},
                          std::max({quarter.x, quarter.y, quarter.z}) + slack_);
    for (unsigned left = children; left != 0; left &= left - 1) {
      const auto child = static_cast<unsigned>(std::countr_zero(left));
      const dvec3 towards(child & 1 ? 1 : -1, child & 2 ? 1 : -1, child & 4 ? 1 : -1);
      if (!tests.overlaps(towards * quarter)) children &= ~(1u << child);
    }
    return static_cast<std::uint8_t>(children);
  }

  const Geometry& geometry_;
  const OctreeParams params_;
  Octree& tree_;
  double slack_ = 0;
  std::uint64_t references_ = 0, budget_ = 0;  // in all leaves and cells so far
  std::vector<std::uint8_t> touched_;          // of the cell in hand
};

Octree::Octree(const Geometry& geometry, const OctreeParams& params) : geometry_(&geometry) {
  Builder(geometry, params, *this).build();
  if (!std::isfinite(sah_cost_)) sah_cost_ = 0;  // areas beyond the range of float
}

RayEntry octree_entry() {
  return cells_entry<Octree, OctreeParams>("octree", "cubes cut in eight, primitives listed in every leaf they touch",
                                           [](const Geometry& geometry, const OctreeParams&) { return octree_need(geometry); });
}

}  // namespace etendue
