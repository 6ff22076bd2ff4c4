#include "accel/bvh/layout_binary.h"

namespace etendue {

void BinaryLayout::set_child(Node& node, int side, const TreeNode& child) {
  for (int axis = 0; axis < 3; ++axis) {
    node.planes[axis][side] = child.bounds.lower[axis];
    node.planes[axis][2 + side] = child.bounds.upper[axis];
  }
  node.children[side] = {child.first, child.count};
}

TreeNode BinaryLayout::child(std::uint32_t node, int side) const {
  const Node& n = nodes_[node];
  TreeNode child{{}, n.children[side].first, n.children[side].count};
  for (int axis = 0; axis < 3; ++axis) {
    child.bounds.lower[axis] = n.planes[axis][side];
    child.bounds.upper[axis] = n.planes[axis][2 + side];
  }
  return child;
}

std::uint32_t BinaryLayout::add_node() {
  nodes_.emplace_back();
  return static_cast<std::uint32_t>(nodes_.size()) - 1;
}

void BinaryLayout::set_root(const Bounds& bounds, std::uint32_t depth) {
  extent_ = bounds.empty() ? 0 : largest_coordinate(bounds);
  depth_ = depth;
}

// Inner nodes keep the tree's order, so a child's place is the number of inner nodes before it.
BinaryLayout::BinaryLayout(const BinaryTree& tree) : depth_(tree.depth) {
  if (tree.nodes.empty()) return;
  extent_ = largest_coordinate(tree.nodes[0].bounds);
  if (tree.nodes[0].is_leaf()) {
    nodes_.resize(1);
    set_child(nodes_[0], 0, tree.nodes[0]);
    set_child(nodes_[0], 1, TreeNode{{}, 0, 1});
    return;
  }
  std::vector<std::uint32_t> place(tree.nodes.size());
  std::uint32_t inner = 0;
  for (std::size_t i = 0; i < tree.nodes.size(); ++i)
    if (!tree.nodes[i].is_leaf()) place[i] = inner++;
  nodes_.resize(inner);
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    if (tree.nodes[i].is_leaf()) continue;
    for (int side = 0; side < 2; ++side) {
      TreeNode child = tree.nodes[tree.nodes[i].first + side];
      if (!child.is_leaf()) child.first = place[tree.nodes[i].first + side];
      set_child(nodes_[place[i]], side, child);
    }
  }
}

}  // namespace etendue
