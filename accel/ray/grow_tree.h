// Growing a tree from the root down: what all top-down builders share.
//
// A splitter decides where a run of items is cut; everything else stands here once: limits, leaves, tasks and the final order
// of the nodes. The work is iterative within a task, so its depth costs no call stack. Runs of at least `task_size` items
// become tasks of their own (oneTBB).
//
// The tree is the same at any thread count because a node's place follows from the split alone: no two splits cut at the same
// position, so the children of the node cut at m can own slots 2m-1 and 2m without asking anyone. A last pass renumbers
// the slots in use depth first.
#pragma once

#include "accel/ray/binary_tree.h"
#include "framework/core/check.h"

#include <tbb/task_group.h>

#include <algorithm>
#include <bit>
#include <concepts>
#include <optional>

namespace etendue {

// A node to be: the items in [begin, end), in the splitter's own order, and their box.
struct ItemRange {
  std::uint32_t begin = 0, end = 0;
  Bounds bounds;

  std::uint32_t size() const { return end - begin; }
};

struct Split {
  std::uint32_t middle;  // begin < middle < end: where the right side begins
  Bounds left, right;
};

template <class S>
concept Splitter = requires(S& s, const ItemRange& range, std::uint32_t position) {
  // Cuts the run where the splitter thinks best, or answers that a leaf is better. Never called for a single item.
  { s.best(range) } -> std::same_as<std::optional<Split>>;
  // Cuts it into two runs of equal length (or lengths that differ by one), whatever the items.
  { s.halve(range) } -> std::same_as<Split>;
  // The id at a position, once the tree has grown.
  { s.id(position) } -> std::same_as<std::uint32_t>;
};

// Cuts a run of items at the median of their centres along the axis on which these spread most; ties go by id, so the cut
// depends on the set alone.
Split halve_items(std::span<BuildItem> items, const ItemRange& range);

template <Splitter S>
class TreeGrower {
 public:
  TreeGrower(S& splitter, std::uint32_t count, const TreeLimits& limits)
      : splitter_(splitter), count_(count), limits_(limits), slots_(2 * static_cast<std::size_t>(count) - 1) {
    CHECK_LT(count, 1u << 31);
  }

  BinaryTree grow(const Bounds& bounds) {
    run({{0, count_, bounds}, 0, 0});
    tasks_.wait();
    return renumbered();
  }

 private:
  static constexpr std::uint32_t task_size = 4096;

  struct Job {
    ItemRange range;
    std::uint32_t slot, depth;
  };

  // Grows the subtree of a job, handing large subtrees to other tasks.
  void run(const Job& root) {
    std::vector<Job> jobs{root};
    while (!jobs.empty()) {
      const Job job = jobs.back();
      jobs.pop_back();
      const std::optional<Split> split = cut(job);
      slots_[job.slot] = {job.range.bounds, job.range.begin, job.range.size()};
      if (!split) continue;
      const std::uint32_t left = 2 * split->middle - 1;
      slots_[job.slot].first = left;
      slots_[job.slot].count = 0;
      hand_on({{job.range.begin, split->middle, split->left}, left, job.depth + 1}, jobs);
      hand_on({{split->middle, job.range.end, split->right}, left + 1, job.depth + 1}, jobs);
    }
  }

  void hand_on(const Job& job, std::vector<Job>& jobs) {
    if (job.range.size() >= task_size)
      tasks_.run([this, job] { run(job); });
    else
      jobs.push_back(job);
  }

  // Where the depth left only just suffices for halving, halving it is: so max_depth bounds the tree without large leaves,
  // unless even a balanced tree would be deeper.
  std::optional<Split> cut(const Job& job) {
    const auto leaf_size = static_cast<std::uint32_t>(limits_.leaf_size), size = job.range.size();
    const auto depth_left = limits_.max_depth - static_cast<int>(job.depth);
    if (size == 1 || depth_left == 0) return std::nullopt;
    const int balanced_depth = static_cast<int>(std::bit_width((size + leaf_size - 1) / leaf_size - 1));
    if (size > leaf_size && balanced_depth >= depth_left) return splitter_.halve(job.range);
    return splitter_.best(job.range);
  }

  // Depth first, a pair of children at a time, without the slots that leaves left empty.
  BinaryTree renumbered() {
    struct Move {
      std::uint32_t from, to, depth;
    };
    BinaryTree tree;
    tree.nodes.reserve(slots_.size());
    tree.nodes.resize(1);
    std::vector<Move> moves{{0, 0, 0}};
    while (!moves.empty()) {
      const Move move = moves.back();
      moves.pop_back();
      const TreeNode& node = slots_[move.from];
      tree.depth = std::max(tree.depth, move.depth);
      tree.nodes[move.to] = node;
      if (node.is_leaf()) continue;
      const auto first = static_cast<std::uint32_t>(tree.nodes.size());
      tree.nodes.resize(tree.nodes.size() + 2);
      tree.nodes[move.to].first = first;
      moves.push_back({node.first + 1, first + 1, move.depth + 1});
      moves.push_back({node.first, first, move.depth + 1});
    }
    tree.nodes.shrink_to_fit();
    tree.primitives.resize(count_);
    for (std::uint32_t i = 0; i < count_; ++i) tree.primitives[i] = splitter_.id(i);
    return tree;
  }

  S& splitter_;
  const std::uint32_t count_;
  const TreeLimits limits_;
  std::vector<TreeNode> slots_;
  tbb::task_group tasks_;
};

template <Splitter S>
BinaryTree grow_tree(S& splitter, std::span<const BuildItem> items, const TreeLimits& limits) {
  if (items.empty()) return {};
  Bounds bounds;
  for (const BuildItem& item : items) bounds.extend(item.bounds);
  return TreeGrower<S>(splitter, static_cast<std::uint32_t>(items.size()), limits).grow(bounds);
}

}  // namespace etendue
