#include "accel/ray/layout_binary.h"

namespace etendue {

void BinaryLayout::set_child(Node& node, int side, const TreeNode& child) {
  for (int axis = 0; axis < 3; ++axis) {
    node.planes[axis][side] = child.bounds.lower[axis];
    node.planes[axis][2 + side] = child.bounds.upper[axis];
  }
  node.children[side] = {child.first, child.count};
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
