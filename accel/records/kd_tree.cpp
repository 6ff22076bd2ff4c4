#include "accel/records/kd_tree.h"

#include "accel/points/left_balance.h"

namespace etendue {

static_assert(RecordStructure<RecordKdTree>);

// Returns the largest radius.
float RecordKdTree::place(std::span<RecordSphere> spheres, std::size_t node, Tree& tree) {
  if (spheres.empty()) return 0;
  Bounds bounds;
  for (const RecordSphere& sphere : spheres) bounds.extend(sphere.centre);
  const int axis = bounds.longest_axis();
  const std::size_t left = left_subtree_size(spheres.size());
  const auto median = spheres.begin() + static_cast<std::ptrdiff_t>(left);
  std::nth_element(spheres.begin(), median, spheres.end(),
                   [axis](const RecordSphere& a, const RecordSphere& b) { return a.centre[axis] < b.centre[axis]; });
  const float lower = place(spheres.first(left), 2 * node, tree), upper = place(spheres.subspan(left + 1), 2 * node + 1, tree);
  tree[node] = {*median, std::max({median->radius, lower, upper}), axis};
  return tree[node].largest_radius;
}

void RecordKdTree::insert(const vec3& centre, float radius, std::uint32_t id) {
  if (!is_record_sphere(centre, radius)) return;
  list_.push_back({centre, radius, id});
  if (list_.size() < list_size) return;
  std::size_t level = 0;
  for (; level < trees_.size() && !trees_[level].empty(); ++level) {
    for (std::size_t i = 1; i < trees_[level].size(); ++i) list_.push_back(trees_[level][i].sphere);
    trees_[level] = {};
  }
  if (level == trees_.size()) trees_.emplace_back();
  trees_[level].resize(list_.size() + 1);
  place(list_, 1, trees_[level]);
  list_ = {};
}

void RecordKdTree::ask(const Tree& tree, const vec3& p, Neighbours& out) {
  struct Waiting {
    std::size_t node;
    float plane;  // squared distance of the plane beyond which it lies
  };
  std::array<Waiting, 34> waiting;  // at most one a level
  std::size_t count = 0;
  for (std::size_t node = 1;;) {
    while (node < tree.size()) {
      const Node& n = tree[node];
      add_if_covering(n.sphere, p, out);
      const float to_plane = component(p, n.axis) - component(n.sphere.centre, n.axis);
      const std::size_t near = 2 * node + (to_plane > 0);
      if ((near ^ 1) < tree.size()) waiting[count++] = {near ^ 1, square(to_plane)};
      node = near;
    }
    do {
      if (count == 0) return;
      --count;
    } while (waiting[count].plane > square(tree[waiting[count].node].largest_radius));
    node = waiting[count].node;
  }
}

void RecordKdTree::covering(const vec3& p, Neighbours& out) const {
  out.clear();
  if (!is_finite(p)) return;
  for (const RecordSphere& sphere : list_) add_if_covering(sphere, p, out);
  for (const Tree& tree : trees_) ask(tree, p, out);
  sort_by_id(out);
}

std::uint64_t RecordKdTree::bytes() const {
  std::uint64_t bytes = list_.size() * sizeof(RecordSphere) + trees_.size() * sizeof(Tree);
  for (const Tree& tree : trees_) bytes += tree.size() * sizeof(Node);
  return bytes;
}

}  // namespace etendue
