// The wide layouts: a binary tree collapsed to nodes of 4, 8 or 16 children, over leaves of one SIMD pack of triangles.
//
// A node holds its children's boxes as six arrays, so that one visit tests all of them; a leaf is one pack, its triangles side
// by side. Which subtrees become nodes and which become leaves is decided by dynamic programming over "this subtree as at most
// i children" ([Ylitie2017] section 3.1), at a cost of area per node and of area per pack. A node's children lie in order of
// rising any-hit priority (chance of a hit over visits it takes), and any-hit queries go on with the last that they meet.
#pragma once

#include "accel/bvh/build/vertex_ids.h"
#include "accel/bvh/wide/pack_tree.h"
#include "accel/kernels/shared_pack.h"
#include "accel/kernels/triangle_pack.h"

#include <cstdint>
#include <span>
#include <vector>

namespace etendue {

// A child of a wide node. The kind is in the top two bits: an inner node, a pack of triangles, or a list of primitives. Lists
// are leaves that hold a quadric, and those that a tree cut off at its max_depth left larger than a pack.
class WideRef {
 public:
  enum class Kind : std::uint32_t { node = 0, list = 2, pack = 3 };

  WideRef() = default;
  WideRef(Kind kind, std::uint32_t index) : bits_(static_cast<std::uint32_t>(kind) << 30 | index) {}
  // The child of an empty slot: a list of nothing.
  static WideRef none() { return {Kind::list, 0x3fffffffu}; }

  bool is_leaf() const { return bits_ >> 31 != 0; }
  bool is_pack() const { return bits_ >> 30 == 3; }
  bool is_none() const { return bits_ == none().bits_; }
  std::uint32_t index() const { return bits_ & 0x3fffffffu; }
  std::uint32_t node() const { return bits_; }  // index() of what is no leaf

 private:
  std::uint32_t bits_;
};

template <int width>
struct alignas(64) WideNode {
  // Lower x, y and z come first, then upper. An empty slot has lower = infinity and upper = -infinity, which only rays meet
  // whose direction is too small to divide by along each axis.
  float planes[6][width];
  WideRef children[width];
};

struct WideList {
  std::uint32_t first, count;  // in WideTree::list_ids
};

template <int node_width, class Pack>
struct WideTree {
  using LeafPack = Pack;

  HugePageVector<WideNode<node_width>> nodes;  // 0: root; empty over no primitive
  HugePageVector<Pack> packs;
  std::vector<WideList> lists;
  std::vector<std::uint32_t> list_ids;
  std::uint32_t depth = 0;  // edges to the deepest leaf
  double sah_cost = 0;      // of [MacDonald1990] with wide nodes: each node visited counts 1, each triangle tested 1

  std::uint64_t bytes() const {
    return nodes.size() * sizeof(nodes[0]) + packs.size() * sizeof(packs[0]) + lists.size() * sizeof(WideList) +
           list_ids.size() * sizeof(std::uint32_t);
  }
};

struct CollapseOptions {
  std::uint32_t leaf_size = no_id;  // primitives a leaf may take, up to a pack
  float leaf_cost = 0.5f;           // of a pack, in visits of a node
  bool leaves_are_packs = false;    // the builder made leaves as large as they can be: none are joined
  bool each_is_a_pack = false;      // nor need any be tested
};

// `tree` is best built down to single primitives, so that the collapse chooses the leaves, or in less time to what a pack takes
// (PackTest), which leaves about as many packs.
template <int node_width, class Pack>
WideTree<node_width, Pack> collapse(const VertexIds& vertices, const BinaryTree& tree, const CollapseOptions& options);
// A wide tree over packs that are ready and keep their order. It takes the packs and leaves the binary tree.
template <int node_width, class Pack>
WideTree<node_width, Pack> collapse(PackTree<Pack>&& packs);

}  // namespace etendue
