#include "accel/records/kd_tree.h"

#include "accel/points/left_balance.h"

namespace etendue {

static_assert(BallStructure<BallKdTree>);

// Returns the largest radius.
float BallKdTree::place(std::span<Ball> balls, std::size_t node, Tree& tree) {
  if (balls.empty()) return 0;
  Bounds bounds;
  for (const Ball& ball : balls) bounds.extend(ball.centre);
  const int axis = bounds.longest_axis();
  const std::size_t left = left_subtree_size(balls.size());
  const auto median = balls.begin() + static_cast<std::ptrdiff_t>(left);
  std::nth_element(balls.begin(), median, balls.end(),
                   [axis](const Ball& a, const Ball& b) { return a.centre[axis] < b.centre[axis]; });
  const float lower = place(balls.first(left), 2 * node, tree), upper = place(balls.subspan(left + 1), 2 * node + 1, tree);
  tree[node] = {*median, std::max({median->radius, lower, upper}), axis};
  return tree[node].largest_radius;
}

void BallKdTree::insert(const vec3& centre, float radius, std::uint32_t id) {
  if (!is_ball(centre, radius)) return;
  list_.push_back({centre, radius, id});
  if (list_.size() < list_size) return;
  std::size_t level = 0;
  for (; level < trees_.size() && !trees_[level].empty(); ++level) {
    for (std::size_t i = 1; i < trees_[level].size(); ++i) list_.push_back(trees_[level][i].ball);
    trees_[level] = {};
  }
  if (level == trees_.size()) trees_.emplace_back();
  trees_[level].resize(list_.size() + 1);
  place(list_, 1, trees_[level]);
  list_ = {};
}

void BallKdTree::ask(const Tree& tree, const vec3& p, Neighbours& out) {
  struct Waiting {
    std::size_t node;
    float plane;  // squared distance of the plane beyond which it lies
  };
  std::array<Waiting, 34> waiting;  // at most one a level
  std::size_t count = 0;
  for (std::size_t node = 1;;) {
    while (node < tree.size()) {
      const Node& n = tree[node];
      add_if_covering(n.ball, p, out);
      const float to_plane = component(p, n.axis) - component(n.ball.centre, n.axis);
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

void BallKdTree::covering(const vec3& p, Neighbours& out) const {
  out.clear();
  if (!is_finite(p)) return;
  for (const Ball& ball : list_) add_if_covering(ball, p, out);
  for (const Tree& tree : trees_) ask(tree, p, out);
  sort_by_id(out);
}

std::uint64_t BallKdTree::bytes() const {
  std::uint64_t bytes = list_.size() * sizeof(Ball) + trees_.size() * sizeof(Tree);
  for (const Tree& tree : trees_) bytes += tree.size() * sizeof(Node);
  return bytes;
}

}  // namespace etendue
