// kd-tree by the surface area heuristic: space is cut in two by axis-parallel planes, and each leaf lists what touches it
// ([Wald2006]; iterative traversal of [Havran2000]).
//
// Planes are chosen by the boxes of the parts of triangles that lie in a node ("perfect splits"): a triangle cut by a plane is
// clipped to either side, and listed only where some of it remains. Large nodes try the planes between bins ([Hunt2006]), small
// ones every face of a box; so a level costs O(n) and the tree O(n log n). A cut must be cheaper than a leaf; the cost of cuts
// that leave a side empty is multiplied by 0.8. The depth is bounded by 8 + 1.3 log2 n ([Havran2000]), the references by 32 per
// primitive.
//
// No hit is lost at a plane: boxes are enlarged by cell_slack, both sides of a plane are visited where the padded distances do
// not exclude it, and traversal ends only beyond the TraversalLimit (box_test.h), so ties go to the lowest id. A primitive of
// several leaves is tested once, thanks to mailboxes (reference_test.h). Memory: 8 bytes per node and 4 per reference; the
// geometry is not copied.
#pragma once

#include "accel/kernels/box_test.h"
#include "accel/kernels/reference_test.h"
#include "accel/kernels/traversal_stack.h"
#include "accel/scene/memory_budget.h"

namespace etendue {

struct KdTreeParams {
  float primitive_cost = 1;
  int max_depth = 0;
  int bins = 32;
  const MemoryWatch* watch = nullptr;  // checked at every cut
};

template <class Visitor>
void describe(Visitor& v, KdTreeParams& params) {
  v.number("primitive_cost", params.primitive_cost, 0.01, 100, "node visits", "cost of a primitive test, for choosing planes");
  v.integer("max_depth", params.max_depth, 0, 64, "edges", "depth at which a node becomes a leaf; 0: 8 + 1.3 log2 n");
  v.integer("bins", params.bins, 2, 1024, "bins", "planes tried per axis in large nodes, plus one");
}

class RayKdTree : public LeafQueries<RayKdTree, ReferenceTest> {
 public:
  // `geometry` must outlive the structure.
  RayKdTree(const Geometry& geometry, const KdTreeParams& params);

  template <class Count, class Leaf>
  void traverse(const Ray& ray, const float& t_best, Count& count, const Leaf& leaf) const;
  const Geometry& leaves() const { return *geometry_; }
  RayStructureStats stats() const;

 private:
  class Builder;

  // An inner node: the plane, its axis (0 to 2) and the first of its two children, which lie together. A leaf: axis 3, its
  // first reference and their number.
  class Node {
   public:
    static Node inner(int axis, float plane, std::uint32_t children) {
      return {std::bit_cast<std::uint32_t>(plane), children << 2 | static_cast<std::uint32_t>(axis)};
    }
    static Node leaf(std::uint32_t first, std::uint32_t count) { return {first, count << 2 | 3}; }

    int axis() const { return static_cast<int>(packed_ & 3); }
    bool is_leaf() const { return axis() == 3; }
    float plane() const { return std::bit_cast<float>(plane_or_first_); }
    std::uint32_t first() const { return plane_or_first_; }
    std::uint32_t children() const { return packed_ >> 2; }
    std::uint32_t count() const { return packed_ >> 2; }

    Node() = default;

   private:
    Node(std::uint32_t plane_or_first, std::uint32_t packed) : plane_or_first_(plane_or_first), packed_(packed) {}
    std::uint32_t plane_or_first_ = 0, packed_ = 3;
  };
  struct Waiting {
    std::uint32_t node;
    float entry, exit;
  };

  const Geometry* geometry_;
  Bounds bounds_;
  std::vector<Node> nodes_;  // 0 is the root; empty over no primitive
  std::vector<std::uint32_t> references_;
  std::uint32_t depth_ = 0;
  double sah_cost_ = 0;
};

// The near child is the one that the ray's direction comes from; the ray lies in it up to the (padded) distance of the plane,
// and in the far one from there on. That is the slab test of each child's box, a plane at a time, with the same rules: a NaN (a
// parallel ray within the plane) excludes neither.
template <class Count, class Leaf>
void RayKdTree::traverse(const Ray& ray, const float& t_best, Count& count, const Leaf& leaf) const {
  if (nodes_.empty()) return;
  const SlabRay slab(ray);
  const TraversalLimit limit_beyond(ray, largest_coordinate(bounds_));
  BoxInterval interval = box_interval(slab, bounds_, limit_beyond(t_best));
  if (interval.empty()) return;
  TraversalStack<Waiting> stack(depth_);
  Waiting* top = stack.begin();
  std::uint32_t place = 0;
  for (;;) {
    while (!nodes_[place].is_leaf()) {
      const Node& node = nodes_[place];
      count.node();
      const int axis = node.axis();
      const bool negative = slab.is_negative(axis);
      const float t = (node.plane() - component(slab.origin, axis)) * component(slab.reciprocal, axis), t_padded = t * slab_pad;
      const std::uint32_t near = node.children() + negative, far = node.children() + !negative;
      if (interval.entry > t_padded) {
        place = far;
      } else if (interval.exit < t) {
        place = near;
      } else {
        *top++ = {far, t > interval.entry ? t : interval.entry, interval.exit};
        interval.exit = t_padded < interval.exit ? t_padded : interval.exit;
        place = near;
      }
    }
    if (const Node& node = nodes_[place]; node.count() > 0)
      if (leaf(std::span(references_).subspan(node.first(), node.count()))) return;
    const float limit = limit_beyond(t_best);
    do {
      if (top == stack.begin()) return;
      --top;
    } while (top->entry > limit);
    place = top->node;
    interval = {top->entry, top->exit};
  }
}

struct RayEntry kd_tree_entry();  // its row of the registry

}  // namespace etendue
