#include "accel/bvh/wide/lbvh_packs.h"

#include "accel/bvh/build/grow_tree.h"
#include "accel/bvh/build/morton_order.h"
#include "accel/bvh/build/triangle_box.h"
#include "accel/bvh/wide/corner_repeats.h"
#include "accel/bvh/wide/fill_pack.h"
#include "accel/kernels/shared_pack.h"
#include "accel/kernels/triangle_pack.h"

#include <atomic>
#include <bit>
#include <memory>
#include <numeric>

namespace etendue {

namespace {

// The centre of a triangle's box, if Geometry::is_valid.
inline MortonPoint centre_of(const Geometry& geometry, std::uint32_t triangle) {
  const TriangleBox box = triangle_box(geometry, triangle);
  const FourFloats centre = 0.5f * box.lower + 0.5f * box.upper;
  return {{centre[0], centre[1], centre[2]}, box.is_valid};
}

template <class Pack>
class PackCutter {
 public:
  PackCutter(const Geometry& geometry, const TreeLimits& limits)
      : geometry_(geometry),
        limits_(limits),
        order_(geometry.triangles.size(), [&](std::size_t i) { return centre_of(geometry, static_cast<std::uint32_t>(i)); }),
        ids_(uninitialised_on_huge_pages<std::uint32_t>(order_.size())),
        corners_(uninitialised_on_huge_pages<uvec3>(order_.size())),
        areas_(uninitialised_on_huge_pages<float>(order_.size())) {
    if constexpr (shares_vertices) repeats_ = CornerRepeats(order_.size());
  }

  std::optional<PackTree<Pack>> run() {
    if (order_.size() == 0) return PackTree<Pack>();
    cut_top();
    parallel_for(parts_.size(), 1, [&](std::size_t i) { cut_part(parts_[i]); });
    if (!all_are_packs_) return std::nullopt;
    place_parts();
    parallel_for(parts_.size(), 1, [&](std::size_t i) { fill_part(parts_[i]); });
    for (std::size_t i = inner_.size(); i-- > 0;) unite(out_.tree.nodes[inner_[i]], out_.tree.nodes);
    return std::move(out_);
  }

 private:
  static constexpr std::uint32_t part_size = 4096;
  static constexpr std::uint32_t least_filling = std::bit_width(std::uint32_t{Pack::lanes}) - 1;  // of packs on average
  static constexpr bool shares_vertices = std::is_same_v<Pack, SharedPack>;

  struct Job {
    std::uint32_t begin, end, depth;
    std::uint32_t node;

    std::uint32_t size() const { return end - begin; }
  };

  struct Leaf {
    std::uint32_t begin, size;
    std::uint32_t node;     // of its part
    std::uint64_t corners;  // a bit for each that the pack holds: where vertices are shared, the first of each kind
  };

  // A subtree, cut by one thread: its nodes depth first, a pair of children at a time.
  struct Part {
    Job root;
    std::vector<TreeNode> nodes{};
    std::vector<Leaf> leaves{};  // from left to right
    std::uint32_t depth = 0;
    // In the tree: of its root, of the other nodes, and of its leaves' packs.
    std::uint32_t root_place = 0, first_node = 0, first_pack = 0;
  };

  // False where the node is to be a leaf.
  bool may_split(const Job& job) const {
    return job.size() > static_cast<std::uint32_t>(limits_.leaf_size) && static_cast<int>(job.depth) < limits_.max_depth;
  }
  // Leaf::corners of a run that is a pack.
  std::optional<std::uint64_t> corners_of_pack(const Job& job, std::uint32_t end_of_part) const {
    if (job.size() > Pack::lanes) return std::nullopt;
    if constexpr (shares_vertices) {
      const std::uint64_t first = repeats_.first_seen(job.begin, job.size(), end_of_part);
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
        parts_.push_back({.root = job});
      } else {
        split(top_, jobs, job);
      }
    }
  }

  void cut_part(Part& part) {
    visit(part.root);
    std::vector<TreeNode>& nodes = part.nodes;
    const std::size_t leaves = part.root.size() / least_filling;
    nodes.reserve(2 * leaves);
    part.leaves.reserve(leaves);
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
      part.leaves.push_back({job.begin, job.size(), job.node, corners.value_or(0)});
      part.depth = std::max(part.depth, job.depth);
    }
  }

  // Each triangle of a part once, in order.
  void visit(const Job& job) {
    std::optional<CornerRepeats::Scan> scan;
    if constexpr (shares_vertices) scan.emplace(repeats_, job.begin);
    for (std::uint32_t i = job.begin; i < job.end; ++i) {
      prefetch(i);
      const std::uint32_t id = ids_[i] = order_.index(i);
      const uvec3 v = corners_[i] = geometry_.triangles[id];
      const vec3 &a = geometry_.positions[v.x], &b = geometry_.positions[v.y], &c = geometry_.positions[v.z];
      const FourFloats normal = cross(four(b) - four(a), four(c) - four(a));
      areas_[i] = 0.5f * std::sqrt(dot(normal, normal));
      if constexpr (shares_vertices) {
        scan->add(a);
        scan->add(b);
        scan->add(c);
      }
    }
  }

  // What is visited soon may lie anywhere in memory. This is always inlined, since GCC leaves out a call that has no other
  // effect.
  [[gnu::always_inline]] void prefetch(std::uint32_t i) const {
    const std::uint32_t last = order_.size() - 1;
    __builtin_prefetch(&geometry_.triangles[order_.index(std::min(i + 32, last))]);
    const uvec3& v = geometry_.triangles[order_.index(std::min(i + 16, last))];
    for (int corner = 0; corner < 3; ++corner) __builtin_prefetch(&geometry_.positions[v[corner]]);
  }

  // All nodes depth first, all packs from left to right. In `top_`, what has a count stands for a part.
  void place_parts() {
    std::vector<TreeNode>& nodes = out_.tree.nodes;
    std::size_t size = top_.size(), packs = 0;
    for (const Part& part : parts_) {
      size += part.nodes.size() - 1;
      packs += part.leaves.size();
    }
    nodes.resize(size);
    out_.packs.resize(packs);
    out_.counts = uninitialised_on_huge_pages<std::uint8_t>(packs);
    out_.areas = uninitialised_on_huge_pages<float>(packs);
    struct Place {
      std::uint32_t top, node;
    };
    std::vector<Place> places{{0, 0}};
    std::uint32_t next_node = 1, next_pack = 0;
    while (!places.empty()) {
      const Place place = places.back();
      places.pop_back();
      const TreeNode& from = top_[place.top];
      if (from.count == 0) {
        nodes[place.node].first = next_node;
        places.insert(places.end(), {{from.first + 1, next_node + 1}, {from.first, next_node}});
        inner_.push_back(place.node);
        next_node += 2;
        continue;
      }
      Part& part = parts_[from.count - 1];
      part.root_place = place.node;
      part.first_node = next_node;
      part.first_pack = next_pack;
      next_node += static_cast<std::uint32_t>(part.nodes.size() - 1);
      next_pack += static_cast<std::uint32_t>(part.leaves.size());
      out_.tree.depth = std::max(out_.tree.depth, part.depth);
    }
  }

  void fill_part(Part& part) {
    std::uint32_t place = part.first_pack;
    for (const Leaf& leaf : part.leaves) {
      const float* const areas = &areas_[leaf.begin];
      out_.counts[place] = static_cast<std::uint8_t>(leaf.size);
      out_.areas[place] = std::accumulate(areas, areas + leaf.size, 0.0f);
      part.nodes[leaf.node] = {fill(*std::construct_at(&out_.packs[place]), leaf), place, 1};
      ++place;
    }
    for (std::size_t n = part.nodes.size(); n-- > 0;) {
      TreeNode& node = part.nodes[n];
      unite(node, part.nodes);
      TreeNode& placed = out_.tree.nodes[n == 0 ? part.root_place : part.first_node + n - 1];
      placed = node;
      if (!node.is_leaf()) placed.first += part.first_node - 1;
    }
  }

  // Answers the box.
  Bounds fill(Pack& pack, const Leaf& leaf) const {
    const std::span ids(&ids_[leaf.begin], leaf.size);
    const std::span corners(&corners_[leaf.begin], leaf.size);
    if constexpr (shares_vertices) return repeats_.fill(pack, geometry_, ids, corners, leaf.begin, leaf.corners);
    fill_pack(pack, geometry_, ids, corners);
    PointBounds bounds;
    for (const uvec3& triangle : corners)
      for (int corner = 0; corner < 3; ++corner) bounds.extend(four(geometry_.positions[triangle[corner]]));
    return bounds.get();
  }

  static void unite(TreeNode& node, const std::vector<TreeNode>& children) {
    if (!node.is_leaf()) node.bounds = united(children[node.first].bounds, children[node.first + 1].bounds);
  }

  const Geometry& geometry_;
  const TreeLimits limits_;
  const MortonOrder order_;
  // By place in the order.
  UninitialisedArray<std::uint32_t> ids_;
  UninitialisedArray<uvec3> corners_;
  UninitialisedArray<float> areas_;
  CornerRepeats repeats_;
  std::vector<TreeNode> top_;
  std::vector<Part> parts_;
  std::vector<std::uint32_t> inner_;  // of the tree, above the parts: parents before children
  PackTree<Pack> out_;
  std::atomic<bool> all_are_packs_ = true;
};

}  // namespace

template <class Pack>
std::optional<PackTree<Pack>> build_lbvh_packs(const Geometry& geometry, const TreeLimits& limits) {
  if (!geometry.quadrics.empty()) return std::nullopt;
  return PackCutter<Pack>(geometry, limits).run();
}

template std::optional<PackTree<TrianglePack<4>>> build_lbvh_packs<TrianglePack<4>>(const Geometry&, const TreeLimits&);
template std::optional<PackTree<TrianglePack<8>>> build_lbvh_packs<TrianglePack<8>>(const Geometry&, const TreeLimits&);
template std::optional<PackTree<SharedPack>> build_lbvh_packs<SharedPack>(const Geometry&, const TreeLimits&);

}  // namespace etendue
