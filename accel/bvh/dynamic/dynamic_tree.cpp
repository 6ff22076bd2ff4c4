#include "accel/bvh/dynamic/dynamic_tree.h"

#include "framework/core/check.h"
#include "framework/core/parallel.h"

#include <atomic>

namespace etendue {

namespace {

// The factor by which `work` per `area` has grown: 0 where there is no work, infinity where there was none before.
float times(float work, float area, float built_work, float built_area) {
  if (!(work > 0) || !(area > 0)) return 0;
  return built_work > 0 && built_area > 0 ? work / area * built_area / built_work : infinity;
}

}  // namespace

DynamicTree::DynamicTree(std::vector<Bounds> boxes, Build build, const ChangePolicy& policy)
    : build_(std::move(build)),
      policy_(policy),
      boxes_(std::move(boxes)),
      present_(boxes_.size()),
      changed_(boxes_.size()),
      leaf_of_(boxes_.size()) {
  CHECK_LT(boxes_.size(), std::size_t{1} << 31);
  Bounds all;
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    present_[i] = !boxes_[i].empty();
    if (present_[i]) all.extend(boxes_[i]);
  }
  const vec3 middle = all.empty() ? vec3(0) : all.centre();
  for (std::size_t i = 0; i < boxes_.size(); ++i)
    if (!present_[i]) boxes_[i] = {middle, middle};  // where it waits until it appears
  rebuild_all();
}

TreeUpdate DynamicTree::update(std::span<const std::uint32_t> changed, std::span<const Bounds> boxes) {
  CHECK_EQ(changed.size(), boxes.size());
  for (const std::uint32_t leaf : touched_) is_touched_[leaf] = 0;
  touched_.clear();
  if (changed.empty()) return {};
  take_boxes(changed, boxes);
  if (policy_.kind == ChangePolicy::Kind::rebuild) {
    rebuild_all();
    return {0, boxes_.size(), 1};
  }
  for (const std::uint32_t item : changed) {
    touch(leaf_of_[item]);
    changed_count_ += !changed_[item];
    changed_[item] = 1;
  }
  order_touched();
  refit();
  const std::uint64_t refitted = touched_.size();
  TreeUpdate done;
  if (is_hybrid() && static_cast<double>(changed_count_) >=
                         static_cast<double>(policy_.hybrid.changed_fraction) * static_cast<double>(boxes_.size())) {
    done = rebuild_worsened();
    if (done.subtrees > 0) {
      std::fill(changed_.begin(), changed_.end(), 0);
      changed_count_ = 0;
    }
  }
  done.refitted = refitted;
  layout_.set_root(node_bounds(0), heights_[0]);
  return done;
}

void DynamicTree::take_boxes(std::span<const std::uint32_t> changed, std::span<const Bounds> boxes) {
  parallel_for(changed.size(), update_grain, [&](std::size_t i) {
    const std::uint32_t item = changed[i];
    present_[item] = !boxes[i].empty();
    if (present_[item]) boxes_[item] = {boxes[i].lower + 0.0f, boxes[i].upper + 0.0f};  // no negative zeros
  });
}

void DynamicTree::touch(std::uint32_t leaf) {
  if (is_touched_[leaf]) return;
  is_touched_[leaf] = 1;
  touched_.push_back(leaf);
}

// Leaves lie in memory as their nodes do: where many are touched, taking them in their order saves more than sorting costs.
void DynamicTree::order_touched() {
  if (touched_.size() < leaves_.size() / 16) return;
  touched_.clear();
  for (std::uint32_t leaf = 0; leaf < leaves_.size(); ++leaf)
    if (is_touched_[leaf]) touched_.push_back(leaf);
}

void DynamicTree::rebuild_all() {
  layout_.clear();
  links_.clear();
  heights_.clear();
  costs_.clear();
  waiting_.clear();
  leaves_.clear();
  is_touched_.clear();
  free_nodes_.clear();
  free_leaves_.clear();
  touched_.clear();
  layout_.set_root({}, 0);
  if (boxes_.empty()) return;
  Region region{0, {}, {}, {}, {}, {}};
  region.parts.resize(boxes_.size());
  region.items.resize(boxes_.size());
  parallel_for(boxes_.size(), update_grain, [&](std::size_t i) {
    region.parts[i] = static_cast<std::uint32_t>(i);
    region.items[i] = {boxes_[i], static_cast<std::uint32_t>(i)};
  });
  region.tree = build_(std::move(region.items));
  emit(region, root_link);
  layout_.set_root(node_bounds(0), heights_[0]);
}

// --- refitting ---

void DynamicTree::refit() {
  parallel_for(touched_.size(), update_grain, [&](std::size_t i) { climb_and_mark(touched_[i]); });
  parallel_for(touched_.size(), update_grain, [&](std::size_t i) { climb_and_fit(touched_[i]); });
}

// The first to reach a node goes on; whoever comes later only says that there is one more to wait for.
void DynamicTree::climb_and_mark(std::uint32_t leaf) {
  for (std::uint32_t link = leaves_[leaf].link; link != root_link; link = links_[link / 2])
    if (std::atomic_ref(waiting_[link / 2]).fetch_add(1, std::memory_order_relaxed) > 0) return;
}

// The last to reach a node goes on: then both its children are fitted.
void DynamicTree::climb_and_fit(std::uint32_t leaf) {
  TreeNode child{leaf_bounds(leaf), leaf, 1};
  for (std::uint32_t link = leaves_[leaf].link; link != root_link;) {
    const std::uint32_t node = link / 2;
    hang(link, child);
    if (std::atomic_ref(waiting_[node]).fetch_sub(1, std::memory_order_acq_rel) > 1) return;
    child = {fit(node), node, 0};
    link = links_[node];
  }
}

// Derives from the children of a node its cost, and its box, which is returned.
Bounds DynamicTree::fit(std::uint32_t node) {
  const TreeNode left = layout_.child(node, 0), right = layout_.child(node, 1);
  Bounds box = left.bounds;
  box.extend(right.bounds);
  if (is_hybrid()) {
    const Areas a = areas_of(left), b = areas_of(right);
    Cost& cost = costs_[node];
    cost.now = {box.half_area() + a.work + b.work, box.half_area(), a.items + b.items};
    cost.growth = growth_of(cost);
  }
  return box;
}

float DynamicTree::growth_of(const Cost& cost) {
  const auto& [now, built, growth] = cost;
  return std::max(times(now.work, now.box, built.work, built.box), times(now.work, now.items, built.work, built.items));
}

DynamicTree::Areas DynamicTree::areas_of(const TreeNode& child) const {
  if (!child.is_leaf()) return costs_[child.first].now;
  std::array<std::uint32_t, leaf_size> items;
  const std::uint32_t count = present_items(child.first, items);
  Areas areas{child.bounds.half_area() * static_cast<float>(count), 0, 0};
  for (std::uint32_t i = 0; i < count; ++i) areas.items += boxes_[items[i]].half_area();
  return areas;
}

Bounds DynamicTree::leaf_bounds(std::uint32_t leaf) const {
  std::array<std::uint32_t, leaf_size> items;
  const std::uint32_t count = present_items(leaf, items);
  Bounds box;
  for (std::uint32_t i = 0; i < count; ++i) box.extend(boxes_[items[i]]);
  return box;
}

Bounds DynamicTree::node_bounds(std::uint32_t node) const {
  Bounds box = layout_.child(node, 0).bounds;
  box.extend(layout_.child(node, 1).bounds);
  return box;
}

std::uint32_t DynamicTree::present_items(std::uint32_t leaf, std::array<std::uint32_t, leaf_size>& items) const {
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < leaves_[leaf].count; ++i)
    if (const std::uint32_t item = leaves_[leaf].items[i]; present_[item]) items[count++] = item;
  return count;
}

double DynamicTree::sah_cost() const {
  if (leaves_.empty()) return 0;
  double cost = node_bounds(0).half_area();
  std::vector<std::uint32_t> nodes{0};
  std::array<std::uint32_t, leaf_size> items;
  while (!nodes.empty()) {
    const std::uint32_t node = nodes.back();
    nodes.pop_back();
    for (int side = 0; side < 2; ++side) {
      const TreeNode child = layout_.child(node, side);
      const std::uint32_t weight = child.is_leaf() ? present_items(child.first, items) : 1;
      cost += static_cast<double>(child.bounds.half_area()) * weight;
      if (!child.is_leaf()) nodes.push_back(child.first);
    }
  }
  const double root_area = node_bounds(0).half_area();
  return root_area > 0 && std::isfinite(root_area) ? cost / root_area : 0;
}

std::uint64_t DynamicTree::bytes() const {
  const std::uint64_t per_item = sizeof(Bounds) + 2 + sizeof(std::uint32_t), per_leaf = sizeof(Leaf) + 1;
  const std::uint64_t per_node = 2 * sizeof(std::uint32_t) + sizeof(Cost) + 1;
  return layout_.bytes() + boxes_.size() * per_item + leaves_.size() * per_leaf + links_.size() * per_node;
}

}  // namespace etendue
