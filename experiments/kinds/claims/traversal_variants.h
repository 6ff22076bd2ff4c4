// Traversals of one binary tree that the teaching notes compare: which child first, with or without pruning, by recursion or
// with a stack, over nodes in one array or nodes allocated one by one, and by four slab tests. The product's own is
// layout_binary.h; leaves are tested as there, so that only the way to them differs. All find the same hits.
#pragma once

#include "accel/bvh/build/binary_tree.h"
#include "accel/kernels/box_test.h"
#include "accel/kernels/leaf.h"
#include "accel/kernels/traversal_stack.h"

#include <memory>

#if defined(__SSE4_1__)
#include <smmintrin.h>
#endif

namespace etendue {

// --- slab tests: entry distance, or infinity ---

// The framework's test goes axis by axis without a branch.
class ScalarSlab {
 public:
  explicit ScalarSlab(const Ray& ray) : ray_(ray) {}
  float entry(const Bounds& box, float limit) const {
    const BoxInterval interval = box_interval(ray_, box, limit);
    return interval.empty() ? infinity : interval.entry;
  }

 private:
  SlabRay ray_;
};

// The textbooks' loop over the axes swaps near and far and returns at the first axis that misses. It multiplies by the
// reciprocal of the direction, or divides by the direction twice an axis.
template <bool divides>
class AxisLoopSlab {
 public:
  explicit AxisLoopSlab(const Ray& ray)
      : origin_(ray.origin), scale_(divides ? ray.direction : 1.0f / ray.direction), t_min_(ray.t_min) {}
  float entry(const Bounds& box, float limit) const {
    float near = t_min_, far = limit;
    for (int axis = 0; axis < 3; ++axis) {
      float t0 = distance(box.lower[axis], axis), t1 = distance(box.upper[axis], axis);
      if (divides ? std::signbit(scale_[axis]) : scale_[axis] < 0) std::swap(t0, t1);
      t1 *= slab_pad;
      if (t0 > near) near = t0;
      if (t1 < far) far = t1;
      if (near > far) return infinity;
    }
    return near;
  }

 private:
  float distance(float plane, int axis) const {
    return divides ? (plane - origin_[axis]) / scale_[axis] : (plane - origin_[axis]) * scale_[axis];
  }

  vec3 origin_, scale_;
  float t_min_;
};
using LoopSlab = AxisLoopSlab<false>;
using DividingSlab = AxisLoopSlab<true>;

#if defined(__SSE4_1__)

// One box in the lanes of two registers; the fourth lane holds what `near` and `far` start from.
class SimdSlab {
 public:
  explicit SimdSlab(const Ray& ray)
      : origin_(_mm_setr_ps(ray.origin.x, ray.origin.y, ray.origin.z, 0)),
        near_factor_(_mm_setr_ps(1 / ray.direction.x, 1 / ray.direction.y, 1 / ray.direction.z, 0)),
        far_factor_(_mm_mul_ps(near_factor_, _mm_set1_ps(slab_pad))),
        negative_(_mm_setr_ps(ray.direction.x, ray.direction.y, ray.direction.z, 0)),
        t_min_(_mm_set1_ps(ray.t_min)) {}
  float entry(const Bounds& box, float limit) const {
    // Lanes 0-2 of both; the overlapping loads keep within the box.
    const __m128 lower = _mm_loadu_ps(&box.lower.x), shifted = _mm_loadu_ps(&box.lower.x + 2);
    const __m128 upper = _mm_shuffle_ps(shifted, shifted, _MM_SHUFFLE(0, 3, 2, 1));
    const __m128 near_planes = _mm_blendv_ps(lower, upper, negative_), far_planes = _mm_blendv_ps(upper, lower, negative_);
    // maxps and minps answer their second operand when one is NaN: a NaN restricts nothing.
    __m128 near = _mm_max_ps(_mm_mul_ps(_mm_sub_ps(near_planes, origin_), near_factor_), t_min_);
    __m128 far = _mm_min_ps(_mm_mul_ps(_mm_sub_ps(far_planes, origin_), far_factor_), _mm_set1_ps(limit));
    near = _mm_blend_ps(near, t_min_, 8);
    far = _mm_blend_ps(far, _mm_set1_ps(limit), 8);
    near = _mm_max_ps(near, _mm_movehl_ps(near, near));
    near = _mm_max_ss(near, _mm_shuffle_ps(near, near, 1));
    far = _mm_min_ps(far, _mm_movehl_ps(far, far));
    far = _mm_min_ss(far, _mm_shuffle_ps(far, far, 1));
    return _mm_comile_ss(near, far) ? _mm_cvtss_f32(near) : infinity;
  }

 private:
  __m128 origin_, near_factor_, far_factor_, negative_, t_min_;
};

#else

using SimdSlab = ScalarSlab;

#endif

// --- nodes ---

// Nodes of 32 bytes lie in one array, children beside each other, and are named by index.
class PackedNodes {
 public:
  using Ref = std::uint32_t;

  explicit PackedNodes(const BinaryTree& tree) : nodes_(tree.nodes) {}
  Ref root() const { return 0; }
  const Bounds& bounds(Ref ref) const { return nodes_[ref].bounds; }
  bool is_leaf(Ref ref) const { return nodes_[ref].count > 0; }
  std::uint32_t first(Ref ref) const { return nodes_[ref].first; }
  std::uint32_t count(Ref ref) const { return nodes_[ref].count; }
  Ref left(Ref ref) const { return nodes_[ref].first; }
  Ref right(Ref ref) const { return nodes_[ref].first + 1; }
  // The memory that a test of the node's box touches, and that reading its links touches.
  template <class Touch>
  void touch_box(Ref ref, const Touch& touch) const {
    touch(&nodes_[ref].bounds, sizeof(Bounds));
  }
  template <class Touch>
  void touch_links(Ref ref, const Touch& touch) const {
    touch(&nodes_[ref].first, 2 * sizeof(std::uint32_t));
  }

 private:
  std::vector<TreeNode> nodes_;
};

// Nodes as in a class diagram are allocated one by one while the tree is built, depth first, with fields that traversal never
// reads in front and pointers to parent and children; a leaf owns a list of its primitives.
class LinkedNodes {
 public:
  struct Node {
    std::vector<std::uint32_t> primitives;
    Node* parent = nullptr;
    std::uint64_t id = 0;
    int depth = 0, axis = 0;
    float area = 0, cost = 0;
    std::unique_ptr<Node> left, right;
    std::uint32_t first = 0, count = 0;
    Bounds bounds;
  };
  using Ref = const Node*;

  explicit LinkedNodes(const BinaryTree& tree) : root_(make(tree, 0, nullptr, 0)) {}
  Ref root() const { return root_.get(); }
  const Bounds& bounds(Ref ref) const { return ref->bounds; }
  bool is_leaf(Ref ref) const { return ref->left == nullptr; }
  std::uint32_t first(Ref ref) const { return ref->first; }
  std::uint32_t count(Ref ref) const { return ref->count; }
  Ref left(Ref ref) const { return ref->left.get(); }
  Ref right(Ref ref) const { return ref->right.get(); }
  template <class Touch>
  void touch_box(Ref ref, const Touch& touch) const {
    touch(&ref->bounds, sizeof(Bounds));
  }
  template <class Touch>
  void touch_links(Ref ref, const Touch& touch) const {
    touch(&ref->left, 2 * sizeof(ref->left) + 2 * sizeof(std::uint32_t));
  }

 private:
  static std::unique_ptr<Node> make(const BinaryTree& tree, std::uint32_t index, Node* parent, int depth) {
    const TreeNode& from = tree.nodes[index];
    auto node = std::make_unique<Node>();
    node->parent = parent;
    node->id = index;
    node->depth = depth;
    node->axis = from.bounds.longest_axis();
    node->area = from.bounds.half_area();
    node->bounds = from.bounds;
    if (from.is_leaf()) {
      node->first = from.first;
      node->count = from.count;
      for (std::uint32_t i = 0; i < from.count; ++i) node->primitives.push_back(from.first + i);
    } else {
      node->left = make(tree, from.first, node.get(), depth + 1);
      node->right = make(tree, from.first + 1, node.get(), depth + 1);
    }
    return node;
  }

  std::unique_ptr<Node> root_;
};

// --- traversals ---

enum class TraversalForm : std::uint8_t { iterative, recursive };

struct TraversalOptions {
  TraversalForm form = TraversalForm::iterative;
  bool ordered = true;  // the nearer child first
  bool pruned = true;   // boxes behind the closest hit so far are left
};

// Observes a traversal; `touch(address, bytes)` is asked for only where a cache is modelled.
struct ObserveNothing {
  static constexpr bool touches = false;
  void node() {}
};
struct ObserveNodes {
  static constexpr bool touches = false;
  std::uint64_t& nodes;
  void node() { ++nodes; }
};

template <TraversalOptions options, class Slab, class Nodes, class Observe, class Leaf>
class Traversal {
 public:
  using Ref = typename Nodes::Ref;

  // The arguments are those of BinaryLayout::traverse; `t_best` falls as leaves find hits.
  Traversal(const Nodes& nodes, const Ray& ray, const TraversalLimit& limit, const float& t_best, Observe observe,
            const Leaf& leaf)
      : nodes_(nodes), slab_(ray), t_max_(ray.t_max), limit_(limit), t_best_(t_best), observe_(observe), leaf_(leaf) {}

  void run(std::uint32_t depth) {
    if constexpr (options.form == TraversalForm::recursive)
      descend(nodes_.root());
    else
      iterate(depth);
  }

 private:
  struct Children {
    Ref near, far;
    float near_entry, far_entry;  // infinity: not met
  };

  float bound() const { return limit_(options.pruned ? t_best_ : t_max_); }

  float enter(Ref ref) {
    observe_.node();
    if constexpr (Observe::touches) nodes_.touch_box(ref, observe_.touch);
    return slab_.entry(nodes_.bounds(ref), bound());
  }
  void look(Ref ref) {
    if constexpr (Observe::touches) nodes_.touch_links(ref, observe_.touch);
  }

  Children test_children(Ref ref) {
    Children c{nodes_.left(ref), nodes_.right(ref), 0, 0};
    c.near_entry = enter(c.near);
    c.far_entry = enter(c.far);
    if (options.ordered && c.far_entry < c.near_entry) {
      std::swap(c.near, c.far);
      std::swap(c.near_entry, c.far_entry);
    }
    return c;
  }

  // This is the plain recursion of lecture notes.
  void descend(Ref ref) {
    look(ref);
    if (nodes_.is_leaf(ref)) {
      leaf_(nodes_.first(ref), nodes_.count(ref));
      return;
    }
    const Children c = test_children(ref);
    if (c.near_entry < infinity) descend(c.near);
    if (c.far_entry < infinity && c.far_entry <= bound()) descend(c.far);
  }

  void iterate(std::uint32_t depth) {
    struct Waiting {
      Ref ref;
      float entry;
    };
    TraversalStack<Waiting> stack(depth);
    Waiting* top = stack.begin();
    for (Ref ref = nodes_.root();;) {
      look(ref);
      bool inside = false;
      if (nodes_.is_leaf(ref)) {
        leaf_(nodes_.first(ref), nodes_.count(ref));
      } else {
        const Children c = test_children(ref);
        if (c.near_entry < infinity) {
          if (c.far_entry < infinity) *top++ = {c.far, c.far_entry};
          ref = c.near;
          inside = true;
        } else if (c.far_entry < infinity) {
          ref = c.far;
          inside = true;
        }
      }
      if (inside) continue;
      do {
        if (top == stack.begin()) return;
        --top;
      } while (top->entry > bound());
      ref = top->ref;
    }
  }

  const Nodes& nodes_;
  const Slab slab_;
  const float t_max_;
  const TraversalLimit limit_;
  const float& t_best_;
  Observe observe_;
  const Leaf& leaf_;
};

// Visits the leaves of a tree that a ray may meet: leaf(first, count), as t_best falls.
template <TraversalOptions options, class Slab, class Nodes, class Leaf, class Observe = ObserveNothing>
void traverse(const BinaryTree& tree, const Nodes& nodes, const Ray& ray, const TraversalLimit& limit, const float& t_best,
              const Leaf& leaf, Observe observe = {}) {
  Traversal<options, Slab, Nodes, Observe, Leaf>(nodes, ray, limit, t_best, observe, leaf).run(tree.depth);
}

// The closest hit of what test(hit, limit) tests, in a world of its own; `extent` is largest_coordinate of it.
template <class Test>
Hit closest_of(const Ray& ray, float extent, const Test& test) {
  if (!is_traceable(ray)) return {};
  Hit hit;
  hit.t = farthest_hit(ray);
  test(hit, TraversalLimit(ray, extent));
  return placed(hit);
}

// A tree, and its leaves as runs of packs.
struct VariantTree {
  VariantTree(const Geometry& geometry, BinaryTree of_builder)
      : leaves(geometry),
        tree(std::move(of_builder)),
        extent(tree.nodes.empty() ? 0 : largest_coordinate(tree.nodes[0].bounds)) {
    for (TreeNode& node : tree.nodes) {
      if (!node.is_leaf()) continue;
      const Leaves::Run run = leaves.add(std::span(tree.primitives).subspan(node.first, node.count));
      node.first = run.first;
      node.count = run.count;
    }
  }

  Leaves leaves;
  BinaryTree tree;  // its leaves name packs
  float extent;
};

// Finds the closest hit by one variant.
template <TraversalOptions options, class Slab, class Nodes, class Observe = ObserveNothing>
Hit closest_by(const VariantTree& tree, const Nodes& nodes, const Ray& ray, Observe observe = {}) {
  if (tree.tree.nodes.empty()) return {};
  const LeafTest<false> test(tree.leaves, ray);
  CountNothing nothing;
  return closest_of(ray, tree.extent, [&](Hit& hit, const TraversalLimit& limit) {
    const auto leaf = [&](std::uint32_t first, std::uint32_t count) { test(Leaves::Run{first, count}, hit, nothing); };
    traverse<options, Slab>(tree.tree, nodes, ray, limit, hit.t, leaf, observe);
  });
}

}  // namespace etendue
