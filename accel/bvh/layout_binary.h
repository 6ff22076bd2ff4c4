// The `binary` layout: a tree as 64-byte nodes, one cache line each, that hold the boxes of both children.
//
// A visit tests the two children at once (in four lanes: near and far of both) and goes on to the nearer; the other waits on a
// stack with its entry distance and is dropped if a closer hit has come up meanwhile. The test keeps the rules of
// kernels/box_test.h. Boxes are entered up to a little beyond the best distance (TraversalLimit), so that hits at equal
// distance in other leaves are still seen and the lowest primitive id wins.
//
// The traversal knows no primitives: leaves are the caller's, which is why both levels of a scene use this one.
#pragma once

#include "accel/bvh/build/binary_tree.h"
#include "accel/kernels/box_test.h"
#include "accel/kernels/simd_bounds.h"
#include "accel/kernels/traversal_stack.h"

namespace etendue {

// At the end of a branch, keeps the compiler from making a conditional move of it.
inline void keep_branch() {
#if defined(__GNUC__)
  asm volatile("");
#endif
}

class BinaryLayout {
 public:
  BinaryLayout() = default;
  explicit BinaryLayout(const BinaryTree& tree);

  // Visits the leaves that the ray meets, nearest box first, while `t_best` (which `leaf` lowers as it finds hits) lets them.
  // `leaf(first, count)` gets what the tree's leaf holds and returns true to end the traversal.
  template <class Count, class Leaf>
  void traverse(const Ray& ray, const float& t_best, Count& count, const Leaf& leaf) const;

  // Changing a tree in place (dynamic_tree.h). A child is given as in a BinaryTree, but that `first` of an inner one is its
  // node here; node 0 is the root. `set_root` must follow whatever moved the root's box or made the tree deeper.
  TreeNode child(std::uint32_t node, int side) const;
  void set_child(std::uint32_t node, int side, const TreeNode& child) { set_child(nodes_[node], side, child); }
  std::uint32_t add_node();
  void clear() { nodes_.clear(); }
  void set_root(const Bounds& bounds, std::uint32_t depth);

  static constexpr std::size_t node_bytes = 64;
  std::uint64_t node_count() const { return nodes_.size(); }
  std::uint64_t bytes() const { return nodes_.size() * node_bytes; }
  std::uint32_t depth() const { return depth_; }

 private:
  // An inner node's place has count 0. A missing child (of a root that is a leaf) has an empty box.
  struct Place {
    std::uint32_t first, count;
  };
  struct alignas(64) Node {
    float planes[3][4];  // per axis: lower of left, lower of right, upper of left, upper of right
    Place children[2];
  };
  static_assert(sizeof(Node) == node_bytes);
  struct Waiting {
    Place place;
    float entry;
  };
  class RayBoxes;

  static void set_child(Node& node, int side, const TreeNode& child);

  std::vector<Node> nodes_;  // 0 is the root
  std::uint32_t depth_ = 0;
  float extent_ = 0;  // largest_coordinate of the root's box
};

// One ray against the two boxes of a node. Lanes: entry of left and right, then the negated exits, so that all four are maxima.
class BinaryLayout::RayBoxes {
 public:
  RayBoxes(const SlabRay& ray, float limit) : t_min_(ray.t_min) {
    for (int axis = 0; axis < 3; ++axis) {
      const float reciprocal = ray.reciprocal[axis], far = -ray.padded_reciprocal[axis];
      origin_[axis] = ray.origin[axis] - FourFloats{};
      reciprocal_[axis] = FourFloats{reciprocal, reciprocal, far, far};
      near_first_[axis] = HalfSwap(ray.is_negative(axis));
    }
    shorten(limit);
  }

  void shorten(float limit) { limits_ = FourFloats{t_min_, t_min_, -limit, -limit}; }

  // Bit i: the ray meets child i, at entry[i].
  unsigned test(const Node& node, float (&entry)[2]) const {
    FourFloats t = limits_;
    for (int axis = 0; axis < 3; ++axis)
      t = larger((near_first_[axis](planes_of(node, axis)) - origin_[axis]) * reciprocal_[axis], t);
    std::memcpy(entry, &t, sizeof entry);
    return lane_bits(t <= -__builtin_shufflevector(t, t, 2, 3, 2, 3)) & 3;
  }

 private:
  static FourFloats planes_of(const Node& node, int axis) {
    FourFloats planes;
    std::memcpy(&planes, node.planes[axis], sizeof planes);
    return planes;
  }

  float t_min_;
  HalfSwap near_first_[3];
  FourFloats origin_[3], reciprocal_[3], limits_;
};

template <class Count, class Leaf>
void BinaryLayout::traverse(const Ray& ray, const float& t_best, Count& count, const Leaf& leaf) const {
  if (nodes_.empty()) return;
  const TraversalLimit limit_beyond(ray, extent_);
  float limit = limit_beyond(t_best);
  RayBoxes boxes(SlabRay(ray), limit);
  TraversalStack<Waiting> stack(depth_);
  Waiting* top = stack.begin();
  Place place{0, 0};
  for (;;) {
    while (place.count == 0) {
      const Node& node = nodes_[place.first];
      count.node();
      float entry[2];
      const unsigned met = boxes.test(node, entry);
      if (met == 0) break;
      // Three branches, and not a selection by index: once the processor has guessed where the ray goes, it loads the next node
      // while this test is still under way. Mispredictions cost less than waiting for every test would.
      if (met == 3) {
        if (entry[0] <= entry[1]) {
          *top++ = {node.children[1], entry[1]};
          place = node.children[0];
          keep_branch();
        } else {
          *top++ = {node.children[0], entry[0]};
          place = node.children[1];
          keep_branch();
        }
      } else if (met == 1) {
        place = node.children[0];
        keep_branch();
      } else {
        place = node.children[1];
        keep_branch();
      }
    }
    if (place.count > 0) {
      if (leaf(place.first, place.count)) return;
      limit = limit_beyond(t_best);
      boxes.shorten(limit);
    }
    do {
      if (top == stack.begin()) return;
      --top;
    } while (top->entry > limit);
    place = top->place;
  }
}

}  // namespace etendue
