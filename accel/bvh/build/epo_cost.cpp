#include "accel/bvh/build/epo_cost.h"

#include "accel/kernels/clipped_polygon.h"
#include "framework/core/parallel.h"
#include "framework/core/rng.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace etendue {

namespace {

ClippedPolygon triangle_of(const Geometry& geometry, std::uint32_t id) {
  const uvec3 v = geometry.triangles[id];
  return {geometry.positions[v.x], geometry.positions[v.y], geometry.positions[v.z]};
}

// Leaves numbered depth first, so that a subtree is an interval of them: "is this primitive below that node?" is a search among
// the few leaves that list it.
class Subtrees {
 public:
  Subtrees(const BinaryTree& tree, std::uint32_t primitives) : spans_(tree.nodes.size()), first_(primitives + 1) {
    std::vector<std::uint32_t> leaves, stack{0};
    while (!stack.empty()) {
      const std::uint32_t node = stack.back();
      stack.pop_back();
      if (tree.nodes[node].is_leaf()) {
        const auto ordinal = static_cast<std::uint32_t>(leaves.size());
        spans_[node] = {ordinal, ordinal + 1};
        leaves.push_back(node);
      } else {
        stack.insert(stack.end(), {tree.nodes[node].first + 1, tree.nodes[node].first});
      }
    }
    for (std::size_t n = tree.nodes.size(); n-- > 0;)  // children follow their parent
      if (!tree.nodes[n].is_leaf()) spans_[n] = {spans_[tree.nodes[n].first].x, spans_[tree.nodes[n].first + 1].y};
    for (const std::uint32_t id : tree.primitives) ++first_[id + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    ordinals_.resize(tree.primitives.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t ordinal = 0; ordinal < leaves.size(); ++ordinal) {
      const TreeNode& leaf = tree.nodes[leaves[ordinal]];
      for (std::uint32_t i = 0; i < leaf.count; ++i) ordinals_[next[tree.primitives[leaf.first + i]]++] = ordinal;
    }
  }

  bool listed(std::uint32_t id) const { return first_[id] < first_[id + 1]; }
  bool below(std::uint32_t id, std::uint32_t node) const {
    const auto end = ordinals_.begin() + first_[id + 1];
    const auto found = std::lower_bound(ordinals_.begin() + first_[id], end, spans_[node].x);
    return found != end && *found < spans_[node].y;
  }

 private:
  std::vector<uvec2> spans_;
  std::vector<std::uint32_t> first_, ordinals_;  // of primitive id: ordinals_[first_[id] .. first_[id + 1])
};

// The weighted area of a triangle within nodes that do not hold it.
double overlap_area(const BinaryTree& tree, const Subtrees& subtrees, const Geometry& geometry, std::uint32_t id) {
  struct Visit {
    std::uint32_t node;
    ClippedPolygon polygon;  // clipped to the parent's box
  };
  double sum = 0;
  std::vector<Visit> visits{{0, triangle_of(geometry, id)}};
  while (!visits.empty()) {
    Visit visit = visits.back();
    visits.pop_back();
    const TreeNode& node = tree.nodes[visit.node];
    for (int axis = 0; axis < 3; ++axis) visit.polygon.clip(axis, node.bounds.lower[axis], node.bounds.upper[axis]);
    const double area = visit.polygon.area();
    if (area == 0) continue;
    if (!subtrees.below(id, visit.node)) sum += area * (node.is_leaf() ? node.count : 1u);
    if (node.is_leaf()) continue;
    visits.push_back({node.first + 1, visit.polygon});
    visits.push_back({node.first, visit.polygon});
  }
  return sum;
}

}  // namespace

EpoCost epo_cost(const BinaryTree& tree, const Geometry& geometry, std::uint32_t most_triangles) {
  if (tree.nodes.empty()) return {};
  const Subtrees subtrees(tree, geometry.primitive_count());
  std::vector<std::uint32_t> ids;
  std::vector<double> areas;
  for (std::uint32_t id = 0; id < geometry.triangles.size(); ++id) {
    if (!subtrees.listed(id)) continue;
    ids.push_back(id);
    areas.push_back(triangle_of(geometry, id).area());
  }
  const double total = std::accumulate(areas.begin(), areas.end(), 0.0);
  if (!(total > 0 && std::isfinite(total))) return {};

  EpoCost cost{0, static_cast<std::uint32_t>(ids.size()), ids.size() > most_triangles};
  std::vector<std::size_t> chosen(ids.size());
  std::iota(chosen.begin(), chosen.end(), std::size_t{0});
  if (cost.sampled) {
    cost.triangles = most_triangles;
    chosen.clear();
    const double step = total / most_triangles, offset = Pcg32(1, 1).next_float() * step;
    double passed = 0;
    for (std::size_t i = 0; i < ids.size(); ++i)
      for (passed += areas[i]; chosen.size() < most_triangles && offset + step * static_cast<double>(chosen.size()) < passed;)
        chosen.push_back(i);
  }
  std::vector<double> terms(chosen.size());  // summed in order: the same at any number of threads
  parallel_for(chosen.size(), 64, [&](std::size_t i) {
    const double area = overlap_area(tree, subtrees, geometry, ids[chosen[i]]);
    terms[i] = cost.sampled ? area / areas[chosen[i]] : area;
  });
  cost.value = std::accumulate(terms.begin(), terms.end(), 0.0) / (cost.sampled ? static_cast<double>(terms.size()) : total);
  return cost;
}

}  // namespace etendue
