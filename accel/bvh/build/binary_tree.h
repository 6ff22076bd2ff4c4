// The product of every builder: a binary tree of boxes in one contiguous array, and the primitives in leaf order.
//
// Builders decide which tree; layouts (layout_binary.h) decide how it lies in memory and how it is traversed. A tree knows
// neither triangles nor instances, only boxes and ids, so that the same builders serve both levels of a scene.
#pragma once

#include "framework/core/huge_pages.h"
#include "framework/scene/geometry.h"

#include <cstdint>
#include <span>
#include <vector>

namespace etendue {

// The box around both.
inline Bounds united(Bounds a, const Bounds& b) {
  a.extend(b);
  return a;
}

// The box that both cover; it is empty where they do not meet.
inline Bounds overlap(const Bounds& a, const Bounds& b) { return {glm::max(a.lower, b.lower), glm::min(a.upper, b.upper)}; }

// A primitive as builders see it: two vectors of four floats.
struct alignas(16) BuildItem {
  Bounds bounds;
  std::uint32_t id = no_id;
};

// After a resize, items are yet to be written.
using BuildItems = HugePageVector<BuildItem>;

struct TreeNode {
  Bounds bounds;
  std::uint32_t first = 0;  // the left child, the right one follows it; in a leaf, the first of its run of primitives
  std::uint32_t count = 0;  // primitives of a leaf; 0: interior

  bool is_leaf() const { return count > 0; }
};

struct BinaryTree {
  std::vector<TreeNode> nodes;            // 0 is the root, children follow their parent; empty over no primitive
  std::vector<std::uint32_t> primitives;  // ids; each leaf's lie together
  std::uint32_t depth = 0;                // edges on the longest way down

  // Expected work of a random ray that meets the root's box ([Goldsmith1987], [MacDonald1990]): interior nodes and leaves weigh
  // by their surface area, a node visit counts 1 and a primitive test 1. It is 0 where the root's area cannot be divided by.
  double sah_cost() const;
};

class PackTest;

// Limits that all builders respect.
struct TreeLimits {
  int leaf_size = 4;                // primitives, at most; only a leaf at max_depth, or of a pack, may hold more
  int max_depth = 64;               // edges from the root; a node there becomes a leaf
  const PackTest* packs = nullptr;  // where set, runs that it accepts are leaves too
};

template <class Visitor>
void describe_max_depth(Visitor& v, TreeLimits& limits) {
  v.integer("max_depth", limits.max_depth, 1, 1024, "edges", "depth at which a node becomes a leaf whatever it holds");
}

template <class Visitor>
void describe(Visitor& v, TreeLimits& limits) {
  v.integer("leaf_size", limits.leaf_size, 0, 64, "primitives",
            "most in a leaf above max_depth, in wide layouts never more than a pack; 0: 4 in the binary layout, a pack in the "
            "wide ones");
  describe_max_depth(v, limits);
}

// Further parameters of builders by the surface area heuristic.
struct SahParams : TreeLimits {
  // Four triangles are tested at once (pack_query.h), so each costs well less than a visit of a node.
  float primitive_cost = 0.35f;
};

template <class Visitor>
void describe(Visitor& v, SahParams& params) {
  describe(v, static_cast<TreeLimits&>(params));
  v.number("primitive_cost", params.primitive_cost, 0.01, 100, "node visits", "cost of a primitive test, for choosing leaves");
}

// The valid primitives of a geometry. Negative zeros become positive, so that no tree depends on the order of a minimum.
BuildItems build_items(const Geometry& geometry);

// The same tree with its nodes depth first, a pair of children at a time, each leaf's primitives in the same order, and no
// node that the root does not reach.
BinaryTree depth_first(const BinaryTree& tree);

// All items in one leaf whose box is the whole space: the tree of brute force.
BinaryTree single_leaf(std::span<const BuildItem> items);

}  // namespace etendue
