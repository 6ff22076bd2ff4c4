#include "accel/bvh/build/sbvh.h"

#include "accel/bvh/build/grow_tree.h"
#include "accel/bvh/build/slabs.h"
#include "accel/bvh/build/small_sweep.h"
#include "accel/bvh/build/split_primitive.h"
#include "accel/bvh/bvh_entry.h"
#include "accel/kernels/simd_bounds.h"
#include "framework/core/parallel.h"

#include <array>
#include <atomic>
#include <deque>
#include <memory>
#include <mutex>

namespace etendue {

namespace {

constexpr std::uint32_t task_size = 4096;    // subtrees of at least so many references are tasks of their own
constexpr std::uint32_t least_to_chop = 32;  // fewer references will share a leaf or two
constexpr std::uint32_t least_slabs = 8;     // through which a cut is tried; fewer references gain nothing from more

// A piece of the tree that one task builds: its nodes, with child and primitive indices of its own.
struct Part {
  struct Link {
    std::uint32_t slot;  // of this part's nodes
    Part* subtree;       // whose root stands there
  };
  std::vector<TreeNode> nodes;
  std::vector<std::uint32_t> primitives;
  std::vector<Link> links;
};

class SbvhBuilder {
 public:
  SbvhBuilder(const SbvhParams& params, const Geometry* geometry, float root_area)
      : params_(params), geometry_(geometry), least_overlap_(params.alpha * root_area) {
    if (geometry == nullptr) return;
    flat_areas_.resize(geometry->triangles.size());
    parallel_for(flat_areas_.size(), 1 << 13, [&](std::size_t i) {
      const uvec3& v = geometry->triangles[i];
      const auto& p = geometry->positions;
      flat_areas_[i] = glm::length(glm::cross(p[v.y] - p[v.x], p[v.z] - p[v.x]));
    });
  }

  BinaryTree build(BuildItems items, const Bounds& bounds) {
    Part root;
    const auto count = static_cast<std::uint32_t>(items.size());
    references_ = count;
    // The root is a task too: what the watch throws in any of them is then caught in one place.
    tasks_.run_and_wait([&] {
      run(root, items, {bounds, count, static_cast<std::uint32_t>(params_.duplication * static_cast<float>(count)), 0, 0});
    });
    return joined(root);
  }

 private:
  struct Job {
    Bounds bounds;
    std::uint32_t count;
    std::uint32_t spare;  // references that the subtree may add
    std::uint32_t slot, depth;
  };

  // Builds a subtree. Jobs are done last first, so the references of the job in hand are always the last on the stack.
  void run(Part& part, BuildItems stack, const Job& root) {
    part.nodes.resize(1);
    std::vector<Job> jobs{root};
    BuildItems sides[2];
    const auto bins = std::make_unique<SlabBins>();
    while (!jobs.empty()) {
      const Job job = jobs.back();
      jobs.pop_back();
      const auto items = std::span(stack).last(job.count);
      Bounds bounds[2];
      if (!divide(job, items, *bins, sides, bounds)) {
        part.nodes[job.slot] = {job.bounds, static_cast<std::uint32_t>(part.primitives.size()), job.count};
        for (const BuildItem& item : items) part.primitives.push_back(item.id);
        stack.resize(stack.size() - job.count);
        continue;
      }
      stack.resize(stack.size() - job.count);
      const auto first = static_cast<std::uint32_t>(part.nodes.size());
      part.nodes[job.slot] = {job.bounds, first, 0};
      part.nodes.resize(first + 2);
      const auto total = sides[0].size() + sides[1].size();
      if (params_.watch != nullptr && total > job.count)
        params_.watch->check((references_ += total - job.count) * params_.bytes_per_reference);
      const auto spare = job.spare - static_cast<std::uint32_t>(total - job.count);
      for (const int side : {0, 1}) {
        const auto count = static_cast<std::uint32_t>(sides[side].size());
        const auto part_of_spare = static_cast<std::uint32_t>(static_cast<std::uint64_t>(spare) * count / total);
        const Job child{bounds[side], count, part_of_spare, first + side, job.depth + 1};
        if (count >= task_size) {
          hand_on(part, std::move(sides[side]), child);
          sides[side] = {};
        } else {
          stack.insert(stack.end(), sides[side].begin(), sides[side].end());
          jobs.push_back(child);
        }
      }
    }
  }

  void hand_on(Part& part, BuildItems items, const Job& job) {
    Part* subtree;
    {
      const std::lock_guard lock(mutex_);
      subtree = &parts_.emplace_back();
    }
    part.links.push_back({job.slot, subtree});
    Job root = job;
    root.slot = 0;
    tasks_.run([this, subtree, root, items = std::move(items)] { run(*subtree, items, root); });
  }

  // False: a leaf. Else both sides and their boxes.
  bool divide(const Job& job, std::span<BuildItem> items, SlabBins& bins, BuildItems (&sides)[2], Bounds (&bounds)[2]) const {
    if (job.count == 1 || static_cast<int>(job.depth) == params_.max_depth) return false;
    if (params_.packs != nullptr && params_.packs->takes(job.count, [&](std::uint32_t i) { return items[i].id; })) return false;
    for (auto& side : sides) side.clear();
    if (must_halve(job.count, job.depth, params_)) return halve(job, items, sides, bounds);
    if (job.count <= small_sweep_size) return divide_few(job, items, sides, bounds);
    Bounds centres;
    for (const BuildItem& item : items) centres.extend(item.bounds.centre());
    const SlabCut between = best_between(items, centres, bins);
    SlabCut through;
    if (job.count >= least_to_chop && job.spare > 0 &&
        (between.axis < 0 || overlap(between.left_bounds, between.right_bounds).half_area() > least_overlap_)) {
      through = best_through(job, items, bins);
      if (through.left + through.right - job.count > job.spare) through = {};
    }
    if (prefers_leaf(job, std::min(between.cost, through.cost))) return false;
    if (!(through.cost < between.cost && chop(job, items, through, sides))) {
      for (auto& side : sides) side.clear();
      if (between.axis < 0) return halve(job, items, sides, bounds);  // coincident centres, or areas beyond the range of float
      const Slabs slabs(centres.lower[between.axis], centres.upper[between.axis], bins_for(job.count));
      for (const BuildItem& item : items) sides[slabs.of(item.bounds.centre()[between.axis]) >= between.slab].push_back(item);
    }
    set_bounds(sides, bounds);
    return true;
  }

  bool prefers_leaf(const Job& job, float cut_cost) const {
    const float area = job.bounds.half_area(), count = static_cast<float>(job.count);
    return count <= static_cast<float>(params_.leaf_size) &&
           !(area + params_.primitive_cost * cut_cost < params_.primitive_cost * area * count);
  }

  // Divides by every cut between so few references; none is chopped.
  bool divide_few(const Job& job, std::span<BuildItem> items, BuildItems (&sides)[2], Bounds (&bounds)[2]) const {
    const SmallCut cut = sweep_small(items.data(), job.count);
    if (prefers_leaf(job, cut.cost)) return false;
    if (!(cut.cost < infinity)) return halve(job, items, sides, bounds);
    for (std::uint32_t i = 0; i < job.count; ++i) sides[i >= cut.left].push_back(items[cut.order[i]]);
    set_bounds(sides, bounds);
    return true;
  }

  static void set_bounds(const BuildItems (&sides)[2], Bounds (&bounds)[2]) {
    for (const int side : {0, 1}) {
      SimdBounds sum;
      for (const BuildItem& item : sides[side]) sum.extend(item.bounds);
      bounds[side] = sum.get();
    }
  }

  static bool halve(const Job& job, std::span<BuildItem> items, BuildItems (&sides)[2], Bounds (&bounds)[2]) {
    const Split split = halve_items(items, {0, job.count, job.bounds});
    sides[0].assign(items.begin(), items.begin() + split.middle);
    sides[1].assign(items.begin() + split.middle, items.end());
    bounds[0] = split.left;
    bounds[1] = split.right;
    return true;
  }

  std::uint32_t bins_for(std::uint32_t count) const {
    return std::min(static_cast<std::uint32_t>(params_.bins), 4 + count / 8);
  }

  SlabCut best_between(std::span<const BuildItem> items, const Bounds& centres, SlabBins& bins) const {
    SlabCut best;
    for (int axis = 0; axis < 3; ++axis) {
      const Slabs slabs(centres.lower[axis], centres.upper[axis], bins_for(static_cast<std::uint32_t>(items.size())));
      if (!slabs.usable()) continue;
      bins.clear(slabs.count());
      for (const BuildItem& item : items) {
        SlabBin& bin = bins[slabs.of(item.bounds.centre()[axis])];
        bin.bounds.extend(item.bounds);
        ++bin.begins;
        ++bin.ends;
      }
      bins.sweep(axis, best);
    }
    return best;
  }

  // Fewer references get fewer slabs, since each is chopped into all that it spans.
  Slabs slabs_through(const Job& job, int axis) const {
    const std::uint32_t count = std::min(static_cast<std::uint32_t>(params_.bins), least_slabs + job.count / 32);
    return {job.bounds.lower[axis], job.bounds.upper[axis], count};
  }

  // Whether a triangle fills so little of its box that chopping the box tells nothing of its parts: a sliver along a diagonal.
  bool is_slim(const BuildItem& item) const {
    if (flat_areas_.empty() || !geometry_->is_triangle(item.id)) return false;
    return 4 * flat_areas_[item.id] < item.bounds.half_area();
  }

  // [Stich2009] section 4.2: each reference is chopped into the slabs it spans. For most, the box is chopped, which finds cuts
  // as good in less time; slim triangles are chopped themselves, as are all once a cut is chosen.
  SlabCut best_through(const Job& job, std::span<const BuildItem> items, SlabBins& bins) const {
    SlabCut best;
    for (int axis = 0; axis < 3; ++axis) {
      const Slabs slabs = slabs_through(job, axis);
      if (!slabs.usable()) continue;
      bins.clear(slabs.count());
      for (const BuildItem& item : items) {
        const std::uint32_t first = slabs.of(item.bounds.lower[axis]), last = slabs.of(item.bounds.upper[axis]);
        ++bins[first].begins;
        ++bins[last].ends;
        if (first < last && is_slim(item))
          chop_slim(item, axis, slabs, first, last, bins);
        else
          chop_box(item.bounds, axis, slabs, first, last, bins);
      }
      bins.sweep(axis, best);
    }
    return best;
  }

  void chop_slim(BuildItem rest, int axis, const Slabs& slabs, std::uint32_t first, std::uint32_t last, SlabBins& bins) const {
    for (std::uint32_t slab = first; slab < last; ++slab) {
      const float plane = slabs.plane(slab + 1);
      if (!(rest.bounds.lower[axis] < plane && plane < rest.bounds.upper[axis])) continue;
      const SplitParts parts = split_primitive(geometry_, rest, axis, plane);
      if (parts.left.empty() || parts.right.empty()) continue;
      bins[slab].bounds.extend(parts.left);
      rest.bounds = parts.right;
    }
    bins[last].bounds.extend(rest.bounds);
  }

  // Distributes references about a plane, chopping those that straddle it where that is cheapest. False if all end on one side.
  bool chop(const Job& job, std::span<const BuildItem> items, const SlabCut& cut, BuildItems (&sides)[2]) const {
    const Slabs slabs = slabs_through(job, cut.axis);
    const float plane = slabs.plane(cut.slab);
    Bounds left_box = cut.left_bounds, right_box = cut.right_bounds;
    float left = static_cast<float>(cut.left), right = static_cast<float>(cut.right);
    for (const BuildItem& item : items) {
      const std::uint32_t first = slabs.of(item.bounds.lower[cut.axis]), last = slabs.of(item.bounds.upper[cut.axis]);
      if (last < cut.slab) {
        sides[0].push_back(item);
        continue;
      }
      if (first >= cut.slab) {
        sides[1].push_back(item);
        continue;
      }
      // [Stich2009] section 4.3: chopped, or whole on either side?
      const Bounds left_whole = united(left_box, item.bounds), right_whole = united(right_box, item.bounds);
      const float chopped = left_box.half_area() * left + right_box.half_area() * right;
      const float to_left = left_whole.half_area() * left + right_box.half_area() * (right - 1);
      const float to_right = left_box.half_area() * (left - 1) + right_whole.half_area() * right;
      SplitParts parts;
      bool can_chop = item.bounds.lower[cut.axis] < plane && plane < item.bounds.upper[cut.axis];
      if (can_chop) {
        parts = split_primitive(geometry_, item, cut.axis, plane);
        can_chop = !parts.left.empty() && !parts.right.empty();
      }
      if (can_chop && chopped <= to_left && chopped <= to_right) {
        sides[0].push_back({parts.left, item.id});
        sides[1].push_back({parts.right, item.id});
      } else if (to_left <= to_right) {
        sides[0].push_back(item);
        left_box = left_whole;
        right -= 1;
      } else {
        sides[1].push_back(item);
        right_box = right_whole;
        left -= 1;
      }
    }
    const auto total = sides[0].size() + sides[1].size();
    // A side may hold as many as before, in smaller boxes: the spare it took for that ends somewhere.
    return !sides[0].empty() && !sides[1].empty() && total - job.count <= job.spare;
  }

  // All parts one after another, then depth first.
  static BinaryTree joined(const Part& root) {
    BinaryTree tree;
    struct Placed {
      const Part* part;
      std::uint32_t slot;  // of its root
    };
    tree.nodes.resize(1);
    std::vector<Placed> waiting{{&root, 0}};
    while (!waiting.empty()) {
      const Placed at = waiting.back();
      waiting.pop_back();
      // Its root goes to the slot that waits for it, the other nodes to the end.
      const auto nodes = static_cast<std::uint32_t>(tree.nodes.size()) - 1,
                 primitives = static_cast<std::uint32_t>(tree.primitives.size());
      const auto place = [&](std::uint32_t slot) { return slot == 0 ? at.slot : nodes + slot; };
      tree.nodes.resize(tree.nodes.size() + at.part->nodes.size() - 1);
      for (std::uint32_t slot = 0; slot < at.part->nodes.size(); ++slot) {
        TreeNode node = at.part->nodes[slot];
        node.first += node.is_leaf() ? primitives : nodes;
        tree.nodes[place(slot)] = node;
      }
      tree.primitives.insert(tree.primitives.end(), at.part->primitives.begin(), at.part->primitives.end());
      for (const Part::Link& link : at.part->links) waiting.push_back({link.subtree, place(link.slot)});
    }
    return depth_first(tree);
  }

  const SbvhParams params_;
  const Geometry* const geometry_;
  const float least_overlap_;
  std::vector<float> flat_areas_;  // by triangle: twice its area, or about half_area of its box where that is flat
  std::mutex mutex_;
  std::deque<Part> parts_;  // other than the root's
  std::atomic<std::uint64_t> references_ = 0;
  TaskGroup tasks_;
};

}  // namespace

BinaryTree build_sbvh(BuildItems items, const SbvhParams& params, const Geometry* geometry) {
  if (items.empty()) return {};
  Bounds bounds;
  for (const BuildItem& item : items) bounds.extend(item.bounds);
  return SbvhBuilder(params, geometry, bounds.half_area()).build(std::move(items), bounds);
}

RayEntry sbvh_entry() {
  // Few scenes use up a large duplication; for those that do there is the watch.
  const auto space = [](const SbvhParams& params) { return BuilderSpace{124, 1 + std::min(params.duplication, 0.5f)}; };
  RayEntry entry = bvh_entry<SbvhParams>("sbvh", "bounding volume hierarchy by surface area, cuts through primitives too",
                                         space, build_sbvh);
  entry.builder = {};  // its trees hold parts of primitives at their present places, so they cannot change over time
  return entry;
}

}  // namespace etendue
