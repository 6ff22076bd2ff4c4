#include "accel/ray/wide_tree.h"

#include "accel/ray/collapse_plan.h"

#include <array>

namespace etendue {

namespace {

template <int node_width, class Pack>
class Collapse {
 public:
  using Tree = WideTree<node_width, Pack>;

  Collapse(const Geometry& geometry, const BinaryTree& tree, const LeafContents& contents, const CollapseOptions& options)
      : geometry_(geometry), contents_(contents), tree_(tree), plan_(geometry, tree, contents, options) {}

  Tree run() {
    out_.nodes.reserve(tree_.primitives.size() / (4 * node_width) + 1);
    add_node();
    if (plan_.is_leaf(0)) {
      cost_ = tree_.nodes[0].bounds.half_area();
      set_child(0, 0, 0, leaf(0));
      out_.depth = 1;
    } else {
      emit();
    }
    fill_packs();
    const float root_area = tree_.nodes[0].bounds.half_area();
    if (root_area > 0 && std::isfinite(cost_)) out_.sah_cost = cost_ / root_area;
    return std::move(out_);
  }

 private:
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
    std::vector<std::uint32_t> children;
    while (!jobs.empty()) {
      const Job job = jobs.back();
      jobs.pop_back();
      cost_ += tree_.nodes[job.binary].bounds.half_area();
      out_.depth = std::max(out_.depth, job.depth);
      plan_.children(job.binary, children);
      sort_by_promise(children);
      const std::size_t waiting = jobs.size();
      for (std::size_t slot = 0; slot < children.size(); ++slot) {
        const std::uint32_t binary = children[slot];
        if (plan_.is_leaf(binary)) {
          set_child(job.at, static_cast<int>(slot), binary, leaf(binary));
        } else {
          const std::uint32_t child = add_node();
          set_child(job.at, static_cast<int>(slot), binary, {WideRef::Kind::node, child});
          jobs.push_back({child, binary, job.depth + 1});
        }
      }
      std::reverse(jobs.begin() + static_cast<std::ptrdiff_t>(waiting), jobs.end());
    }
  }

  void sort_by_promise(std::vector<std::uint32_t>& children) {
    keys_.clear();
    for (const std::uint32_t n : children) keys_.emplace_back(plan_.promise(n), n);
    std::sort(keys_.begin(), keys_.end());
    std::transform(keys_.begin(), keys_.end(), children.begin(), [](const auto& key) { return key.second; });
  }

  WideRef leaf(std::uint32_t binary) {
    const auto run = plan_.primitives(binary);
    cost_ += static_cast<double>(run.size()) * tree_.nodes[binary].bounds.half_area();
    if (plan_.is_pack(binary)) {
      packed_.push_back(binary);
      return {WideRef::Kind::pack, static_cast<std::uint32_t>(packed_.size() - 1)};
    }
    std::vector<std::uint32_t> ids(run.begin(), run.end());
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    out_.lists.push_back({static_cast<std::uint32_t>(out_.list_ids.size()), static_cast<std::uint32_t>(ids.size())});
    out_.list_ids.insert(out_.list_ids.end(), ids.begin(), ids.end());
    return {WideRef::Kind::list, static_cast<std::uint32_t>(out_.lists.size() - 1)};
  }

  void fill_packs() {
    out_.packs.resize(packed_.size());
    const std::size_t last = packed_.size() - 1;
    parallel_for(packed_.size(), 256, [&](std::size_t i) {
      plan_.prefetch(packed_[std::min(i + 8, last)]);
      prefetch_vertices(packed_[std::min(i + 2, last)]);
      fill(out_.packs[i], packed_[i]);
    });
  }

  // (GCC leaves a call out that has no other effect.)
  [[gnu::always_inline]] void prefetch_vertices(std::uint32_t binary) const {
    for (const uvec3& triangle : plan_.corners(binary))
      for (int corner = 0; corner < 3; ++corner) __builtin_prefetch(&geometry_.positions[triangle[corner]]);
  }

  void fill(Pack& pack, std::uint32_t binary) {
    if constexpr (std::is_same_v<Pack, SharedPack>)
      if (contents_.repeats)
        return contents_.repeats.fill(pack, geometry_, plan_.primitives(binary), plan_.corners(binary),
                                      &plan_.corners(binary)[0] - &contents_.corners[0]);
    fill_sorted(pack, binary);
  }

  // By rising id and each once: a primitive that was cut in parts may have come together again.
  void fill_sorted(Pack& pack, std::uint32_t binary) {
    const auto run = plan_.primitives(binary);
    const auto corners = plan_.corners(binary);
    std::array<std::uint32_t, Pack::lanes> ids;
    std::array<uvec3, Pack::lanes> triangles;
    std::size_t count = 0;
    for (std::size_t i = 0; i < run.size(); ++i) {
      std::size_t place = count;
      while (place > 0 && ids[place - 1] > run[i]) --place;
      if (place > 0 && ids[place - 1] == run[i]) continue;
      for (std::size_t j = count++; j > place; --j) {
        ids[j] = ids[j - 1];
        triangles[j] = triangles[j - 1];
      }
      ids[place] = run[i];
      triangles[place] = corners[i];
    }
    pack.fill(geometry_, std::span(ids).first(count), std::span(triangles).first(count));
  }

  const Geometry& geometry_;
  const LeafContents& contents_;
  const BinaryTree& tree_;
  const CollapsePlan<node_width, Pack> plan_;
  double cost_ = 0;                                    // of the wide tree, times the root's area
  std::vector<std::pair<float, std::uint32_t>> keys_;  // of sort_by_promise
  std::vector<std::uint32_t> packed_;                  // by pack: the binary node whose primitives it holds
  Tree out_;
};

}  // namespace

template <int node_width, class Pack>
WideTree<node_width, Pack> collapse(const VertexIds& vertices, const BinaryTree& tree, const CollapseOptions& options) {
  return collapse<node_width, Pack>(vertices.geometry(), tree, LeafContents::of(vertices, tree), options);
}

template <int node_width, class Pack>
WideTree<node_width, Pack> collapse(const Geometry& geometry, const BinaryTree& tree, const LeafContents& contents,
                                    const CollapseOptions& options) {
  if (tree.nodes.empty()) return {};
  return Collapse<node_width, Pack>(geometry, tree, contents, options).run();
}

template WideTree<4, TrianglePack<4>> collapse(const VertexIds&, const BinaryTree&, const CollapseOptions&);
template WideTree<8, TrianglePack<8>> collapse(const VertexIds&, const BinaryTree&, const CollapseOptions&);
template WideTree<16, SharedPack> collapse(const VertexIds&, const BinaryTree&, const CollapseOptions&);
template WideTree<4, TrianglePack<4>> collapse(const Geometry&, const BinaryTree&, const LeafContents&, const CollapseOptions&);
template WideTree<8, TrianglePack<8>> collapse(const Geometry&, const BinaryTree&, const LeafContents&, const CollapseOptions&);
template WideTree<16, SharedPack> collapse(const Geometry&, const BinaryTree&, const LeafContents&, const CollapseOptions&);

}  // namespace etendue
