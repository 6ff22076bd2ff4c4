#include "accel/bvh/build/ploc.h"

#include "accel/bvh/build/link_tree.h"
#include "accel/bvh/build/morton_order.h"
#include "accel/bvh/bvh_entry.h"

#include <array>

namespace etendue {

namespace {

constexpr std::size_t block_size = 2048;  // clusters of a task
constexpr std::uint32_t few = 32;         // a round must merge one cluster in so many

// A leaf of one item is named by its place, a merge by its index plus the number of items.
struct Merge {
  std::uint32_t left, right, size;
  bool is_leaf;  // its items are best kept together
};

// The roots of a round, by coordinate, with room for a search to run past the end.
struct Clusters {
  std::array<std::vector<float>, 3> lower, upper;
  std::vector<float> largest;  // what an area counts as at most
  std::vector<float> cost;     // of the subtree, by the surface area heuristic
  std::vector<std::uint32_t> name, size;

  Clusters(std::size_t count, std::size_t margin)
      : largest(count + margin, std::numeric_limits<float>::max()), cost(count), name(count), size(count) {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis].resize(count + margin);
      upper[axis].resize(count + margin);
    }
    end_at(count, margin);
  }
  // The places past the end are infinitely far from all others.
  void end_at(std::size_t count, std::size_t margin) {
    const auto fill = [=](std::vector<float>& values, float value) { std::fill_n(values.begin() + count, margin, value); };
    for (int axis = 0; axis < 3; ++axis) {
      fill(lower[axis], -infinity);
      fill(upper[axis], infinity);
    }
    fill(largest, infinity);
  }
  Bounds bounds(std::size_t i) const {
    return {{lower[0][i], lower[1][i], lower[2][i]}, {upper[0][i], upper[1][i], upper[2][i]}};
  }
  void set(std::size_t i, const Bounds& bounds, std::uint32_t its_name, std::uint32_t its_size, float its_cost) {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis][i] = bounds.lower[axis];
      upper[axis][i] = bounds.upper[axis];
    }
    name[i] = its_name;
    size[i] = its_size;
    cost[i] = its_cost;
  }
};

class Clustering {
 public:
  Clustering(std::span<const BuildItem> items, const PlocParams& params)
      : params_(params),
        radius_(static_cast<std::size_t>(params.search_radius)),
        item_count_(static_cast<std::uint32_t>(items.size())),
        count_(items.size()),
        from_(count_, radius_),
        to_(count_, radius_),
        nearest_(count_),
        merges_(count_ - 1) {
    parallel_for(count_, block_size, [&](std::size_t i) {
      const Bounds& b = items[i].bounds;
      from_.set(i, b, static_cast<std::uint32_t>(i), 1, params_.primitive_cost * b.half_area());
    });
  }

  // The merges in order, and the name of the root.
  std::uint32_t run(std::vector<Merge>& merges) {
    while (count_ > 1) round();
    merges = std::move(merges_);
    return from_.name[0];
  }

 private:
  template <class Body>
  void each_block(const Body& body) {
    parallel_for((count_ + block_size - 1) / block_size, 1,
                 [&](std::size_t block) { body(block, block * block_size, std::min(count_, (block + 1) * block_size)); });
  }

  void round() {
    each_block([&](std::size_t, std::size_t begin, std::size_t end) { find_nearest(begin, end); });
    std::vector<std::uint32_t> merged = count_merges();  // by block; then the merges before each
    std::uint32_t total = 0;
    for (const std::uint32_t m : merged) total += m;
    if (total * std::uint64_t{few} < count_ && count_ > 2 * few) {
      for (std::size_t i = 0; i < count_; ++i) nearest_[i] = static_cast<std::uint32_t>((i ^ 1) < count_ ? i ^ 1 : i);
      merged = count_merges();
      total = static_cast<std::uint32_t>(count_ / 2);
    }
    std::uint32_t sum = 0;
    for (std::uint32_t& m : merged) sum += std::exchange(m, sum);
    merge(merged);
    count_ -= total;
    merge_count_ += total;
    std::swap(from_, to_);
    from_.end_at(count_, radius_);
  }

  bool is_mutual(std::size_t i) const { return nearest_[i] != i && nearest_[nearest_[i]] == i; }

  // Each pair is measured once, from its lower place; a block repeats the pairs that reach into it.
  void find_nearest(std::size_t begin, std::size_t end) {
    const std::size_t first = begin - std::min(begin, radius_), room = end + radius_ - first;
    std::vector<float> distances(radius_), least(room, infinity);
    std::vector<std::uint32_t> lowest(room);
    for (std::size_t i = first; i < end; ++i) {
      measure(i, distances.data());
      // Updates the nearest that the following places have seen so far: an earlier place keeps a tie.
      const auto name = static_cast<std::uint32_t>(i);
      float* const theirs = least.data() + (i + 1 - first);
      std::uint32_t* const their_lowest = lowest.data() + (i + 1 - first);
      const float* const d = distances.data();
      for (std::size_t k = 0; k < radius_; ++k) {
        const bool nearer = d[k] < theirs[k];
        their_lowest[k] = nearer ? name : their_lowest[k];
        theirs[k] = nearer ? d[k] : theirs[k];
      }
      // Distances are not negative, so their bits sort as they do.
      std::int32_t nearest_bits = std::bit_cast<std::int32_t>(infinity), nearest_k = 0;
      for (std::size_t k = 0; k < radius_; ++k) nearest_bits = std::min(nearest_bits, std::bit_cast<std::int32_t>(d[k]));
      nearest_k = static_cast<std::int32_t>(radius_);
      for (std::size_t k = 0; k < radius_; ++k)
        nearest_k = std::min(nearest_k, std::bit_cast<std::int32_t>(d[k]) == nearest_bits ? static_cast<std::int32_t>(k) : 256);
      if (i < begin) continue;
      const bool ahead = std::bit_cast<float>(nearest_bits) < least[i - first];
      nearest_[i] = ahead ? static_cast<std::uint32_t>(i + 1) + static_cast<std::uint32_t>(nearest_k) : lowest[i - first];
    }
  }

  // Half the surface area of the union with each of the following places; the largest float where it overflows.
  void measure(std::size_t i, float* distances) const {
    const Bounds own = from_.bounds(i);
    const float *lx = &from_.lower[0][i + 1], *ly = &from_.lower[1][i + 1], *lz = &from_.lower[2][i + 1];
    const float *ux = &from_.upper[0][i + 1], *uy = &from_.upper[1][i + 1], *uz = &from_.upper[2][i + 1];
    const float* largest = &from_.largest[i + 1];
    for (std::size_t k = 0; k < radius_; ++k) {
      const float dx = std::max(ux[k], own.upper.x) - std::min(lx[k], own.lower.x);
      const float dy = std::max(uy[k], own.upper.y) - std::min(ly[k], own.lower.y);
      const float dz = std::max(uz[k], own.upper.z) - std::min(lz[k], own.lower.z);
      const float area = dx * dy + dy * dz + dz * dx;
      distances[k] = area < largest[k] ? area : largest[k];
    }
  }

  std::vector<std::uint32_t> count_merges() {
    std::vector<std::uint32_t> counts((count_ + block_size - 1) / block_size);
    each_block([&](std::size_t block, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) counts[block] += is_mutual(i) && nearest_[i] > i;
    });
    return counts;
  }

  // A pair's union takes the lower one's place; the places of the others close up. A block's first place in the next round: its
  // own, less the higher partners before it.
  void merge(const std::vector<std::uint32_t>& merged_before) {
    std::vector<std::uint32_t> place((count_ + block_size - 1) / block_size);
    each_block([&](std::size_t block, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) place[block] += !(is_mutual(i) && nearest_[i] < i);
    });
    std::uint32_t sum = 0;
    for (std::uint32_t& p : place) sum += std::exchange(p, sum);
    each_block([&](std::size_t block, std::size_t begin, std::size_t end) {
      std::uint32_t to = place[block], index = merge_count_ + merged_before[block];
      for (std::size_t i = begin; i < end; ++i) {
        if (!is_mutual(i))
          to_.set(to++, from_.bounds(i), from_.name[i], from_.size[i], from_.cost[i]);
        else if (nearest_[i] > i)
          unite(i, nearest_[i], to++, index++);
      }
    });
  }

  void unite(std::size_t i, std::size_t j, std::size_t to, std::uint32_t index) {
    Bounds bounds = from_.bounds(i);
    bounds.extend(from_.bounds(j));
    const std::uint32_t size = from_.size[i] + from_.size[j];
    const float area = bounds.half_area(), split_cost = area + from_.cost[i] + from_.cost[j],
                leaf_cost = params_.primitive_cost * area * static_cast<float>(size);
    const bool is_leaf = size <= static_cast<std::uint32_t>(params_.leaf_size) && leaf_cost <= split_cost;
    merges_[index] = {from_.name[i], from_.name[j], size, is_leaf};
    to_.set(to, bounds, item_count_ + index, size, is_leaf ? leaf_cost : split_cost);
  }

  const PlocParams& params_;
  const std::size_t radius_;
  const std::uint32_t item_count_;
  std::size_t count_;
  std::uint32_t merge_count_ = 0;
  Clusters from_, to_;
  std::vector<std::uint32_t> nearest_;
  std::vector<Merge> merges_;
};

class MergeCuts {
 public:
  MergeCuts(std::span<const BuildItem> items, std::span<const Merge> merges, std::uint32_t leaf_size)
      : items_(items), merges_(merges), leaf_size_(leaf_size), order_(items.size()) {}

  std::optional<Cut> best(const Run& run) {
    if (run.handle == no_id) return run.size() <= leaf_size_ ? std::nullopt : std::optional(halve(run));
    const Merge& merge = merge_of(run.handle);
    if (merge.is_leaf) return std::nullopt;
    return Cut{run.begin + size(merge.left), merge.left, merge.right};
  }
  Cut halve(const Run& run) {
    settle(run);
    return {run.begin + run.size() / 2, no_id, no_id};
  }
  // Lists the items of a subtree in its order.
  void settle(const Run& run) {
    if (run.handle == no_id) return;  // a part of what was listed before
    if (is_item(run.handle)) {
      order_[run.begin] = run.handle;
      return;
    }
    std::uint32_t position = run.begin;
    std::vector<std::uint32_t> names{run.handle};
    while (!names.empty()) {
      const std::uint32_t name = names.back();
      names.pop_back();
      if (is_item(name)) {
        order_[position++] = name;
        continue;
      }
      names.push_back(merge_of(name).right);
      names.push_back(merge_of(name).left);
    }
  }
  const BuildItem& item(std::uint32_t position) const { return items_[order_[position]]; }

 private:
  bool is_item(std::uint32_t name) const { return name < items_.size(); }
  const Merge& merge_of(std::uint32_t name) const { return merges_[name - items_.size()]; }
  std::uint32_t size(std::uint32_t name) const { return is_item(name) ? 1 : merge_of(name).size; }

  std::span<const BuildItem> items_;
  std::span<const Merge> merges_;
  std::uint32_t leaf_size_;
  std::vector<std::uint32_t> order_;  // items by position, where they have been listed
};

}  // namespace

BinaryTree build_ploc(BuildItems items, const PlocParams& params) {
  if (items.empty()) return {};
  sort_by_morton_code(items);
  std::vector<Merge> merges;
  const std::uint32_t root = Clustering(items, params).run(merges);
  MergeCuts cuts(items, merges, static_cast<std::uint32_t>(params.leaf_size));
  return TreeLinker(cuts, static_cast<std::uint32_t>(items.size()), params).link(root);
}

RayEntry ploc_entry() {
  return bvh_entry<PlocParams, build_ploc>("ploc",
                                           "bounding volume hierarchy, nearest neighbours along the Morton curve merged", 120);
}

}  // namespace etendue
