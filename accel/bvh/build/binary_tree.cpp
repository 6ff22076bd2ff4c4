#include "accel/bvh/build/binary_tree.h"

#include "accel/bvh/build/triangle_box.h"
#include "framework/core/parallel.h"

namespace etendue {

double BinaryTree::sah_cost() const {
  if (nodes.empty()) return 0;
  double cost = 0;
  for (const TreeNode& node : nodes) cost += static_cast<double>(node.bounds.half_area()) * (node.is_leaf() ? node.count : 1u);
  const double root_area = nodes[0].bounds.half_area();
  return root_area > 0 && std::isfinite(root_area) ? cost / root_area : 0;
}

BuildItems build_items(const Geometry& geometry) {
  const std::size_t count = geometry.primitive_count(), chunk_size = 1 << 13;
  BuildItems items(count);
  std::vector<std::size_t> valid((count + chunk_size - 1) / chunk_size);  // of each chunk, at its beginning
  parallel_for(valid.size(), 1, [&](std::size_t chunk) {
    const std::size_t begin = chunk * chunk_size, end = std::min(count, begin + chunk_size);
    std::size_t place = begin;
    for (auto id = static_cast<std::uint32_t>(begin); id < end; ++id) {
      if (geometry.is_triangle(id)) {
        const TriangleBox box = triangle_box(geometry, id);
        if (box.is_valid) items[place++] = {box.bounds(), id};
      } else if (geometry.is_valid(id)) {
        const Bounds bounds = geometry.primitive_bounds(id);
        items[place++] = {{bounds.lower + 0.0f, bounds.upper + 0.0f}, id};
      }
    }
    valid[chunk] = place - begin;
  });
  std::size_t size = 0;
  for (std::size_t chunk = 0; chunk < valid.size(); ++chunk) {
    const auto begin = items.begin() + static_cast<std::ptrdiff_t>(chunk * chunk_size);
    if (size != chunk * chunk_size)
      std::move(begin, begin + static_cast<std::ptrdiff_t>(valid[chunk]), items.begin() + static_cast<std::ptrdiff_t>(size));
    size += valid[chunk];
  }
  items.resize(size);
  return items;
}

BinaryTree depth_first(const BinaryTree& tree) {
  BinaryTree ordered;
  if (tree.nodes.empty()) return ordered;
  struct Move {
    std::uint32_t from, to, depth;
  };
  ordered.nodes.reserve(tree.nodes.size());
  ordered.nodes.resize(1);
  ordered.primitives.reserve(tree.primitives.size());
  std::vector<Move> moves{{0, 0, 0}};
  while (!moves.empty()) {
    const Move move = moves.back();
    moves.pop_back();
    const TreeNode& node = tree.nodes[move.from];
    TreeNode& copy = ordered.nodes[move.to] = node;
    ordered.depth = std::max(ordered.depth, move.depth);
    if (node.is_leaf()) {
      copy.first = static_cast<std::uint32_t>(ordered.primitives.size());
      const auto begin = tree.primitives.begin() + node.first;
      ordered.primitives.insert(ordered.primitives.end(), begin, begin + node.count);
      continue;
    }
    const auto first = copy.first = static_cast<std::uint32_t>(ordered.nodes.size());
    ordered.nodes.resize(ordered.nodes.size() + 2);
    moves.push_back({node.first + 1, first + 1, move.depth + 1});
    moves.push_back({node.first, first, move.depth + 1});
  }
  return ordered;
}

BinaryTree single_leaf(std::span<const BuildItem> items) {
  BinaryTree tree;
  if (items.empty()) return tree;
  for (const BuildItem& item : items) tree.primitives.push_back(item.id);
  tree.nodes.push_back({{vec3(-infinity), vec3(infinity)}, 0, static_cast<std::uint32_t>(items.size())});
  return tree;
}

}  // namespace etendue
