// Which subtrees of a binary tree become the nodes of a wide one, which its leaves: dynamic programming over "this subtree as
// at most i children" ([Ylitie2017] section 3.1), from the leaves up.
//
// The costs of a subtree are needed for its parent alone and lie on a stack; kept is what the choices were. Subtrees are
// planned by several threads, and what is chosen depends on none of them.
#pragma once

#include "accel/bvh/wide/leaf_contents.h"
#include "accel/bvh/wide/wide_tree.h"
#include "accel/kernels/simd_bounds.h"
#include "framework/core/parallel.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace etendue {

template <int node_width, class Pack>
class CollapsePlan {
 public:
  CollapsePlan(const Geometry& geometry, const BinaryTree& tree, const LeafContents& contents, const CollapseOptions& options)
      : geometry_(&geometry),
        corners_(contents.corners.get()),
        areas_(contents.areas.get()),
        tree_(tree),
        leaf_size_(std::min<std::uint32_t>(options.leaf_size, Pack::lanes)),
        leaf_cost_(options.leaf_cost),
        joins_leaves_(!options.leaves_are_packs),
        each_is_a_pack_(options.each_is_a_pack) {
    plan(2048);
  }
  explicit CollapsePlan(const PackTree<Pack>& packs)
      : areas_(packs.areas.get()),
        tree_(packs.tree),
        leaf_size_(1),
        leaf_cost_(CollapseOptions().leaf_cost),
        joins_leaves_(false),
        each_is_a_pack_(true) {
    plan(2048 / 8);
  }
  bool is_leaf(std::uint32_t n) const { return tree_.nodes[n].is_leaf() || shares_[n][0] == as_leaf; }
  std::uint32_t count(std::uint32_t n) const { return nodes_[n].count; }  // of its primitives
  // The ids of a leaf's primitives, where the tree is over a geometry.
  std::span<const std::uint32_t> primitives(std::uint32_t n) const {
    return std::span(tree_.primitives).subspan(nodes_[n].first, nodes_[n].count);
  }
  std::span<const uvec3> corners(std::uint32_t n) const { return {corners_ + nodes_[n].first, nodes_[n].count}; }

  [[gnu::always_inline]] void prefetch(std::uint32_t n) const {
    const std::uint32_t first = nodes_[n].first;
    __builtin_prefetch(&tree_.primitives[first]);
    __builtin_prefetch(corners_ + first);
    __builtin_prefetch(reinterpret_cast<const char*>(corners_ + first) + 64);
  }

  // Whether the primitives of a leaf fit a pack; if not, they are a list.
  bool is_pack(std::uint32_t n) const { return nodes_[n].one_pack != 0; }

  // The children of the wide node that binary node n becomes, as binary nodes; replaces `children`.
  void children(std::uint32_t n, std::vector<std::uint32_t>& children) const {
    children.clear();
    const int left_share = shares_[n][0];
    append_roots(tree_.nodes[n].first, left_share, children);
    append_roots(tree_.nodes[n].first + 1, node_width - left_share, children);
  }

  // The chance that a ray which meets a subtree's box hits something there, over the visits which that takes: what an any-hit
  // query should try first (after [Nah2014]).
  float any_hit_priority(std::uint32_t n) const {
    const float chance = std::min(tree_.nodes[n].bounds.half_area(), nodes_[n].content), visits = nodes_[n].cost;
    return visits > 0 && visits < infinity ? chance / visits : 0;
  }

 private:
  // How a subtree becomes i + 1 children at most: shares[i] is as_fewer, or the left side's part of them; shares[0] is as_leaf,
  // or the left side's part of the slots of the wide node that the subtree becomes. Nothing is kept of a binary leaf.
  static constexpr std::int8_t as_leaf = 0, as_fewer = -1;
  using Shares = std::array<std::int8_t, node_width>;

  struct Node {
    std::uint32_t first, count : 31;  // its run of BinaryTree::primitives
    std::uint32_t one_pack : 1;       // takes all of them
    float content;                    // area of these
    float cost;                       // as one child
  };

  // The least cost of a subtree as i + 1 children at most, for i < slots; more slots save nothing, and infinity stands there.
  struct Costs {
    int slots = 1;
    bool fits = true;  // a leaf
    std::array<float, node_width> cost;

    Costs() { cost.fill(infinity); }
  };

  // A node above the subtrees that are tasks. Costs lie by place, those of its sides together.
  struct Upper {
    std::uint32_t node, place, sides;
  };
  struct Root {
    std::uint32_t node, place;
  };

  // Plans subtrees of up to so many primitives in parallel.
  void plan(std::uint32_t task_size) {
    nodes_ = uninitialised_on_huge_pages<Node>(tree_.nodes.size());
    shares_ = uninitialised_on_huge_pages<Shares>(tree_.nodes.size());
    std::vector<Upper> above;  // parents before children
    std::vector<Root> roots;
    std::uint32_t places = 1;
    struct Part {
      std::uint32_t node, place, begin, end;  // the primitives below
    };
    std::vector<Part> parts{{0, 0, first_primitive(0), end_of_primitives()}};
    while (!parts.empty()) {
      const Part part = parts.back();
      parts.pop_back();
      const TreeNode& node = tree_.nodes[part.node];
      if (node.is_leaf() || part.end - part.begin <= task_size) {
        roots.push_back({part.node, part.place});
        continue;
      }
      const std::uint32_t middle = first_primitive(node.first + 1);
      above.push_back({part.node, part.place, places});
      parts.push_back({node.first + 1, places + 1, middle, part.end});
      parts.push_back({node.first, places, part.begin, middle});
      places += 2;
    }
    std::vector<Costs> costs(places);
    parallel_for(roots.size(), 1, [&](std::size_t i) { costs[roots[i].place] = plan_subtree(roots[i].node); });
    for (auto u = above.rbegin(); u != above.rend(); ++u)
      plan_inner(u->node, costs[u->sides], costs[u->sides + 1], costs[u->place]);
  }

  // The first primitive of a subtree.
  std::uint32_t first_primitive(std::uint32_t n) const {
    while (!tree_.nodes[n].is_leaf()) n = tree_.nodes[n].first;
    return tree_.nodes[n].first;
  }
  std::uint32_t end_of_primitives() const {
    std::uint32_t n = 0;
    while (!tree_.nodes[n].is_leaf()) n = tree_.nodes[n].first + 1;
    return tree_.nodes[n].first + tree_.nodes[n].count;
  }

  // Children before parents, the right side's costs on top of the left's.
  Costs plan_subtree(std::uint32_t root) {
    struct Visit {
      std::uint32_t node;
      bool children_done;
    };
    std::vector<Visit> visits{{root, false}};
    std::vector<Costs> done(1);
    std::size_t size = 0;
    while (!visits.empty()) {
      const Visit visit = visits.back();
      visits.pop_back();
      const TreeNode& node = tree_.nodes[visit.node];
      if (node.is_leaf()) {
        if (size == done.size()) done.emplace_back();
        plan_leaf(visit.node, done[size++]);
      } else if (visit.children_done) {
        --size;
        plan_inner(visit.node, done[size - 1], done[size], done[size - 1]);
      } else {
        visits.push_back({visit.node, true});
        visits.push_back({node.first + 1, false});
        visits.push_back({node.first, false});
      }
    }
    return done.front();
  }

  void plan_leaf(std::uint32_t n, Costs& costs) {
    Node& node = nodes_[n];
    const TreeNode& leaf = tree_.nodes[n];
    const float area = leaf.bounds.half_area();
    node.first = leaf.first;
    node.count = leaf.count;
    node.content = 0;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) node.content += areas_[i];
    costs = Costs();
    const float cost = leaf_cost(n);
    costs.fits = cost < infinity;
    node.cost = costs.cost[0] = area * (costs.fits ? cost : static_cast<float>(node.count));
  }

  // `costs` may be those of a side.
  void plan_inner(std::uint32_t n, const Costs& left, const Costs& right, Costs& costs) {
    const TreeNode& binary = tree_.nodes[n];
    Node& node = nodes_[n];
    Shares& shares = shares_[n];
    const float area = binary.bounds.half_area();
    const Node &left_node = nodes_[binary.first], &right_node = nodes_[binary.first + 1];
    node.first = left_node.first;
    node.count = left_node.count + right_node.count;
    node.content = left_node.content + right_node.content;
    const bool both_fit = left.fits && right.fits;
    alignas(16) float shared[node_width];
    alignas(16) std::int32_t share[node_width];
    share_slots(left, right, shared, share);
    costs.slots = std::min(node_width, left.slots + right.slots);
    costs.cost[0] = area + shared[costs.slots - 1];
    shares[0] = static_cast<std::int8_t>(share[costs.slots - 1]);
    costs.fits = joins_leaves_ && both_fit && node.count <= leaf_size_;
    if (costs.fits) {
      const float cost = leaf_cost(n);
      costs.fits = cost < infinity;
      if (area * cost <= costs.cost[0]) {
        costs.cost[0] = area * cost;
        shares[0] = as_leaf;
      }
    }
    node.cost = costs.cost[0];
    int useful = 1;
    for (int i = 1; i < costs.slots; ++i) {
      const bool better = shared[i] < costs.cost[i - 1];
      costs.cost[i] = better ? shared[i] : costs.cost[i - 1];
      shares[i] = better ? static_cast<std::int8_t>(share[i]) : as_fewer;
      if (better) useful = i + 1;
    }
    costs.slots = useful;
    std::fill(costs.cost.begin() + useful, costs.cost.end(), infinity);
    std::fill(shares.begin() + useful, shares.end(), as_fewer);
  }

  // The least cost of both sides in i + 1 slots, and the left one's part of these. Lanes are slots, and rows of the right
  // side's costs are added to each of the left's.
  static void share_slots(const Costs& left, const Costs& right, float* shared, std::int32_t* share) {
    constexpr int vectors = node_width / 4;
    float row[2 * node_width];
    std::fill_n(row, node_width, infinity);
    std::copy_n(right.cost.data(), node_width, row + node_width);
    FourFloats least[vectors];
    FourInts part[vectors];
    for (int v = 0; v < vectors; ++v) {
      least[v] = FourFloats{} + infinity;
      part[v] = FourInts{} + 1;  // areas can exceed the range of float
    }
    for (int l = 0; l < left.slots; ++l)
#pragma GCC unroll 4
      for (int v = 0; v < vectors; ++v) {
        FourFloats cost;
        std::memcpy(&cost, row + node_width - 1 - l + 4 * v, sizeof cost);
        cost += left.cost[l];
        const FourInts better = cost < least[v];
        least[v] = better ? cost : least[v];
        part[v] = better ? FourInts{} + (l + 1) : part[v];
      }
    std::memcpy(shared, least, sizeof least);
    std::memcpy(share, part, sizeof part);
  }

  // The cost of a subtree as one leaf, in visits of a node: that of a pack, or of one test for each quadric; infinite for what
  // no leaf should be.
  float leaf_cost(std::uint32_t n) {
    if (each_is_a_pack_) {
      nodes_[n].one_pack = 1;
      return leaf_cost_;
    }
    const auto run = primitives(n);
    const auto is_triangle = [&](std::uint32_t id) { return geometry_->is_triangle(id); };
    const auto triangles = geometry_->quadrics.empty() ? std::ssize(run) : std::count_if(run.begin(), run.end(), is_triangle);
    nodes_[n].one_pack = triangles == std::ssize(run) && Pack::fits(corners(n));
    if (nodes_[n].one_pack) return leaf_cost_;
    return triangles == 0 ? static_cast<float>(run.size()) : infinity;
  }

  // Appends the binary nodes that stand for subtree n in at most `slots` children.
  void append_roots(std::uint32_t n, int slots, std::vector<std::uint32_t>& roots) const {
    struct Part {
      std::uint32_t node;
      int slots;
    };
    std::array<Part, 2 * node_width> parts;
    int size = 0;
    parts[size++] = {n, slots};
    while (size > 0) {
      auto [node, i] = parts[--size];
      if (tree_.nodes[node].is_leaf()) i = 1;
      while (i > 1 && shares_[node][i - 1] == as_fewer) --i;
      if (i == 1) {
        roots.push_back(node);
        continue;
      }
      const int left = shares_[node][i - 1];
      parts[size++] = {tree_.nodes[node].first + 1, i - left};
      parts[size++] = {tree_.nodes[node].first, left};
    }
  }

  // Null where the primitives are packs.
  const Geometry* geometry_ = nullptr;
  const uvec3* corners_ = nullptr;

  const float* areas_;  // by place in the tree
  const BinaryTree& tree_;
  const std::uint32_t leaf_size_;
  const float leaf_cost_;
  const bool joins_leaves_, each_is_a_pack_;
  UninitialisedArray<Node> nodes_;
  UninitialisedArray<Shares> shares_;
};

}  // namespace etendue
