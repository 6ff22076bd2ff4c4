#include "accel/ray/wide_tree.h"

#include <algorithm>
#include <array>
#include <bit>

namespace etendue {

// A closed mesh has half as many vertices as triangles. Where there are clearly more, some may be copies, which are looked for
// in an open hash table.
VertexIds::VertexIds(const Geometry& geometry) : geometry_(&geometry) {
  const std::size_t count = geometry.positions.size();
  if (count < 0.6 * static_cast<double>(geometry.triangles.size())) return;
  const std::size_t size = std::bit_ceil(2 * count);
  std::vector<std::uint32_t> table(size, no_id);
  first_equal_.resize(count);
  for (std::uint32_t vertex = 0; vertex < count; ++vertex) {
    const auto bits = std::bit_cast<std::array<std::uint32_t, 3>>(geometry.positions[vertex]);
    std::uint64_t hash = bits[0] * 0x9e3779b97f4a7c15u;
    hash = ((hash >> 32) ^ bits[1]) * 0x9e3779b97f4a7c15u;
    hash = ((hash >> 32) ^ bits[2]) * 0x9e3779b97f4a7c15u;
    std::size_t slot = (hash >> 20) & (size - 1);
    while (table[slot] != no_id && std::bit_cast<std::array<std::uint32_t, 3>>(geometry.positions[table[slot]]) != bits)
      slot = (slot + 1) & (size - 1);
    if (table[slot] == no_id) table[slot] = vertex;
    first_equal_[vertex] = table[slot];
  }
}

template <int width>
TrianglePack<width>::TrianglePack() {
  std::fill_n(&vertices[0][0][0], 9 * width, std::numeric_limits<float>::quiet_NaN());
  std::fill_n(ids, width, no_id);
}

template <int width>
void TrianglePack<width>::fill(const VertexIds& vertex_ids, std::span<const std::uint32_t> triangles) {
  for (std::size_t lane = 0; lane < triangles.size(); ++lane) {
    ids[lane] = triangles[lane];
    for (int corner = 0; corner < 3; ++corner)
      for (int axis = 0; axis < 3; ++axis)
        vertices[corner][axis][lane] = vertex_ids.geometry().positions[vertex_ids(triangles[lane], corner)][axis];
  }
}

namespace {

// The different vertices of a few triangles.
class VertexSet {
 public:
  static constexpr std::size_t most = SharedPack::slots;

  // The slot of a vertex, which is added if there is room; `most` if there is none.
  std::size_t slot(std::uint32_t vertex) {
    std::size_t i = 0;
    while (i < size_ && vertices_[i] != vertex) ++i;
    if (i == size_ && size_ < most) vertices_[size_++] = vertex;
    return i;
  }
  std::size_t size() const { return size_; }
  std::uint32_t operator[](std::size_t i) const { return vertices_[i]; }

 private:
  std::array<std::uint32_t, most> vertices_;
  std::size_t size_ = 0;
};

}  // namespace

SharedPack::SharedPack() {
  std::fill_n(&vertices[0][0], 3 * slots, 0.0f);
  std::fill_n(ids, lanes, no_id);
}

bool SharedPack::fits(const VertexIds& vertex_ids, std::span<const std::uint32_t> triangles) {
  if (triangles.size() > lanes) return false;
  VertexSet set;
  for (const std::uint32_t id : triangles)
    for (int corner = 0; corner < 3; ++corner)
      if (set.slot(vertex_ids(id, corner)) == VertexSet::most) return false;
  return true;
}

void SharedPack::fill(const VertexIds& vertex_ids, std::span<const std::uint32_t> triangles) {
  VertexSet set;
  for (const std::uint32_t id : triangles) {
    ids[count] = id;
    for (int corner = 0; corner < 3; ++corner)
      corners[corner][count] = static_cast<std::uint8_t>(set.slot(vertex_ids(id, corner)));
    ++count;
  }
  for (std::size_t slot = 0; slot < set.size(); ++slot)
    for (int axis = 0; axis < 3; ++axis) vertices[axis][slot] = vertex_ids.geometry().positions[set[slot]][axis];
}

namespace {

template <int node_width, class Pack>
class Collapse {
 public:
  using Tree = WideTree<node_width, Pack>;

  Collapse(const Geometry& geometry, const BinaryTree& tree, const CollapseOptions& options)
      : geometry_(geometry),
        vertices_(geometry),
        tree_(tree),
        leaf_size_(std::min<std::uint32_t>(options.leaf_size, Pack::lanes)),
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
    float content = 0;           // area of its primitives
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
      for (std::uint32_t i = 0; i < node.count; ++i) plan.content += area_of(tree_.primitives[node.first + i]);
      plan.cost.fill(area * leaf_cost(plan));
      if (plan.cost[0] == infinity) plan.cost.fill(area * static_cast<float>(node.count));
      plan.left_share.fill(as_fewer);
      plan.left_share[0] = as_leaf;
      return;
    }
    plan.first = plans_[node.first].first;
    plan.count = plans_[node.first].count + plans_[node.first + 1].count;
    plan.content = plans_[node.first].content + plans_[node.first + 1].content;
    const Distribution as_node = distribute(node.first, node_width);
    plan.cost[0] = area + as_node.cost;
    plan.left_share[0] = as_node.left_share;
    if (const float cost = plan.count <= leaf_size_ ? area * leaf_cost(plan) : infinity; cost <= plan.cost[0]) {
      plan.cost[0] = cost;
      plan.left_share[0] = as_leaf;
    }
    for (int i = 1; i < node_width; ++i) {
      const Distribution split = distribute(node.first, i + 1);
      const bool better = split.cost < plan.cost[i - 1];
      plan.cost[i] = better ? split.cost : plan.cost[i - 1];
      plan.left_share[i] = better ? split.left_share : as_fewer;
    }
  }

  // Of a run of primitives as one leaf, in visits of a node: those of a pack, or one test each of quadrics; infinite for what
  // no leaf should be.
  float leaf_cost(const Plan& plan) const {
    const auto run = std::span(tree_.primitives).subspan(plan.first, plan.count);
    if (geometry_.quadrics.empty() ||
        std::all_of(run.begin(), run.end(), [&](std::uint32_t id) { return geometry_.is_triangle(id); }))
      return Pack::fits(vertices_, run) ? leaf_cost_ : infinity;
    const bool quadrics_only =
        std::none_of(run.begin(), run.end(), [&](std::uint32_t id) { return geometry_.is_triangle(id); });
    return quadrics_only ? static_cast<float>(plan.count) : infinity;
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

  float area_of(std::uint32_t id) const {
    if (!geometry_.is_triangle(id)) return quadric_area(geometry_.quadric(id));
    const uvec3& v = geometry_.triangles[id];
    return 0.5f * glm::length(glm::cross(geometry_.positions[v.y] - geometry_.positions[v.x],
                                         geometry_.positions[v.z] - geometry_.positions[v.x]));
  }
  // The chance that a ray which meets a subtree's box hits something there, over the visits which that takes: what an any-hit
  // query should try first (after [Nah2014]).
  float promise(std::uint32_t n) const {
    const float chance = std::min(tree_.nodes[n].bounds.half_area(), plans_[n].content), visits = plans_[n].cost[0];
    return visits > 0 && visits < infinity ? chance / visits : 0;
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
      std::stable_sort(roots.begin(), roots.end(), [&](std::uint32_t a, std::uint32_t b) { return promise(a) < promise(b); });
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
    ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());  // a primitive that was chopped and put together again
    cost_ += static_cast<double>(ids_.size()) * tree_.nodes[binary].bounds.half_area();
    if (!geometry_.is_triangle(ids_.back()) || !Pack::fits(vertices_, ids_)) {  // quadrics have the highest ids
      out_.lists.push_back({static_cast<std::uint32_t>(out_.list_ids.size()), static_cast<std::uint32_t>(ids_.size())});
      out_.list_ids.insert(out_.list_ids.end(), ids_.begin(), ids_.end());
      return {WideRef::Kind::list, static_cast<std::uint32_t>(out_.lists.size() - 1)};
    }
    out_.packs.emplace_back().fill(vertices_, ids_);
    return {WideRef::Kind::pack, static_cast<std::uint32_t>(out_.packs.size() - 1)};
  }

  const Geometry& geometry_;
  const VertexIds vertices_;
  const BinaryTree& tree_;
  const std::uint32_t leaf_size_;
  const float leaf_cost_;
  std::vector<Plan> plans_;
  double cost_ = 0;                 // of the wide tree, times the root's area
  std::vector<std::uint32_t> ids_;  // of the leaf in hand, ascending
  Tree out_;
};

}  // namespace

template <int node_width, class Pack>
WideTree<node_width, Pack> collapse(const Geometry& geometry, const BinaryTree& tree, const CollapseOptions& options) {
  return Collapse<node_width, Pack>(geometry, tree, options).run();
}

template WideTree<4, TrianglePack<4>> collapse(const Geometry&, const BinaryTree&, const CollapseOptions&);
template WideTree<8, TrianglePack<8>> collapse(const Geometry&, const BinaryTree&, const CollapseOptions&);
template WideTree<16, SharedPack> collapse(const Geometry&, const BinaryTree&, const CollapseOptions&);

}  // namespace etendue
