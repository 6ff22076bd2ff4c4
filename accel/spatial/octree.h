// Octree with references: space is cut into eight equal cubes as long as that pays, and each leaf lists the primitives that
// touch its cube ([Glassner1984]; traversal from the root down, front to back).
//
// A primitive that crosses a boundary is listed in several leaves: stats().references counts the duplicates; a ray tests it
// once, thanks to mailboxes (reference_test.h). Triangles are listed where they really overlap a cube ([AkenineMoeller2001]),
// quadrics where their box does, cubes being enlarged by cell_slack, so that a hit on a boundary is found from either side. A
// cube is cut when it holds more than leaf_size primitives and the surface area heuristic finds the cut cheaper than a leaf;
// the total of references is bounded by 32 per primitive. Memory: 8 bytes per node (leaves and empty cubes included) and 4 per
// reference; the geometry is not copied.
#pragma once

#include "accel/kernels/box_test.h"
#include "accel/kernels/reference_test.h"
#include "accel/kernels/traversal_stack.h"
#include "accel/scene/memory_budget.h"

namespace etendue {

struct OctreeParams {
  int leaf_size = 8;
  int max_depth = 16;
  float primitive_cost = 0.15f;
  const MemoryWatch* watch = nullptr;  // checked at every cut
};

template <class Visitor>
void describe(Visitor& v, OctreeParams& params) {
  v.integer("leaf_size", params.leaf_size, 1, 64, "primitives", "a cube with no more than this is not cut");
  v.integer("max_depth", params.max_depth, 1, 24, "edges", "depth at which a cube is not cut whatever it holds");
  v.number("primitive_cost", params.primitive_cost, 0.01, 100, "node visits",
           "cost of a primitive test, for choosing leaves (a visit tests eight cubes)");
}

class Octree : public LeafQueries<Octree, ReferenceTest> {
 public:
  // `geometry` must outlive the structure.
  Octree(const Geometry& geometry, const OctreeParams& params);

  template <class Count, class Leaf>
  void traverse(const Ray& ray, const float& t_best, Count& count, const Leaf& leaf) const;
  const Geometry& leaves() const { return *geometry_; }
  RayStructureStats stats() const { return {bytes(), nodes_.size(), depth_, references_.size(), sah_cost_}; }

 private:
  class Builder;

  // An inner node has count `inner` and its eight children from `first` on; child i lies high on axis a if bit a of i is set. A
  // leaf has `count` references from `first` on.
  static constexpr std::uint32_t inner = no_id;
  struct Node {
    std::uint32_t first = 0, count = 0;
  };
  struct Visit {
    std::uint32_t node;
    float entry;
    vec3 lower, upper;
  };

  std::uint64_t bytes() const { return nodes_.size() * sizeof(Node) + references_.size() * sizeof(std::uint32_t); }
  static Visit* visit_children(const SlabRay& slab, const Ray& ray, float limit, const Visit& parent, std::uint32_t first,
                               Visit* top);

  const Geometry* geometry_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> references_;
  Bounds cube_;
  std::uint32_t depth_ = 0;
  double sah_cost_ = 0;
};

// Pushes the children that the ray meets, the nearest last. All of them share nine planes. In the order of the child's number,
// with the bits of negative directions flipped, no child lies before one that the ray meets earlier.
inline Octree::Visit* Octree::visit_children(const SlabRay& slab, const Ray& ray, float limit, const Visit& parent,
                                             std::uint32_t first, Visit* top) {
  const vec3 middle = 0.5f * parent.lower + 0.5f * parent.upper;
  float near[3][2], far[3][2];  // by axis and half
  unsigned flip = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float planes[3] = {parent.lower[axis], middle[axis], parent.upper[axis]};
    const bool negative = slab.is_negative(axis);
    flip |= static_cast<unsigned>(negative) << axis;
    for (int half = 0; half < 2; ++half) {
      near[axis][half] = (planes[half + negative] - slab.origin[axis]) * slab.reciprocal[axis];
      far[axis][half] = (planes[half + !negative] - slab.origin[axis]) * slab.padded_reciprocal[axis];
    }
  }
  for (unsigned i = 8; i-- > 0;) {
    const unsigned child = i ^ flip;
    float entry = ray.t_min, exit = limit;
    for (int axis = 0; axis < 3; ++axis) {  // ordered so that a NaN restricts nothing, as in box_test.h
      const unsigned half = child >> axis & 1;
      entry = near[axis][half] > entry ? near[axis][half] : entry;
      exit = far[axis][half] < exit ? far[axis][half] : exit;
    }
    if (entry > exit) continue;
    Visit& visit = *top++;
    visit.node = first + child;
    visit.entry = entry;
    for (int axis = 0; axis < 3; ++axis) {
      const bool high = child >> axis & 1;
      visit.lower[axis] = high ? middle[axis] : parent.lower[axis];
      visit.upper[axis] = high ? parent.upper[axis] : middle[axis];
    }
  }
  return top;
}

template <class Count, class Leaf>
void Octree::traverse(const Ray& ray, const float& t_best, Count& count, const Leaf& leaf) const {
  const SlabRay slab(ray);
  const TraversalLimit limit_beyond(ray, largest_coordinate(cube_));
  const BoxInterval interval = box_interval(slab, cube_, limit_beyond(t_best));
  if (nodes_.empty() || interval.empty()) return;
  TraversalStack<Visit> stack(7 * depth_ + 8);
  Visit* top = stack.begin();
  *top++ = {0, interval.entry, cube_.lower, cube_.upper};
  while (top != stack.begin()) {
    const Visit visit = *--top;
    const float limit = limit_beyond(t_best);
    if (visit.entry > limit) continue;
    const Node& node = nodes_[visit.node];
    if (node.count == inner) {
      count.node();
      top = visit_children(slab, ray, limit, visit, node.first, top);
    } else if (node.count > 0 && leaf(std::span(references_).subspan(node.first, node.count))) {
      return;
    }
  }
}

struct RayEntry octree_entry();  // its row of the registry

}  // namespace etendue
