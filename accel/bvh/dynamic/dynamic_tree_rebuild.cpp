// DynamicTree: which subtrees are rebuilt, and how their new nodes take the place of the old ones.
#include "accel/bvh/dynamic/dynamic_tree.h"
#include "framework/core/check.h"
#include "framework/core/parallel.h"

#include <set>

namespace etendue {

TreeUpdate DynamicTree::rebuild_worsened() {
  std::vector<std::uint32_t> roots;
  double gain = 0;  // if they came to cost again what they did
  for (std::uint32_t node = 0; node < costs_.size(); ++node) {
    if (!is_worsened(node) || !is_topmost(node)) continue;
    roots.push_back(node);
    gain += static_cast<double>(costs_[node].now.work) * (1 - 1 / static_cast<double>(costs_[node].growth));
  }
  if (gain < static_cast<double>(policy_.hybrid.least_gain) * static_cast<double>(costs_[0].now.work)) return {};
  TreeUpdate done;
  const std::vector<std::uint32_t> wanting = rebuild_below(roots, false, done);
  rebuild_below(topmost_of(wanting), true, done);
  return done;
}

// Rebuilds subtrees, whole or but for what need not be taken apart. Of the latter kind, those are answered that a whole rebuild
// should follow, for they are worsened still; the others keep their old measure, lest many rebuilds in part add up.
std::vector<std::uint32_t> DynamicTree::rebuild_below(std::span<const std::uint32_t> roots, bool whole, TreeUpdate& done) {
  std::vector<Region> regions(roots.size());
  parallel_for(regions.size(), 1, [&](std::size_t i) {
    regions[i] = gather(roots[i], whole);
    regions[i].tree = build_(std::move(regions[i].items));
  });
  std::vector<std::uint32_t> wanting;
  for (const Region& region : regions) {
    const Areas built = costs_[region.root].built;
    const std::uint32_t link = region.root == 0 ? root_link : links_[region.root];
    release(region);
    emit(region, link);
    done.rebuilt += region.parts.size();
    ++done.subtrees;
    const TreeNode root = link == root_link ? TreeNode{{}, 0, 0} : layout_.child(link / 2, static_cast<int>(link % 2));
    const auto is_subtree = [](std::uint32_t part) { return (part & subtree_bit) != 0; };
    if (root.is_leaf() || std::none_of(region.parts.begin(), region.parts.end(), is_subtree)) continue;
    Cost& cost = costs_[root.first];
    cost.built = built;
    cost.growth = growth_of(cost);
    if (is_worsened(root.first)) wanting.push_back(root.first);
  }
  return wanting;
}

// The nodes that hang below no other of them.
std::vector<std::uint32_t> DynamicTree::topmost_of(std::span<const std::uint32_t> nodes) const {
  const std::set<std::uint32_t> all(nodes.begin(), nodes.end());
  std::vector<std::uint32_t> topmost;
  for (std::uint32_t node : all) {
    bool below = false;
    for (std::uint32_t link = links_[node]; link != root_link && !below; link = links_[link / 2])
      below = all.contains(link / 2);
    if (!below) topmost.push_back(node);
  }
  return topmost;
}

bool DynamicTree::is_worsened(std::uint32_t node) const { return costs_[node].growth > policy_.hybrid.sah_growth; }

// Whether a region that reaches this node takes it apart.
bool DynamicTree::is_opened(std::uint32_t node) const {
  const Cost& cost = costs_[node];
  const float children = layout_.child(node, 0).bounds.half_area() + layout_.child(node, 1).bounds.half_area();
  return is_worsened(node) || cost.now.box > children || cost.now.work > cost.built.work * kept_growth();
}

// Whether no worsened node above takes this one apart anyway.
bool DynamicTree::is_topmost(std::uint32_t node) const {
  while (links_[node] != root_link) {
    node = links_[node] / 2;
    if (is_worsened(node)) return false;
    if (!is_opened(node)) return true;
  }
  return true;
}

DynamicTree::Region DynamicTree::gather(std::uint32_t root, bool whole) const {
  Region region{root, {}, {}, {}, {}, {}};
  std::vector<std::uint32_t> open{root};
  while (!open.empty()) {
    const std::uint32_t node = open.back();
    open.pop_back();
    region.nodes.push_back(node);
    for (int side = 0; side < 2; ++side) {
      const TreeNode child = layout_.child(node, side);
      if (child.is_leaf()) {
        region.leaves.push_back(child.first);
        const Leaf& leaf = leaves_[child.first];
        for (std::uint32_t i = 0; i < leaf.count; ++i) add_part(region, leaf.items[i], boxes_[leaf.items[i]]);
      } else if (whole || is_opened(child.first)) {
        open.push_back(child.first);
      } else {
        // A subtree whose items are all absent has no box; a builder wants one.
        const Bounds box = child.bounds.empty() ? Bounds{vec3(0), vec3(0)} : child.bounds;
        add_part(region, subtree_bit | child.first, box);
      }
    }
  }
  return region;
}

void DynamicTree::add_part(Region& region, std::uint32_t part, const Bounds& box) const {
  region.items.push_back({box, static_cast<std::uint32_t>(region.parts.size())});
  region.parts.push_back(part);
}

// Nodes and leaves that a region gives up are taken again lowest first, so that its new nodes lie as close as the old ones did.
void DynamicTree::release(const Region& region) {
  for (const std::uint32_t node : region.nodes) {
    costs_[node] = {};
    free_nodes_.push_back(node);
  }
  for (const std::uint32_t leaf : region.leaves) {
    leaves_[leaf].count = 0;
    touch(leaf);
    free_leaves_.push_back(leaf);
  }
  std::sort(free_nodes_.begin(), free_nodes_.end(), std::greater());
  std::sort(free_leaves_.begin(), free_leaves_.end(), std::greater());
}

// Hangs the built tree where the region hung. The tree's root is node 0 whatever it holds.
void DynamicTree::emit(const Region& region, std::uint32_t link) {
  struct Job {
    std::uint32_t node, link;
  };
  const BinaryTree& tree = region.tree;
  const auto parts_of = [&](const TreeNode& leaf) { return std::span(tree.primitives).subspan(leaf.first, leaf.count); };
  emitted_.clear();
  std::vector<Job> jobs{{0, link}};
  if (link == root_link && tree.nodes[0].is_leaf()) {
    const std::span<const std::uint32_t> parts = parts_of(tree.nodes[0]);
    const std::uint32_t root = take_node(root_link);
    emit_parts(parts.first(parts.size() / 2), region, 2 * root);
    emit_parts(parts.subspan(parts.size() / 2), region, 2 * root + 1);
    jobs.clear();
  }
  while (!jobs.empty()) {
    const Job job = jobs.back();
    jobs.pop_back();
    const TreeNode& node = tree.nodes[job.node];
    if (node.is_leaf()) {
      emit_parts(parts_of(node), region, job.link);
      continue;
    }
    const std::uint32_t taken = take_node(job.link);
    jobs.push_back({node.first + 1, 2 * taken + 1});
    jobs.push_back({node.first, 2 * taken});
  }
  fit_emitted(link);
}

// Items that fit into one leaf become one, a kept subtree hangs as it is, and more than that is halved.
void DynamicTree::emit_parts(std::span<const std::uint32_t> order, const Region& region, std::uint32_t link) {
  const auto is_subtree = [&](std::uint32_t position) { return (region.parts[position] & subtree_bit) != 0; };
  if (order.size() == 1 && is_subtree(order[0])) {
    const std::uint32_t node = region.parts[order[0]] & ~subtree_bit;
    links_[node] = link;
    hang(link, {node_bounds(node), node, 0});
    return;
  }
  if (order.size() <= leaf_size && std::none_of(order.begin(), order.end(), is_subtree)) {
    const std::uint32_t index = take_leaf(link);
    Leaf& leaf = leaves_[index];
    for (const std::uint32_t position : order) {
      leaf.items[leaf.count++] = region.parts[position];
      leaf_of_[region.parts[position]] = index;
    }
    hang(link, {leaf_bounds(index), index, 1});
    return;
  }
  const std::uint32_t node = take_node(link);
  emit_parts(order.first(order.size() / 2), region, 2 * node);
  emit_parts(order.subspan(order.size() / 2), region, 2 * node + 1);
}

// Children were emitted after their parents, so backwards they come first. Then what hangs above learns of the new cost.
void DynamicTree::fit_emitted(std::uint32_t link) {
  const auto height_below = [&](std::uint32_t node) {
    std::uint32_t height = 0;
    for (int side = 0; side < 2; ++side)
      if (const TreeNode child = layout_.child(node, side); !child.is_leaf()) height = std::max(height, heights_[child.first]);
    return height + 1;
  };
  for (std::size_t i = emitted_.size(); i-- > 0;) {
    const std::uint32_t node = emitted_[i];
    hang(links_[node], {fit(node), node, 0});
    costs_[node].built = costs_[node].now;
    costs_[node].growth = 1;
    heights_[node] = height_below(node);
  }
  for (; link != root_link; link = links_[link / 2]) {
    fit(link / 2);
    heights_[link / 2] = height_below(link / 2);
  }
}

std::uint32_t DynamicTree::take_node(std::uint32_t link) {
  std::uint32_t node;
  if (free_nodes_.empty()) {
    node = layout_.add_node();
    links_.push_back(0);
    heights_.push_back(0);
    costs_.emplace_back();
    waiting_.push_back(0);
  } else {
    node = free_nodes_.back();
    free_nodes_.pop_back();
  }
  links_[node] = link;
  emitted_.push_back(node);
  hang(link, {{}, node, 0});
  return node;
}

std::uint32_t DynamicTree::take_leaf(std::uint32_t link) {
  std::uint32_t leaf;
  if (free_leaves_.empty()) {
    leaf = leaf_count();
    leaves_.emplace_back();
    is_touched_.push_back(0);
  } else {
    leaf = free_leaves_.back();
    free_leaves_.pop_back();
  }
  leaves_[leaf].count = 0;
  leaves_[leaf].link = link;
  touch(leaf);
  return leaf;
}

void DynamicTree::hang(std::uint32_t link, const TreeNode& child) {
  if (link != root_link) layout_.set_child(link / 2, static_cast<int>(link % 2), child);
}

}  // namespace etendue
