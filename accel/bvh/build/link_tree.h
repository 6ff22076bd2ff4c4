// Growing a tree whose cuts are known before its boxes: shared by builders from a sorted order or from merged pairs.
//
// Cuts are taken from the root down, boxes are then united from the leaves up. The first few cuts are made by one thread, as
// they cost no pass over items; the subtrees below go to tasks (oneTBB). Nodes are numbered as in grow_tree.h, so the tree is
// the same at any thread count, and the work is iterative, so its depth costs no call stack.
#pragma once

#include "accel/bvh/build/grow_tree.h"
#include "framework/core/parallel.h"

namespace etendue {

// A node to be: the items at positions [begin, end), and what the source calls this node.
struct Run {
  std::uint32_t begin, end;
  std::uint32_t depth;  // edges from the root
  std::uint32_t handle;

  std::uint32_t size() const { return end - begin; }
};

struct Cut {
  std::uint32_t middle;  // begin < middle < end
  std::uint32_t left_handle, right_handle;
};

template <class S>
concept CutSource = requires(S& s, const Run& run, std::uint32_t position) {
  // The cut of a run of two items or more, or a leaf.
  { s.best(run) } -> std::same_as<std::optional<Cut>>;
  // A cut into runs of equal length (or lengths that differ by one).
  { s.halve(run) } -> std::same_as<Cut>;
  // Called before `item` is asked for what is in a run: of each leaf, and of runs that may become one.
  {s.settle(run)};
  { s.item(position) } -> std::same_as<const BuildItem&>;
};

template <CutSource S>
class TreeLinker {
 public:
  TreeLinker(S& source, std::uint32_t count, const TreeLimits& limits)
      : source_(source), count_(count), limits_(limits), marks_(count) {
    CHECK_LT(count, 1u << 31);
    resize_on_huge_pages(tree_.nodes, 2 * static_cast<std::size_t>(count) - 1);
    tree_.primitives.resize(count);
  }

  BinaryTree link(std::uint32_t root_handle) {
    std::vector<Job> jobs{{{0, count_, 0, root_handle}, 0, 0}}, large{jobs}, tasks;
    std::vector<std::uint32_t> above;  // nodes whose subtrees hold tasks
    while (!large.empty()) {
      const Job job = large.back();
      large.pop_back();
      Job children[2];
      if (job.run.size() < task_size || !split(job, children)) {
        tasks.push_back(job);
        continue;
      }
      above.push_back(job.place);
      large.insert(large.end(), {children[1], children[0]});
    }
    used_ += 2 * static_cast<std::uint32_t>(above.size()) + 1;
    parallel_for(tasks.size(), 1, [&](std::size_t i) { link_below(tasks[i]); });
    for (std::size_t i = above.size(); i-- > 0;) unite(tree_.nodes[above[i]]);
    tree_.depth = depth_;
    if (used_ < tree_.nodes.size()) tree_.nodes = without_gaps(tree_.nodes.data(), marks_);
    return std::move(tree_);
  }

 private:
  static constexpr std::uint32_t task_size = 4096;

  struct Job {
    Run run;
    std::uint32_t place, pair;  // as in TreeGrower
  };

  // False where the node is to be a leaf.
  bool split(const Job& job, Job* children) {
    const Run& run = job.run;
    if (run.size() == 1 || static_cast<int>(run.depth) == limits_.max_depth) return false;
    if (limits_.packs != nullptr && run.size() <= limits_.packs->lanes()) {
      source_.settle(run);
      if (limits_.packs->takes(run.size(), [&](std::uint32_t i) { return source_.item(run.begin + i).id; })) return false;
    }
    std::optional<Cut> cut;
    if (must_halve(run.size(), run.depth, limits_))
      cut = source_.halve(run);
    else if (cut = source_.best(run); !cut)
      return false;
    const std::uint32_t place = 2 * job.pair + 1;
    tree_.nodes[job.place].first = place;
    marks_.mark(job.pair);
    children[0] = {{run.begin, cut->middle, run.depth + 1, cut->left_handle}, place, job.pair + 1};
    children[1] = {{cut->middle, run.end, run.depth + 1, cut->right_handle}, place + 1, job.pair + cut->middle - run.begin};
    return true;
  }

  void link_below(const Job& root) {
    std::vector<Job> jobs{root};
    std::uint32_t used = 0, deepest = 0, last = root.place;
    while (!jobs.empty()) {
      const Job job = jobs.back();
      jobs.pop_back();
      Job children[2];
      if (!split(job, children)) {
        make_leaf(job);
        deepest = std::max(deepest, job.run.depth);
        continue;
      }
      used += 2;
      last = std::max(last, children[1].place);
      jobs.push_back(children[1]);
      jobs.push_back(children[0]);
    }
    // Children come after their parent; places without a node have no child.
    for (std::uint32_t place = last; used > 0 && place > 2 * root.pair; --place)
      if (TreeNode& node = tree_.nodes[place]; node.first > place && !node.is_leaf()) unite(node);
    if (used > 0) unite(tree_.nodes[root.place]);
    used_ += used;
    std::uint32_t depth = depth_;
    while (deepest > depth && !depth_.compare_exchange_weak(depth, deepest)) {
    }
  }

  void make_leaf(const Job& job) {
    source_.settle(job.run);
    TreeNode& node = tree_.nodes[job.place];
    node.first = job.run.begin;
    node.count = job.run.size();
    for (std::uint32_t i = job.run.begin; i < job.run.end; ++i) {
      const BuildItem& item = source_.item(i);
      node.bounds.extend(item.bounds);
      tree_.primitives[i] = item.id;
    }
  }

  void unite(TreeNode& node) {
    node.bounds = tree_.nodes[node.first].bounds;
    node.bounds.extend(tree_.nodes[node.first + 1].bounds);
  }

  S& source_;
  const std::uint32_t count_;
  const TreeLimits limits_;
  PairMarks marks_;
  BinaryTree tree_;
  std::atomic<std::uint32_t> used_ = 0, depth_ = 0;
};

}  // namespace etendue
