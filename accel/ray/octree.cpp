#include "accel/ray/octree.h"

#include <array>

namespace etendue {

static_assert(RayStructure<Octree>);

namespace {

constexpr std::uint64_t references_per_primitive = 32;

// Do a triangle and a box overlap? By the 13 axes of [AkenineMoeller2001], in double precision.
bool overlaps(const std::array<dvec3, 3>& triangle, const dvec3& centre, const dvec3& half) {
  const dvec3 v[3] = {triangle[0] - centre, triangle[1] - centre, triangle[2] - centre};
  const auto separates = [&](const dvec3& axis) {
    const double reach = glm::dot(half, glm::abs(axis));
    const double p0 = glm::dot(v[0], axis), p1 = glm::dot(v[1], axis), p2 = glm::dot(v[2], axis);
    return std::min({p0, p1, p2}) > reach || std::max({p0, p1, p2}) < -reach;
  };
  const dvec3 edges[3] = {v[1] - v[0], v[2] - v[1], v[0] - v[2]};
  if (separates(glm::cross(edges[0], edges[1]))) return false;
  for (int axis = 0; axis < 3; ++axis) {
    dvec3 unit(0);
    unit[axis] = 1;
    if (separates(unit)) return false;
    for (const dvec3& edge : edges)
      if (separates(glm::cross(unit, edge))) return false;
  }
  return true;
}

}  // namespace

// Breadth first, a level at a time: so the budget of references is spent evenly and no recursion is needed.
class Octree::Builder {
 public:
  Builder(const Geometry& geometry, const OctreeParams& params, Octree& tree)
      : geometry_(geometry), params_(params), tree_(tree) {}

  void build() {
    Cell root{0, {}, {}};
    Bounds bounds;
    for (const std::uint32_t id : geometry_.valid_primitives()) {
      root.primitives.push_back(id);
      bounds.extend(geometry_.primitive_bounds(id));
    }
    if (root.primitives.empty()) return;
    references_ = root.primitives.size();
    budget_ = references_per_primitive * references_ + 1024;
    const vec3 half(0.5f * max_component(bounds.diagonal()));
    root.bounds = {bounds.centre() - half - slack(bounds), bounds.centre() + half + slack(bounds)};
    tree_.cube_ = root.bounds;
    tree_.nodes_.resize(1);
    std::vector<Cell> level{std::move(root)}, next;
    for (int depth = 0; !level.empty(); ++depth) {
      tree_.depth_ = static_cast<std::uint32_t>(depth);
      for (Cell& cell : level) add(cell, depth < params_.max_depth, next);
      level = std::exchange(next, {});
    }
  }

 private:
  struct Cell {
    std::uint32_t node;
    Bounds bounds;
    std::vector<std::uint32_t> primitives;
  };

  // Above what rounding can do to a plane's distance, so that a hit on a boundary is found from either side.
  static float slack(const Bounds& b) {
    const float largest = std::max(max_component(glm::abs(b.lower)), max_component(glm::abs(b.upper)));
    return 1e-5f * max_component(b.diagonal()) + 8 * std::numeric_limits<float>::epsilon() * largest;
  }

  // Makes the cell a leaf, or cuts it and hands its children to the next level.
  void add(Cell& cell, bool may_cut, std::vector<Cell>& next) {
    const double weight = static_cast<double>(cell.bounds.half_area()) / tree_.cube_.half_area();
    const auto count = cell.primitives.size();
    if (may_cut && count > static_cast<std::size_t>(params_.leaf_size)) {
      std::array<Cell, 8> children;
      std::uint64_t total = 0;
      for (unsigned i = 0; i < 8; ++i) {
        children[i] = child(cell, i);
        total += children[i].primitives.size();
      }
      // A child has a quarter of its parent's area, so the heuristic's cost of the cut is 1 + total / 4, and `count` of a leaf.
      if (total < 4 * (count - 1) && references_ + total - count <= budget_) {
        references_ += total - count;
        tree_.sah_cost_ += weight;
        const auto first = static_cast<std::uint32_t>(tree_.nodes_.size());
        tree_.nodes_[cell.node] = {first, inner};
        tree_.nodes_.resize(first + 8);
        for (unsigned i = 0; i < 8; ++i) {
          children[i].node = first + i;
          if (!children[i].primitives.empty()) next.push_back(std::move(children[i]));
        }
        return;
      }
    }
    tree_.sah_cost_ += weight * static_cast<double>(count);
    const LeafBlocks::Run run = tree_.leaves_.add(cell.primitives);
    tree_.nodes_[cell.node] = {run.first, run.count};
  }

  Cell child(const Cell& cell, unsigned i) const {
    const vec3 middle = 0.5f * cell.bounds.lower + 0.5f * cell.bounds.upper;  // as in the traversal
    Cell child{0, cell.bounds, {}};
    for (int axis = 0; axis < 3; ++axis) (i >> axis & 1 ? child.bounds.lower : child.bounds.upper)[axis] = middle[axis];
    const dvec3 centre = 0.5 * (dvec3(child.bounds.lower) + dvec3(child.bounds.upper));
    const dvec3 half = 0.5 * (dvec3(child.bounds.upper) - dvec3(child.bounds.lower)) + static_cast<double>(slack(child.bounds));
    for (const std::uint32_t id : cell.primitives)
      if (touches(id, centre, half)) child.primitives.push_back(id);
    return child;
  }

  bool touches(std::uint32_t id, const dvec3& centre, const dvec3& half) const {
    if (geometry_.is_triangle(id)) {
      const uvec3 v = geometry_.triangles[id];
      return overlaps({dvec3(geometry_.positions[v.x]), dvec3(geometry_.positions[v.y]), dvec3(geometry_.positions[v.z])},
                      centre, half);
    }
    const Bounds b = geometry_.primitive_bounds(id);
    const dvec3 lower = dvec3(b.lower) - centre, upper = dvec3(b.upper) - centre;
    return lower.x <= half.x && lower.y <= half.y && lower.z <= half.z && upper.x >= -half.x && upper.y >= -half.y &&
           upper.z >= -half.z;
  }

  const Geometry& geometry_;
  const OctreeParams params_;
  Octree& tree_;
  std::uint64_t references_ = 0, budget_ = 0;  // in all leaves and cells so far
};

Octree::Octree(const Geometry& geometry, const OctreeParams& params) : leaves_(geometry) {
  Builder(geometry, params, *this).build();
  if (!std::isfinite(sah_cost_)) sah_cost_ = 0;  // areas beyond the range of float
}

}  // namespace etendue
