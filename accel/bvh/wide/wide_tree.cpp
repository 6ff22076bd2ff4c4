#include "accel/bvh/wide/wide_tree.h"

#include "accel/bvh/wide/collapse_plan.h"
#include "accel/bvh/wide/fill_pack.h"
#include "accel/kernels/ranks.h"
#include "framework/core/check.h"

#include <algorithm>
#include <array>
#include <bit>
#include <memory>

namespace etendue {

namespace {

template <int node_width, class Pack>
class Collapse {
 public:
  using Tree = WideTree<node_width, Pack>;

  Collapse(const Geometry& geometry, const BinaryTree& tree, const LeafContents& contents, const CollapseOptions& options)
      : geometry_(&geometry), tree_(tree), plan_(geometry, tree, contents, options) {}
  explicit Collapse(PackTree<Pack>& packs) : ready_(&packs), tree_(packs.tree), plan_(packs) {}

  Tree run() {
    if (plan_.is_leaf(0)) {
      Piece root;
      root.cost = tree_.nodes[0].bounds.half_area();
      root.depth = 1;
      add_node(root);
      set_child(root.nodes[0], 0, 0, leaf(root, 0));
      join(root, {}, {});
    } else {
      emit();
    }
    if (ready_ != nullptr)
      out_.packs = std::move(ready_->packs);
    else
      fill_packs();
    return std::move(out_);
  }

 private:
  using Node = WideNode<node_width>;

  struct Job {
    std::uint32_t at, binary, depth;  // `at` in its piece
  };

  // Wide nodes that one thread makes, depth first, numbered within the piece; the first is its root.
  struct Piece {
    std::vector<Node> nodes;
    std::vector<std::uint32_t> packs, lists;  // the binary nodes whose primitives they hold
    double cost = 0;                          // of nodes and leaves, times the root's area
    std::uint32_t depth = 0;
    // In the tree: of what follows the piece's root, and of its leaves.
    std::uint32_t next_node = 1, first_pack = 0, first_list = 0;
  };

  // Primitives, at most, of a subtree that is a piece of its own.
  std::uint32_t task_size() const { return ready_ != nullptr ? 8192 / 8 : 8192; }

  // The upper nodes, then the subtrees below them.
  void emit() {
    Piece top;
    std::vector<Job> roots;
    add_node(top);
    emit(top, {0, 0, 1}, &roots);
    std::vector<Piece> below(roots.size());
    parallel_for(roots.size(), 1, [&](std::size_t i) {
      const std::size_t count = plan_.count(roots[i].binary);
      below[i].nodes.reserve(ready_ != nullptr ? count / (node_width / 2) + 1 : count / (3 * node_width) + 1);
      if (ready_ == nullptr) below[i].packs.reserve(count / 4 + 1);
      add_node(below[i]);
      emit(below[i], {0, roots[i].binary, roots[i].depth}, nullptr);
    });
    join(top, roots, below);
  }

  // What is small goes to `tasks` where there are any.
  void emit(Piece& piece, const Job& root, std::vector<Job>* tasks) const {
    std::vector<Job> jobs{root};
    std::vector<std::uint32_t> children;
    while (!jobs.empty()) {
      const Job job = jobs.back();
      jobs.pop_back();
      if (tasks != nullptr && plan_.count(job.binary) <= task_size()) {
        tasks->push_back(job);
        continue;
      }
      piece.cost += tree_.nodes[job.binary].bounds.half_area();
      piece.depth = std::max(piece.depth, job.depth);
      plan_.children(job.binary, children);
      sort_by_any_hit_priority(children);
      const std::size_t waiting = jobs.size();
      for (std::size_t slot = 0; slot < children.size(); ++slot) {
        const std::uint32_t binary = children[slot];
        if (plan_.is_leaf(binary)) {
          set_child(piece.nodes[job.at], slot, binary, leaf(piece, binary));
        } else {
          const std::uint32_t child = add_node(piece);
          set_child(piece.nodes[job.at], slot, binary, {WideRef::Kind::node, child});
          jobs.push_back({child, binary, job.depth + 1});
        }
      }
      std::reverse(jobs.begin() + static_cast<std::ptrdiff_t>(waiting), jobs.end());
    }
  }

  static std::uint32_t add_node(Piece& piece) {
    Node& node = piece.nodes.emplace_back();
    for (int plane = 0; plane < 6; ++plane) std::fill_n(node.planes[plane], node_width, plane < 3 ? infinity : -infinity);
    std::fill_n(node.children, node_width, WideRef::none());
    return static_cast<std::uint32_t>(piece.nodes.size() - 1);
  }

  void set_child(Node& node, std::size_t slot, std::uint32_t binary, WideRef child) const {
    const Bounds& b = tree_.nodes[binary].bounds;
    for (int axis = 0; axis < 3; ++axis) {
      node.planes[axis][slot] = b.lower[axis];
      node.planes[3 + axis][slot] = b.upper[axis];
    }
    node.children[slot] = child;
  }

  // Children whose priorities differ in their last bits only stay in order.
  void sort_by_any_hit_priority(std::vector<std::uint32_t>& children) const {
    static_assert(node_width <= Ranks::most);
    std::array<std::uint32_t, node_width> keys, unsorted;
    for (std::uint32_t i = 0; i < children.size(); ++i) {
      keys[i] =
          (std::bit_cast<std::uint32_t>(plan_.any_hit_priority(children[i])) & ~(node_width - 1u)) | i;  // none is negative
      unsorted[i] = children[i];
    }
    const Ranks ranks(keys.data(), children.size());
    for (std::uint32_t i = 0; i < children.size(); ++i) children[ranks[i]] = unsorted[i];
  }

  WideRef leaf(Piece& piece, std::uint32_t binary) const {
    piece.cost += static_cast<double>(primitives(binary)) * tree_.nodes[binary].bounds.half_area();
    if (ready_ != nullptr) return {WideRef::Kind::pack, tree_.nodes[binary].first};
    const bool is_pack = plan_.is_pack(binary);
    std::vector<std::uint32_t>& leaves = is_pack ? piece.packs : piece.lists;
    leaves.push_back(binary);
    return {is_pack ? WideRef::Kind::pack : WideRef::Kind::list, static_cast<std::uint32_t>(leaves.size() - 1)};
  }
  // The number of primitives of a leaf.
  std::size_t primitives(std::uint32_t binary) const {
    return ready_ != nullptr ? ready_->counts[tree_.nodes[binary].first] : plan_.count(binary);
  }

  // The pieces one after the other; the root of each below the top has its place there.
  void join(Piece& top, std::span<const Job> roots, std::span<Piece> below) {
    std::size_t nodes = top.nodes.size(), packs = top.packs.size(), lists = top.lists.size();
    for (Piece& piece : below) {
      piece.next_node = static_cast<std::uint32_t>(nodes);
      piece.first_pack = static_cast<std::uint32_t>(packs);
      piece.first_list = static_cast<std::uint32_t>(lists);
      nodes += piece.nodes.size() - 1;
      packs += piece.packs.size();
      lists += piece.lists.size();
      top.cost += piece.cost;
      top.depth = std::max(top.depth, piece.depth);
    }
    CHECK_LT(std::max({nodes, packs, lists}), std::size_t{1} << 30);  // what a WideRef can name
    out_.nodes.resize(nodes);
    packed_.resize(packs);
    copy(top, 0);
    parallel_for(below.size(), 1, [&](std::size_t i) { copy(below[i], roots[i].at); });
    for (const std::uint32_t binary : top.lists) add_list(binary);
    for (const Piece& piece : below)
      for (const std::uint32_t binary : piece.lists) add_list(binary);
    out_.depth = top.depth;
    const float root_area = tree_.nodes[0].bounds.half_area();
    if (root_area > 0 && std::isfinite(top.cost)) out_.sah_cost = top.cost / root_area;
  }

  void copy(const Piece& piece, std::uint32_t root) {
    for (std::size_t i = 0; i < piece.nodes.size(); ++i) {
      Node node = piece.nodes[i];
      for (WideRef& child : node.children) child = moved(child, piece);
      std::construct_at(&out_.nodes[i == 0 ? root : piece.next_node + i - 1], node);
    }
    std::copy(piece.packs.begin(), piece.packs.end(), packed_.begin() + piece.first_pack);
  }

  static WideRef moved(WideRef child, const Piece& piece) {
    if (child.is_none()) return child;
    if (child.is_pack()) return {WideRef::Kind::pack, piece.first_pack + child.index()};
    if (child.is_leaf()) return {WideRef::Kind::list, piece.first_list + child.index()};
    return {WideRef::Kind::node, piece.next_node + child.index() - 1};
  }

  void add_list(std::uint32_t binary) {
    const auto run = plan_.primitives(binary);
    std::vector<std::uint32_t> ids(run.begin(), run.end());
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    out_.lists.push_back({static_cast<std::uint32_t>(out_.list_ids.size()), static_cast<std::uint32_t>(ids.size())});
    out_.list_ids.insert(out_.list_ids.end(), ids.begin(), ids.end());
  }

  void fill_packs() {
    out_.packs.resize(packed_.size());
    const std::size_t last = packed_.size() - 1;
    parallel_for(packed_.size(), 32, [&](std::size_t i) {
      plan_.prefetch(packed_[std::min(i + 8, last)]);
      prefetch_vertices(packed_[std::min(i + 2, last)]);
      fill_pack(*std::construct_at(&out_.packs[i]), *geometry_, plan_.primitives(packed_[i]), plan_.corners(packed_[i]));
    });
  }

  // This is always inlined, since GCC leaves out a call that has no other effect.
  [[gnu::always_inline]] void prefetch_vertices(std::uint32_t binary) const {
    for (const uvec3& triangle : plan_.corners(binary))
      for (int corner = 0; corner < 3; ++corner) __builtin_prefetch(&geometry_->positions[triangle[corner]]);
  }

  const Geometry* geometry_ = nullptr;  // whose primitives the leaves hold; or, these packs:
  PackTree<Pack>* ready_ = nullptr;
  const BinaryTree& tree_;
  const CollapsePlan<node_width, Pack> plan_;
  std::vector<std::uint32_t> packed_;  // by pack: the binary node whose primitives it holds
  Tree out_;
};

}  // namespace

template <int node_width, class Pack>
WideTree<node_width, Pack> collapse(const VertexIds& vertices, const BinaryTree& tree, const CollapseOptions& options) {
  if (tree.nodes.empty()) return {};
  const LeafContents contents = LeafContents::of(vertices, tree);
  return Collapse<node_width, Pack>(vertices.geometry(), tree, contents, options).run();
}

template <int node_width, class Pack>
WideTree<node_width, Pack> collapse(PackTree<Pack>&& packs) {
  if (packs.tree.nodes.empty()) return {};
  return Collapse<node_width, Pack>(packs).run();
}

template WideTree<4, TrianglePack<4>> collapse(const VertexIds&, const BinaryTree&, const CollapseOptions&);
template WideTree<8, TrianglePack<8>> collapse(const VertexIds&, const BinaryTree&, const CollapseOptions&);
template WideTree<16, SharedPack> collapse(const VertexIds&, const BinaryTree&, const CollapseOptions&);
template WideTree<4, TrianglePack<4>> collapse(PackTree<TrianglePack<4>>&&);
template WideTree<8, TrianglePack<8>> collapse(PackTree<TrianglePack<8>>&&);
template WideTree<16, SharedPack> collapse(PackTree<SharedPack>&&);

}  // namespace etendue
