#include "accel/bvh/build/reinsertion.h"

#include "framework/core/parallel.h"

#include <algorithm>

namespace etendue {

namespace {

constexpr double least_worthwhile = 0.002;  // of the sum of areas

class Reinsertion {
 public:
  explicit Reinsertion(BinaryTree& tree) : nodes_(tree.nodes), parent_(nodes_.size(), no_id), touched_(nodes_.size()) {
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) adopt(n);
  }

  // Sum of areas saved, as a share of the sum before.
  double pass() {
    std::vector<Move> moves(nodes_.size());
    parallel_for(nodes_.size(), 64, [&](std::size_t n) { moves[n] = best_move(static_cast<std::uint32_t>(n)); });
    std::erase_if(moves, [](const Move& move) { return move.target == no_id; });
    std::sort(moves.begin(), moves.end(),
              [](const Move& a, const Move& b) { return a.gain > b.gain || (a.gain == b.gain && a.node < b.node); });
    const double before = total_area();
    std::fill(touched_.begin(), touched_.end(), false);
    for (const Move& move : moves) apply(move);
    return 1 - total_area() / before;
  }

 private:
  struct Move {
    std::uint32_t node = no_id, target = no_id;
    float gain = 0;  // of half areas
  };

  // The children of a pair (2i-1, 2i) are siblings.
  static std::uint32_t sibling(std::uint32_t n) { return ((n + 1) ^ 1) - 1; }

  void adopt(std::uint32_t n) {
    if (nodes_[n].is_leaf()) return;
    parent_[nodes_[n].first] = parent_[nodes_[n].first + 1] = n;
  }

  double total_area() const {
    double sum = 0;
    for (const TreeNode& node : nodes_) sum += node.bounds.half_area();
    return sum;
  }

  // Taking out `node` removes its parent and shrinks the ancestors; putting it at `target` adds a node there and widens the
  // boxes on the way. The search follows [Meister2018Reinsertion] section 3.1.
  Move best_move(std::uint32_t node) const {
    Move best{node, no_id, 0};
    if (node == 0 || parent_[node] == 0) return best;  // the root has no better place, nor have its children
    const Bounds box = nodes_[node].bounds;
    const float area = box.half_area();
    struct Open {
      std::uint32_t node;
      float gain;  // before the node itself is widened
    };
    thread_local std::vector<Open> open;
    std::uint32_t pivot = parent_[node], side = sibling(node);
    Bounds left_behind;  // what the pivot's box would be without the node
    float gain = nodes_[pivot].bounds.half_area();
    for (;;) {
      open.clear();
      open.push_back({side, gain});
      while (!open.empty()) {
        const Open at = open.back();
        open.pop_back();
        if (!(at.gain - area > best.gain)) continue;
        const TreeNode& candidate = nodes_[at.node];
        const float widened = united(candidate.bounds, box).half_area();
        const float here = at.gain - widened;
        if (here > best.gain && at.node != sibling(node)) best = {node, at.node, here};
        if (candidate.is_leaf()) continue;
        const float below = here + candidate.bounds.half_area();
        if (!(below - area > best.gain)) continue;
        open.push_back({candidate.first, below});
        open.push_back({candidate.first + 1, below});
      }
      if (pivot == 0) return best;
      if (pivot == parent_[node]) {
        left_behind = nodes_[side].bounds;
      } else {
        left_behind.extend(nodes_[side].bounds);
        gain += nodes_[pivot].bounds.half_area() - left_behind.half_area();
      }
      side = sibling(pivot);
      pivot = parent_[pivot];
    }
  }

  void apply(const Move& move) {
    const std::uint32_t node = move.node, target = move.target, parent = parent_[node], other = sibling(node);
    for (const std::uint32_t n : {node, target, parent, other, parent_[target]})
      if (touched_[n]) return;
    for (std::uint32_t n = target; n != no_id; n = parent_[n])
      if (n == node) return;  // an earlier move has brought the target below the node
    for (const std::uint32_t n : {node, target, parent, other, parent_[target]}) touched_[n] = true;
    // The sibling takes the parent's place; the pair of slots it leaves takes the target and the node, below the target's
    // place.
    nodes_[parent] = nodes_[other];
    adopt(parent);
    const std::uint32_t pair = std::min(node, other);
    const std::uint32_t moved = target == other ? parent : target;
    const TreeNode at_target = nodes_[moved], taken = nodes_[node];
    nodes_[pair] = at_target;
    nodes_[pair + 1] = taken;
    nodes_[moved] = {united(at_target.bounds, taken.bounds), pair, 0};
    adopt(pair);
    adopt(pair + 1);
    adopt(moved);
    refit_above(parent);
    refit_above(moved);
  }

  void refit_above(std::uint32_t n) {
    for (n = parent_[n]; n != no_id; n = parent_[n])
      nodes_[n].bounds = united(nodes_[nodes_[n].first].bounds, nodes_[nodes_[n].first + 1].bounds);
  }

  std::vector<TreeNode>& nodes_;
  std::vector<std::uint32_t> parent_;  // of each node; none of the root
  std::vector<bool> touched_;          // by a move of this pass
};

}  // namespace

void reinsert_subtrees(BinaryTree& tree, int passes) {
  if (passes == 0 || tree.nodes.size() < 7) return;
  Reinsertion reinsertion(tree);
  for (int pass = 0; pass < passes && reinsertion.pass() > least_worthwhile; ++pass) {
  }
  tree = depth_first(tree);
}

}  // namespace etendue
