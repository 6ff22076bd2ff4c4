#include "accel/ray/wide_tree.h"

#include <algorithm>
#include <array>

namespace etendue {

namespace {

template <int node_width, int pack_width>
class Collapse {
 public:
  using Tree = WideTree<node_width, pack_width>;

  Collapse(const Geometry& geometry, const BinaryTree& tree, const CollapseOptions& options)
      : geometry_(geometry),
        tree_(tree),
        leaf_size_(std::min<std::uint32_t>(options.leaf_size, pack_width)),
        leaf_cost_(options.leaf_cost),
        plans_(tree.nodes.size()) {}

  Tree run() {
    if (tree_.nodes.empty()) return {};
    for (std::size_t n = tree_.nodes.size(); n-- > 0;) plan(n);
    out_.nodes.reserve(2 * tree_.nodes.size() / node_width + 1);
    add_node();
    if (plans_[0].left_share[0] == as_leaf) {
      cost_ = tree_.nodes[0].bounds.half_area();
      set_child(0, 0, 0, leaf(0));
      out_.depth = 1;
    } else {
      emit();
    }
    const float root_area = tree_.nodes[0].bounds.half_area();
    if (root_area > 0 && std::isfinite(cost_)) out_.sah_cost = cost_ / root_area;
    return std::move(out_);
  }

 private:
  // Of a binary subtree: the least cost of it as at most i + 1 children, and how. left_share[0] is as_leaf, or how many of the
  // wide node's own slots its left side gets; left_share[i] for i > 0 is as_fewer, or the left side's part of i + 1 children.
  static constexpr std::int8_t as_leaf = 0, as_fewer = -1;
  struct Plan {
    std::uint32_t first, count;  // its run of BinaryTree::primitives
    std::array<float, node_width> cost;
    std::array<std::int8_t, node_width> left_share;
  };

  struct Distribution {
    float cost;
    std::int8_t left_share;
  };
  Distribution distribute(std::uint32_t left, int slots) const {
    Distribution best{infinity, 1};  // areas can exceed the range of float
    for (int share = 1; share < slots; ++share) {
      const float cost = plans_[left].cost[share - 1] + plans_[left + 1].cost[slots - share - 1];
      if (cost < best.cost) best = {cost, static_cast<std::int8_t>(share)};
    }
    return best;
  }

  void plan(std::size_t n) {
    const TreeNode& node = tree_.nodes[n];
    Plan& plan = plans_[n];
    const float area = node.bounds.half_area();
    if (node.is_leaf()) {
      plan.first = node.first;
      plan.count = node.count;
      const std::uint32_t packs = (node.count + pack_width - 1) / pack_width;
      plan.cost.fill(area * leaf_cost_ * static_cast<float>(packs));
      plan.left_share.fill(as_fewer);
      plan.left_share[0] = as_leaf;
      return;
    }
    plan.first = plans_[node.first].first;
    plan.count = plans_[node.first].count + plans_[node.first + 1].count;
    const Distribution as_node = distribute(node.first, node_width);
    plan.cost[0] = area + as_node.cost;
    plan.left_share[0] = as_node.left_share;
    if (plan.count <= leaf_size_ && area * leaf_cost_ <= plan.cost[0]) {
      plan.cost[0] = area * leaf_cost_;
      plan.left_share[0] = as_leaf;
    }
    for (int i = 1; i < node_width; ++i) {
      const Distribution split = distribute(node.first, i + 1);
      const bool better = split.cost < plan.cost[i - 1];
      plan.cost[i] = better ? split.cost : plan.cost[i - 1];
      plan.left_share[i] = better ? split.left_share : as_fewer;
    }
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
      while (i > 1 && plans_[node].left_share[i - 1] == as_fewer) --i;
      if (i == 1) {
        roots.push_back(node);
        continue;
      }
      const int left = plans_[node].left_share[i - 1];
      parts[size++] = {tree_.nodes[node].first + 1, i - left};
      parts[size++] = {tree_.nodes[node].first, left};
    }
  }

  std::uint32_t add_node() {
    WideNode<node_width>& node = out_.nodes.emplace_back();
    for (int plane = 0; plane < 6; ++plane) std::fill_n(node.planes[plane], node_width, plane % 2 == 0 ? infinity : -infinity);
    std::fill_n(node.children, node_width, WideRef(WideRef::Kind::node, 0));
    return static_cast<std::uint32_t>(out_.nodes.size() - 1);
  }

  void set_child(std::uint32_t at, int slot, std::uint32_t binary, WideRef child) {
    WideNode<node_width>& node = out_.nodes[at];
    const Bounds& b = tree_.nodes[binary].bounds;
    for (int axis = 0; axis < 3; ++axis) {
      node.planes[2 * axis][slot] = b.lower[axis];
      node.planes[2 * axis + 1][slot] = b.upper[axis];
    }
    node.children[slot] = child;
  }

  // All wide nodes, depth first.
  void emit() {
    struct Job {
      std::uint32_t at, binary, depth;
    };
    std::vector<Job> jobs{{0, 0, 1}};
    std::vector<std::uint32_t> roots;
    while (!jobs.empty()) {
      const Job job = jobs.back();
      jobs.pop_back();
      cost_ += tree_.nodes[job.binary].bounds.half_area();
      out_.depth = std::max(out_.depth, job.depth);
      const int left_share = plans_[job.binary].left_share[0];
      const std::uint32_t left = tree_.nodes[job.binary].first;
      roots.clear();
      append_roots(left, left_share, roots);
      append_roots(left + 1, node_width - left_share, roots);
      std::stable_sort(roots.begin(), roots.end(), [&](std::uint32_t a, std::uint32_t b) {
        return tree_.nodes[a].bounds.half_area() > tree_.nodes[b].bounds.half_area();
      });
      const std::size_t waiting = jobs.size();
      for (std::size_t slot = 0; slot < roots.size(); ++slot) {
        const std::uint32_t root = roots[slot];
        if (plans_[root].left_share[0] == as_leaf) {
          set_child(job.at, static_cast<int>(slot), root, leaf(root));
        } else {
          const std::uint32_t child = add_node();
          set_child(job.at, static_cast<int>(slot), root, {WideRef::Kind::node, child});
          jobs.push_back({child, root, job.depth + 1});
        }
      }
      std::reverse(jobs.begin() + static_cast<std::ptrdiff_t>(waiting), jobs.end());
    }
  }

  WideRef leaf(std::uint32_t binary) {
    const Plan& plan = plans_[binary];
    ids_.assign(tree_.primitives.begin() + plan.first, tree_.primitives.begin() + plan.first + plan.count);
    std::sort(ids_.begin(), ids_.end());
    cost_ += static_cast<double>(plan.count) * tree_.nodes[binary].bounds.half_area();
    if (plan.count > pack_width || !geometry_.is_triangle(ids_.back())) {
      out_.lists.push_back({static_cast<std::uint32_t>(out_.list_ids.size()), plan.count});
      out_.list_ids.insert(out_.list_ids.end(), ids_.begin(), ids_.end());
      return {WideRef::Kind::list, static_cast<std::uint32_t>(out_.lists.size() - 1)};
    }
    TrianglePack<pack_width>& pack = out_.packs.emplace_back();
    std::fill_n(&pack.vertices[0][0][0], 9 * pack_width, std::numeric_limits<float>::quiet_NaN());
    std::fill_n(pack.ids, pack_width, no_id);
    for (std::uint32_t lane = 0; lane < plan.count; ++lane) {
      pack.ids[lane] = ids_[lane];
      const uvec3& corners = geometry_.triangles[ids_[lane]];
      for (int vertex = 0; vertex < 3; ++vertex)
        for (int axis = 0; axis < 3; ++axis) pack.vertices[vertex][axis][lane] = geometry_.positions[corners[vertex]][axis];
    }
    return {WideRef::Kind::pack, static_cast<std::uint32_t>(out_.packs.size() - 1)};
  }

  const Geometry& geometry_;
  const BinaryTree& tree_;
  const std::uint32_t leaf_size_;
  const float leaf_cost_;
  std::vector<Plan> plans_;
  double cost_ = 0;                 // of the wide tree, times the root's area
  std::vector<std::uint32_t> ids_;  // of the leaf in hand, ascending
  Tree out_;
};

}  // namespace

template <int node_width, int pack_width>
WideTree<node_width, pack_width> collapse(const Geometry& geometry, const BinaryTree& tree, const CollapseOptions& options) {
  return Collapse<node_width, pack_width>(geometry, tree, options).run();
}

template WideTree<4, 4> collapse(const Geometry&, const BinaryTree&, const CollapseOptions&);
template WideTree<8, 8> collapse(const Geometry&, const BinaryTree&, const CollapseOptions&);
template WideTree<16, 8> collapse(const Geometry&, const BinaryTree&, const CollapseOptions&);

}  // namespace etendue
