// The `binary` layout: a tree as 64-byte nodes, one cache line each, that hold the boxes of both children.
//
// A visit tests the two children at once (four SSE lanes: near and far of both) and goes on to the nearer; the other
// waits on a stack with its entry distance and is dropped if a closer hit has come up meanwhile. The slab test keeps the rules
// of slab_entry in framework/scene/intersect.h: planes picked by the sign of the direction, a NaN restricts nothing, far
// distances padded ([Ize2013]). Boxes are entered up to a little beyond the best distance (traversal_limit.h), so that
// hits at equal distance in other leaves are still seen and the lowest primitive id wins.
//
// The traversal knows no primitives: leaves are the caller's, which is why both levels of a scene use this one.
#pragma once

#include "accel/bvh/build/binary_tree.h"
#include "accel/kernels/counting.h"
#include "accel/kernels/traversal_limit.h"
#include "accel/kernels/traversal_stack.h"
#include "framework/scene/intersect.h"

#if defined(__SSE4_1__)
#include <smmintrin.h>
#endif

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

  std::uint64_t node_count() const { return nodes_.size(); }
  std::uint64_t bytes() const { return nodes_.size() * sizeof(Node); }
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

#if defined(__SSE4_1__)

// One ray against the two boxes of a node. Lanes: entry of left and right, then the negated exits, so that all four are maxima.
class BinaryLayout::RayBoxes {
 public:
  RayBoxes(const Ray& ray, float limit) : t_min_(ray.t_min) {
    const vec3 reciprocals = slab_reciprocal(ray.direction);
    for (int axis = 0; axis < 3; ++axis) {
      const float reciprocal = reciprocals[axis], far = -(reciprocal * slab_pad);
      const bool negative = std::signbit(ray.direction[axis]);
      origin_[axis] = _mm_set1_ps(ray.origin[axis]);
      reciprocal_[axis] = _mm_setr_ps(reciprocal, reciprocal, far, far);
      near_first_[axis] = negative ? _mm_setr_epi8(8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7)
                                   : _mm_setr_epi8(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    }
    shorten(limit);
  }

  void shorten(float limit) { limits_ = _mm_setr_ps(t_min_, t_min_, -limit, -limit); }

  // Bit i: the ray meets child i, at entry[i].
  int test(const Node& node, float (&entry)[2]) const {
    __m128 t = limits_;
    for (int axis = 0; axis < 3; ++axis) {
      const __m128i planes = _mm_load_si128(reinterpret_cast<const __m128i*>(node.planes[axis]));
      const __m128 near_far = _mm_castsi128_ps(_mm_shuffle_epi8(planes, near_first_[axis]));
      // maxps answers its second operand when one is NaN: a NaN restricts nothing.
      t = _mm_max_ps(_mm_mul_ps(_mm_sub_ps(near_far, origin_[axis]), reciprocal_[axis]), t);
    }
    _mm_storel_pi(reinterpret_cast<__m64*>(entry), t);
    const __m128 exit = _mm_xor_ps(_mm_movehl_ps(t, t), _mm_set1_ps(-0.0f));
    return _mm_movemask_ps(_mm_cmple_ps(t, exit)) & 3;
  }

 private:
  float t_min_;
  __m128 origin_[3], reciprocal_[3], limits_;
  __m128i near_first_[3];
};

#else

class BinaryLayout::RayBoxes {
 public:
  RayBoxes(const Ray& ray, float limit) : slab_(ray), t_min_(ray.t_min), t_max_(limit) {}
  void shorten(float limit) { t_max_ = limit; }
  int test(const Node& node, float (&entry)[2]) const {
    const auto corner = [&](int plane) { return vec3(node.planes[0][plane], node.planes[1][plane], node.planes[2][plane]); };
    for (int side = 0; side < 2; ++side) entry[side] = slab_entry(slab_, corner(side), corner(side + 2), t_min_, t_max_);
    return (entry[0] < infinity) | (entry[1] < infinity) << 1;
  }

 private:
  SlabRay slab_;
  float t_min_, t_max_;
};

#endif

template <class Count, class Leaf>
void BinaryLayout::traverse(const Ray& ray, const float& t_best, Count& count, const Leaf& leaf) const {
  if (nodes_.empty()) return;
  const TraversalLimit limit_beyond(ray, extent_);
  float limit = limit_beyond(t_best);
  RayBoxes boxes(ray, limit);
  TraversalStack<Waiting> stack(depth_);
  Waiting* top = stack.begin();
  Place place{0, 0};
  for (;;) {
    while (place.count == 0) {
      const Node& node = nodes_[place.first];
      count.node();
      float entry[2];
      const int met = boxes.test(node, entry);
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
