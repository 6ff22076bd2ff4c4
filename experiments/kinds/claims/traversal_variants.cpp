#include "experiments/kinds/claims/traversal_variants.h"

namespace etendue {

std::unique_ptr<LinkedNodes::Node> LinkedNodes::make(const BinaryTree& tree, std::uint32_t index, Node* parent, int depth) {
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

VariantTree::VariantTree(const Geometry& geometry, BinaryTree of_builder) : leaves(geometry), tree(std::move(of_builder)) {
  for (TreeNode& node : tree.nodes) {
    if (!node.is_leaf()) continue;
    const Leaves::Run run = leaves.add(std::span(tree.primitives).subspan(node.first, node.count));
    node.first = run.first;
    node.count = run.count;
  }
  extent = tree.nodes.empty() ? 0 : largest_coordinate(tree.nodes[0].bounds);
}

}  // namespace etendue
