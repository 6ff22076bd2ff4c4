#include "accel/points/left_balanced_tree.h"

#include "accel/points/left_balance.h"
#include "accel/points/placed_points.h"
#include "framework/core/check.h"
#include "framework/core/parallel.h"

namespace etendue {

static_assert(PointStructure<LeftBalancedTree>);

namespace {

constexpr std::size_t task_size = 8192;  // subtrees of fewer points are one task

}  // namespace

void LeftBalancedTree::place(std::span<PlacedPoint> points, std::size_t node) {
  while (!points.empty()) {
    Bounds bounds;
    for (const PlacedPoint& point : points) bounds.extend(point.position);
    const int axis = bounds.longest_axis();
    const std::size_t left = left_subtree_size(points.size());
    const auto median = points.begin() + static_cast<std::ptrdiff_t>(left);
    std::nth_element(points.begin(), median, points.end(), [axis](const PlacedPoint& a, const PlacedPoint& b) {
      return a.position[axis] < b.position[axis] || (a.position[axis] == b.position[axis] && a.id < b.id);
    });
    nodes_[node] = {median->position, median->id | static_cast<std::uint32_t>(axis) << 30};
    const auto lower = points.first(left), upper = points.subspan(left + 1);
    if (points.size() > task_size)
      return parallel_invoke([=, this] { place(lower, 2 * node); }, [=, this] { place(upper, 2 * node + 1); });
    place(lower, 2 * node);
    points = upper;
    node = 2 * node + 1;
  }
}

void LeftBalancedTree::build(std::span<const vec3> points) {
  CHECK_LE(points.size(), std::size_t{1} << 30);
  std::vector<PlacedPoint> placed = finite_placed_points(points);
  nodes_.assign(placed.empty() ? 0 : placed.size() + 1, {});
  place(placed, 1);
}

template <class Limit, class Visit>
void LeftBalancedTree::traverse(const vec3& p, const Limit& limit, const Visit& visit) const {
  struct Waiting {
    std::size_t node;
    float plane;  // squared distance of the plane beyond which it lies
  };
  std::array<Waiting, 32> waiting;  // at most one a level
  std::size_t count = 0, node = 1;
  const std::size_t size = nodes_.size();
  while (true) {
    while (node < size) {
      const Node& n = nodes_[node];
      visit(n, distance_squared(n.position, p));
      const int axis = n.axis();
      const float to_plane = component(p, axis) - component(n.position, axis);
      const std::size_t near = 2 * node + (to_plane > 0), far = near ^ 1;
      if (far < size && square(to_plane) <= limit()) waiting[count++] = {far, square(to_plane)};
      node = near;
    }
    do {
      if (count == 0) return;
      --count;
    } while (!(waiting[count].plane <= limit()));
    node = waiting[count].node;
  }
}

void LeftBalancedTree::within(const vec3& p, float r, Neighbours& out) const {
  out.clear();
  if (nodes_.empty() || !can_find(p, r)) return;
  const float limit = r * r;
  traverse(
      p, [limit] { return limit; },
      [&](const Node& node, float d2) {
        if (d2 <= limit) out.push_back({node.id(), d2});
      });
}

void LeftBalancedTree::nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const {
  out.clear();
  if (nodes_.empty() || k == 0 || !can_find(p, r_max)) return;
  NearestSoFar found(k, r_max * r_max, out);
  traverse(
      p, [&] { return found.worst(); }, [&](const Node& node, float d2) { found.add(node.id(), d2); });
  found.sort();
}

}  // namespace etendue
