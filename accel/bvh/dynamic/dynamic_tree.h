// A tree that keeps up with boxes that move: it is refitted, rebuilt, or rebuilt only where refitting does not suffice.
//
//   refit    boxes grow and shrink, bottom up, along the ways from changed leaves to the root; the topology stays ([Wald2007a])
//   rebuild  the builder starts anew at every update
//   hybrid   refits; once the items changed since the last rebuild reach `changed_fraction`, subtrees are judged: those have
//            worsened whose cost has grown by more than `sah_growth` since they were built. If undoing that would spare
//            `least_gain` of the whole tree's cost, they are rebuilt in place
//
// That single subtrees are worth restructuring is [Yoon2007]'s idea, that a measure taken at the build tells which have
// worsened [Lauterbach2006]'s; the measure is our own.
//
// The measure is the surface area cost of a subtree, visits and primitive tests weighted by area, in relation to its box and to
// the boxes of its items. The former sees what comes to overlap in a box, but misses it when the box widens too; the latter
// sees that, but misses it when items are stretched. The one that has grown more since the build counts. Below a worsened node,
// nodes are taken apart where their undivided work grew by more than the root of the threshold, or where their box is larger
// than their children's together: those span what moved apart. What remains, subtrees that are as they were wherever they moved
// to, goes to the builder as single items beside the freed primitives. Where the subtree has worsened even so, it is built anew
// as a whole, and the new cost is what later ones are measured by.
//
// Work is proportional to what changed, plus, when subtrees are judged, a pass over the nodes' costs. A node is ready when its
// changed children are, which a counter per node says; boxes and costs follow from the children alone, so the tree has the same
// bits at any thread count.
#pragma once

#include "accel/bvh/dynamic/change_policy.h"
#include "accel/bvh/layout_binary.h"

#include <array>
#include <functional>

namespace etendue {

inline constexpr std::size_t update_grain = 256;  // items of a task

// Says what an update did.
struct TreeUpdate {
  std::uint64_t refitted = 0;  // leaves
  std::uint64_t rebuilt = 0;   // items, and whole subtrees in their place, that went to the builder
  std::uint32_t subtrees = 0;  // rebuilt
};

class DynamicTree {
 public:
  static constexpr std::uint32_t leaf_size = 4;  // leaves that a builder leaves larger are halved
  using Build = std::function<BinaryTree(BuildItems)>;

  struct Leaf {
    std::array<std::uint32_t, leaf_size> items{};
    std::uint32_t count = 0;
    std::uint32_t link = 0;  // where it hangs: 2 * node + side
  };

  // Items are the indices of `boxes`. An empty box is that of an item which is absent: it keeps its place, but nothing meets
  // it.
  DynamicTree(std::vector<Bounds> boxes, Build build, const ChangePolicy& policy);

  // Items `changed` (each once) have new boxes, in the same order.
  TreeUpdate update(std::span<const std::uint32_t> changed, std::span<const Bounds> boxes);

  // The place of a leaf in it is {index of the leaf, 1}.
  const BinaryLayout& layout() const { return layout_; }
  std::uint32_t leaf_count() const { return static_cast<std::uint32_t>(leaves_.size()); }  // some may be out of use, and empty
  // The items of a leaf that are not absent, into `items`; answers how many.
  std::uint32_t present_items(std::uint32_t leaf, std::array<std::uint32_t, leaf_size>& items) const;
  // Leaves whose items, or boxes of items, the last update (or the constructor) changed.
  std::span<const std::uint32_t> touched() const { return touched_; }

  double sah_cost() const;  // as BinaryTree::sah_cost; a pass over the tree
  std::uint64_t bytes() const;

 private:
  // Work of a node and all below it, weighted by area but not divided by any; the areas of its box and its items' to divide it
  // by; and all of them as they were built.
  struct Areas {
    float work = 0, box = 0, items = 0;
  };
  struct Cost {
    Areas now, built;
    float growth = 0;
  };
  struct Region {  // of nodes to be rebuilt
    std::uint32_t root = 0;
    std::vector<std::uint32_t> nodes, leaves;  // that it gives up
    std::vector<std::uint32_t> parts;          // items, or kept subtrees by their node
    BuildItems items;                          // of the parts
    BinaryTree tree;
  };
  static constexpr std::uint32_t root_link = no_id;
  static constexpr std::uint32_t subtree_bit = 1u << 31;  // of a part

  bool is_hybrid() const { return policy_.kind == ChangePolicy::Kind::hybrid; }
  void take_boxes(std::span<const std::uint32_t> changed, std::span<const Bounds> boxes);
  void touch(std::uint32_t leaf);
  void order_touched();
  void rebuild_all();
  void refit();
  void climb_and_mark(std::uint32_t leaf);
  void climb_and_fit(std::uint32_t leaf);
  Bounds fit(std::uint32_t node);
  Areas areas_of(const TreeNode& child) const;
  Bounds leaf_bounds(std::uint32_t leaf) const;
  Bounds node_bounds(std::uint32_t node) const;

  TreeUpdate rebuild_worsened();
  std::vector<std::uint32_t> rebuild_below(std::span<const std::uint32_t> roots, bool whole, TreeUpdate& done);
  std::vector<std::uint32_t> topmost_of(std::span<const std::uint32_t> nodes) const;
  static float growth_of(const Cost& cost);
  float kept_growth() const { return std::sqrt(policy_.hybrid.sah_growth); }
  bool is_worsened(std::uint32_t node) const;
  bool is_opened(std::uint32_t node) const;
  bool is_topmost(std::uint32_t node) const;
  Region gather(std::uint32_t root, bool whole) const;
  void add_part(Region& region, std::uint32_t part, const Bounds& box) const;
  void emit(const Region& region, std::uint32_t link);
  void emit_parts(std::span<const std::uint32_t> order, const Region& region, std::uint32_t link);
  void release(const Region& region);
  void fit_emitted(std::uint32_t link);
  std::uint32_t take_node(std::uint32_t link);
  std::uint32_t take_leaf(std::uint32_t link);
  void hang(std::uint32_t link, const TreeNode& child);

  Build build_;
  ChangePolicy policy_;
  std::vector<Bounds> boxes_;  // of items; of absent ones, the last they had
  std::vector<std::uint8_t> present_, changed_;
  std::vector<std::uint32_t> leaf_of_;  // by item
  std::uint64_t changed_count_ = 0;     // since subtrees were last judged

  BinaryLayout layout_;
  std::vector<std::uint32_t> links_;    // of nodes
  std::vector<std::uint32_t> heights_;  // of nodes: edges to their deepest leaf
  std::vector<Cost> costs_;             // of nodes
  std::vector<std::uint8_t> waiting_;   // of nodes: changed children that are not ready yet
  std::vector<Leaf> leaves_;
  std::vector<std::uint8_t> is_touched_;                 // of leaves
  std::vector<std::uint32_t> free_nodes_, free_leaves_;  // descending
  std::vector<std::uint32_t> touched_, emitted_;
};

}  // namespace etendue
