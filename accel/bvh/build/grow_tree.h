// Growing a tree from the root down, shared by all top-down builders.
//
// A splitter decides where a run of items is cut. Limits, leaves, tasks and the final order of the nodes are handled here. The
// work is iterative within a task, so its depth costs no call stack. Runs of at least `task_size` items become tasks of their
// own (oneTBB).
//
// The tree is the same at any thread count because a node's place follows from the splits above it alone: a subtree of n items
// has n - 1 pairs of children at most, so its first pair and its n decide where every pair below may lie, depth first. Trees of
// single primitives fill all places; others are closed up by a last pass.
#pragma once

#include "accel/bvh/build/binary_tree.h"
#include "accel/bvh/build/pack_test.h"
#include "framework/core/check.h"
#include "framework/core/huge_pages.h"
#include "framework/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <concepts>
#include <optional>

namespace etendue {

// A node to be: the items in [begin, end), in the splitter's own order, and their box.
struct ItemRange {
  std::uint32_t begin = 0, end = 0;
  Bounds bounds;
  Bounds centres{};         // the box of their centres, for splitters that hand it down
  std::uint32_t depth = 0;  // edges from the root

  std::uint32_t size() const { return end - begin; }
};

struct Split {
  std::uint32_t middle;  // begin < middle < end: where the right side begins
  Bounds left, right;
  Bounds left_centres{}, right_centres{};
};

template <class S>
concept Splitter = requires(S& s, const ItemRange& range, std::uint32_t position) {
  // The best cut of the run, or none if a leaf is better. It is never called for a single item.
  { s.best(range) } -> std::same_as<std::optional<Split>>;
  // Cuts it into two runs of equal length (or lengths that differ by one), whatever the items.
  { s.halve(range) } -> std::same_as<Split>;
  // The id at a position of a run that became a leaf.
  { s.id(range, position) } -> std::same_as<std::uint32_t>;
};

// True where the remaining depth just suffices for a balanced subtree: so max_depth bounds the tree without large leaves,
// unless even a balanced tree would be deeper.
inline bool must_halve(std::uint32_t size, std::uint32_t depth, const TreeLimits& limits) {
  const auto leaf_size = static_cast<std::uint32_t>(limits.leaf_size);
  const int balanced_depth = static_cast<int>(std::bit_width((size + leaf_size - 1) / leaf_size - 1));
  return size > leaf_size && balanced_depth >= limits.max_depth - static_cast<int>(depth);
}

// Which pairs of places hold nodes: bits that any thread may set.
class PairMarks {
 public:
  explicit PairMarks(std::size_t pairs) : words_((pairs + 63) / 64) {}

  void mark(std::uint32_t pair) { words_[pair / 64].fetch_or(std::uint64_t{1} << pair % 64, std::memory_order_relaxed); }
  std::size_t words() const { return words_.size(); }
  std::uint64_t word(std::size_t i) const { return words_[i].load(std::memory_order_relaxed); }

 private:
  std::vector<std::atomic<std::uint64_t>> words_;
};

// The first node and those of the marked pairs, in the same order, without the places between them that hold none.
std::vector<TreeNode> without_gaps(const TreeNode* places, const PairMarks& used);

// Cuts a run of items at the median of their centres along the axis on which these spread most; ties go by id, so the cut
// depends on the set alone.
Split halve_items(std::span<BuildItem> items, const ItemRange& range);

// The boxes around all items and around their centres.
std::pair<Bounds, Bounds> extents(std::span<const BuildItem> items);

template <Splitter S>
class TreeGrower {
 public:
  TreeGrower(S& splitter, std::uint32_t count, const TreeLimits& limits)
      : splitter_(splitter),
        count_(count),
        limits_(limits),
        places_(uninitialised_on_huge_pages<TreeNode>(2 * static_cast<std::size_t>(count) - 1)),
        used_(count) {
    CHECK_LT(count, 1u << 31);
    tree_.primitives.resize(count);
  }

  BinaryTree grow(const Bounds& bounds, const Bounds& centres) {
    run({{0, count_, bounds, centres, 0}, 0, 0});
    tasks_.wait();
    tree_.depth = depth_;
    tree_.nodes = without_gaps(places_.get(), used_);
    return std::move(tree_);
  }

 private:
  static constexpr std::uint32_t task_size = 512;

  struct Job {
    ItemRange range;
    std::uint32_t place;  // of its node
    std::uint32_t pair;   // the first of its subtree's pairs: pair k is at 2k + 1
  };

  // Grows the subtree of a job, handing large subtrees to other tasks.
  void run(const Job& root) {
    std::vector<Job> jobs{root};
    std::uint32_t depth = 0;
    while (!jobs.empty()) {
      const Job job = jobs.back();
      jobs.pop_back();
      const ItemRange& range = job.range;
      const std::optional<Split> split = cut(range);
      if (!split) {
        make_leaf(range, job.place);
        depth = std::max(depth, range.depth);
        continue;
      }
      used_.mark(job.pair);
      depth = std::max(depth, range.depth + 1);
      const std::uint32_t place = 2 * job.pair + 1, left = split->middle - range.begin;
      places_[job.place] = {range.bounds, place, 0};
      hand_on({{split->middle, range.end, split->right, split->right_centres, range.depth + 1}, place + 1, job.pair + left},
              jobs);
      hand_on({{range.begin, split->middle, split->left, split->left_centres, range.depth + 1}, place, job.pair + 1}, jobs);
    }
    std::uint32_t deepest = depth_;
    while (depth > deepest && !depth_.compare_exchange_weak(deepest, depth)) {
    }
  }

  void hand_on(const Job& job, std::vector<Job>& jobs) {
    if (job.range.size() == 1)
      make_leaf(job.range, job.place);
    else if (job.range.size() >= task_size)
      tasks_.run([this, job] { run(job); });
    else
      jobs.push_back(job);
  }

  std::optional<Split> cut(const ItemRange& range) {
    if (range.size() == 1 || static_cast<int>(range.depth) == limits_.max_depth) return std::nullopt;
    if (limits_.packs != nullptr &&
        limits_.packs->takes(range.size(), [&](std::uint32_t i) { return splitter_.id(range, range.begin + i); }))
      return std::nullopt;
    if (must_halve(range.size(), range.depth, limits_)) return splitter_.halve(range);
    return splitter_.best(range);
  }

  void make_leaf(const ItemRange& range, std::uint32_t place) {
    places_[place] = {range.bounds, range.begin, range.size()};
    for (std::uint32_t i = range.begin; i < range.end; ++i) tree_.primitives[i] = splitter_.id(range, i);
  }

  S& splitter_;
  const std::uint32_t count_;
  const TreeLimits limits_;
  UninitialisedArray<TreeNode> places_;
  PairMarks used_;
  BinaryTree tree_;
  std::atomic<std::uint32_t> depth_ = 0;
  TaskGroup tasks_;
};

template <Splitter S>
BinaryTree grow_tree(S& splitter, std::span<const BuildItem> items, const TreeLimits& limits) {
  if (items.empty()) return {};
  const auto [bounds, centres] = extents(items);
  return TreeGrower<S>(splitter, static_cast<std::uint32_t>(items.size()), limits).grow(bounds, centres);
}

}  // namespace etendue
