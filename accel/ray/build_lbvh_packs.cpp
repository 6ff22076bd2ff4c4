#include "accel/ray/build_lbvh_packs.h"

#include "accel/ray/four_floats.h"
#include "accel/ray/grow_tree.h"
#include "accel/ray/morton_order.h"
#include "accel/ray/wide_tree.h"

#include <atomic>
#include <bit>

namespace etendue {

namespace {

// The centre of a triangle's box, if Geometry::is_valid.
inline MortonPoint centre_of(const Geometry& geometry, std::uint32_t triangle) {
  const uvec3 soon = geometry.triangles[std::min<std::size_t>(triangle + 16, geometry.triangles.size() - 1)];
  for (int corner = 0; corner < 3; ++corner) __builtin_prefetch(&geometry.positions[soon[corner]]);
  const uvec3 v = geometry.triangles[triangle];
  const FourFloats a = four(geometry.positions[v.x]), b = four(geometry.positions[v.y]), c = four(geometry.positions[v.z]);
  const FourFloats lower = smaller(smaller(a, b), c) + 0.0f, upper = larger(larger(a, b), c) + 0.0f;
  const FourFloats centre = 0.5f * lower + 0.5f * upper;
  // What is clearly not empty, and finite, single precision tells.
  const FourFloats ab = b - a, ac = c - a, normal = cross(ab, ac);
  const float square = dot(normal, normal);
  const bool is_plain = square > 1e-30f && square < infinity && square > 1e-10f * dot(ab, ab) * dot(ac, ac);
  return {{centre[0], centre[1], centre[2]}, is_plain || geometry.is_valid(triangle)};
}

template <class Pack>
class PackCutter {
 public:
  PackCutter(const Geometry& geometry, const TreeLimits& limits)
      : geometry_(geometry),
        limits_(limits),
        order_(geometry.triangles.size(), [&](std::size_t i) { return centre_of(geometry, static_cast<std::uint32_t>(i)); }),
        contents_(LeafContents::uninitialised(order_.size())) {
    tree_.primitives.resize(order_.size());
    if constexpr (shares_vertices) contents_.repeats = CornerRepeats(order_.size());
  }

  std::optional<PackTree> run() {
    if (order_.size() == 0) return PackTree();
    cut_top();
    parallel_for(parts_.size(), 1, [&](std::size_t i) { cut_part(parts_[i]); });
    if (!all_are_packs_) return std::nullopt;
    join_parts();
    return PackTree{std::move(tree_), std::move(contents_)};
  }

 private:
  static constexpr std::uint32_t part_size = 4096;
  static constexpr bool shares_vertices = std::is_same_v<Pack, SharedPack>;

  struct Job {
    std::uint32_t begin, end, depth;
    std::uint32_t node;

    std::uint32_t size() const { return end - begin; }
  };

  // A subtree, cut by one thread: its nodes depth first, a pair of children at a time.
  struct Part {
    Job root;
    std::vector<TreeNode> nodes;
    std::uint32_t depth = 0;
  };

  // False where the node is to be a leaf.
  bool may_split(const Job& job) const {
    return job.size() > static_cast<std::uint32_t>(limits_.leaf_size) && static_cast<int>(job.depth) < limits_.max_depth;
  }
  // The corners of a leaf that is a pack: where vertices are shared, one for each vertex. A bit per corner.
  std::optional<std::uint64_t> corners_of_pack(const Job& job, std::uint32_t end_of_part) const {
    if (job.size() > Pack::lanes) return std::nullopt;
    if constexpr (shares_vertices) {
      const std::uint64_t first = contents_.repeats.first_seen(job.begin, job.size(), end_of_part);
      return std::popcount(first) <= Pack::slots ? std::optional(first) : std::nullopt;
    }
    return (std::uint64_t{1} << 3 * job.size()) - 1;
  }

  // Replaces a job by those of its two sides, the right one first.
  void split(std::vector<TreeNode>& nodes, std::vector<Job>& jobs, const Job& job) const {
    const std::uint32_t middle =
        must_halve(job.size(), job.depth, limits_) ? job.begin + job.size() / 2 : order_.cut(job.begin, job.end);
    const auto first = static_cast<std::uint32_t>(nodes.size());
    nodes[job.node].first = first;
    nodes.resize(first + 2);
    jobs.push_back({middle, job.end, job.depth + 1, first + 1});
    jobs.push_back({job.begin, middle, job.depth + 1, first});
  }

  // The nodes above the parts.
  void cut_top() {
    std::vector<Job> jobs{{0, order_.size(), 0, 0}};
    top_.resize(1);
    while (!jobs.empty()) {
      const Job job = jobs.back();
      jobs.pop_back();
      if (job.size() <= part_size || !may_split(job)) {
        top_[job.node].count = static_cast<std::uint32_t>(parts_.size()) + 1;
        parts_.push_back({job, {}});
      } else {
        split(top_, jobs, job);
      }
    }
  }

  void cut_part(Part& part) {
    visit(part.root);
    std::vector<TreeNode>& nodes = part.nodes;
    nodes.reserve(part.root.size() / 2);
    nodes.resize(1);
    std::vector<Job> jobs{part.root};
    jobs.back().node = 0;
    while (!jobs.empty()) {
      const Job job = jobs.back();
      jobs.pop_back();
      const std::optional<std::uint64_t> corners = corners_of_pack(job, part.root.end);
      if (!corners && may_split(job)) {
        split(nodes, jobs, job);
        continue;
      }
      if (!corners) all_are_packs_ = false;
      nodes[job.node] = {bounds(job, corners.value_or(0)), job.begin, job.size()};
      part.depth = std::max(part.depth, job.depth);
    }
    unite(nodes, nodes);
  }

  // Boxes of inner nodes, children before parents.
  static void unite(std::vector<TreeNode>& nodes, const std::vector<TreeNode>& children) {
    for (std::size_t n = nodes.size(); n-- > 0;)
      if (TreeNode& node = nodes[n]; !node.is_leaf())
        node.bounds = united(children[node.first].bounds, children[node.first + 1].bounds);
  }

  // Each triangle of a part once, in order.
  void visit(const Job& job) {
    std::optional<CornerRepeats::Scan> scan;
    if constexpr (shares_vertices) scan.emplace(contents_.repeats, job.begin);
    for (std::uint32_t i = job.begin; i < job.end; ++i) {
      prefetch(i);
      const std::uint32_t id = tree_.primitives[i] = order_.index(i);
      const uvec3 v = contents_.corners[i] = geometry_.triangles[id];
      const vec3 &a = geometry_.positions[v.x], &b = geometry_.positions[v.y], &c = geometry_.positions[v.z];
      const FourFloats normal = cross(four(b) - four(a), four(c) - four(a));
      contents_.areas[i] = 0.5f * std::sqrt(dot(normal, normal));
      if constexpr (shares_vertices) {
        scan->add(a);
        scan->add(b);
        scan->add(c);
      }
    }
  }

  // What is visited soon lies anywhere. Inline always: GCC leaves a call out that has no other effect.
  [[gnu::always_inline]] void prefetch(std::uint32_t i) const {
    const std::uint32_t last = order_.size() - 1;
    __builtin_prefetch(&geometry_.triangles[order_.index(std::min(i + 32, last))]);
    const uvec3& v = geometry_.triangles[order_.index(std::min(i + 16, last))];
    for (int corner = 0; corner < 3; ++corner) __builtin_prefetch(&geometry_.positions[v[corner]]);
  }

  // Around some corners of a run.
  Bounds bounds(const Job& job, std::uint64_t corners) const {
    const std::uint32_t* const vertices = &contents_.corners[job.begin].x;
    FourFloats lower = FourFloats{} + infinity, upper = -lower;
    for (; corners != 0; corners &= corners - 1) {
      const FourFloats p = four(geometry_.positions[vertices[std::countr_zero(corners)]]);
      lower = smaller(p, lower);
      upper = larger(p, upper);
    }
    lower += 0.0f;  // no negative zero (build_items)
    upper += 0.0f;
    return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
  }

  // All nodes depth first. In `top_`, what has a count stands for a part.
  void join_parts() {
    std::size_t size = top_.size();
    for (const Part& part : parts_) size += part.nodes.size() - 1;
    tree_.nodes.reserve(size);
    tree_.nodes.push_back(top_[0]);
    std::vector<std::uint32_t> places{0}, inner;
    while (!places.empty()) {
      const std::uint32_t place = places.back();
      places.pop_back();
      const auto next = static_cast<std::uint32_t>(tree_.nodes.size());
      const TreeNode from = tree_.nodes[place];
      if (from.count == 0) {
        tree_.nodes[place].first = next;
        tree_.nodes.insert(tree_.nodes.end(), {top_[from.first], top_[from.first + 1]});
        places.insert(places.end(), {next + 1, next});
        inner.push_back(place);
        continue;
      }
      const Part& part = parts_[from.count - 1];
      tree_.depth = std::max(tree_.depth, part.depth);
      const auto moved = [&](TreeNode node) {
        if (!node.is_leaf()) node.first += next - 1;
        return node;
      };
      tree_.nodes[place] = moved(part.nodes[0]);
      for (std::size_t n = 1; n < part.nodes.size(); ++n) tree_.nodes.push_back(moved(part.nodes[n]));
    }
    for (std::size_t i = inner.size(); i-- > 0;) {
      TreeNode& node = tree_.nodes[inner[i]];
      node.bounds = united(tree_.nodes[node.first].bounds, tree_.nodes[node.first + 1].bounds);
    }
  }

  const Geometry& geometry_;
  const TreeLimits limits_;
  const MortonOrder order_;
  LeafContents contents_;
  BinaryTree tree_;
  std::vector<TreeNode> top_;
  std::vector<Part> parts_;
  std::atomic<bool> all_are_packs_ = true;
};

}  // namespace

template <class Pack>
std::optional<PackTree> build_lbvh_packs(const Geometry& geometry, const TreeLimits& limits) {
  if (!geometry.quadrics.empty()) return std::nullopt;
  return PackCutter<Pack>(geometry, limits).run();
}

template std::optional<PackTree> build_lbvh_packs<TrianglePack<4>>(const Geometry&, const TreeLimits&);
template std::optional<PackTree> build_lbvh_packs<TrianglePack<8>>(const Geometry&, const TreeLimits&);
template std::optional<PackTree> build_lbvh_packs<SharedPack>(const Geometry&, const TreeLimits&);

}  // namespace etendue
