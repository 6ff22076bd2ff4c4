#include "accel/bvh/bvh.h"

namespace etendue {

static_assert(RayStructure<Bvh>);

Bvh::Bvh(const Geometry& geometry, BinaryTree tree) : leaves_(geometry), sah_cost_(tree.sah_cost()) {
  for (TreeNode& node : tree.nodes) {
    if (!node.is_leaf()) continue;
    const Leaves::Run run = leaves_.add(std::span(tree.primitives).subspan(node.first, node.count));
    node.first = run.first;
    node.count = run.count;
  }
  layout_ = BinaryLayout(tree);
}

RayStructureStats Bvh::stats() const {
  return {layout_.bytes() + leaves_.bytes(), layout_.node_count(), layout_.depth(), leaves_.references(), sah_cost_, "binary"};
}

}  // namespace etendue
