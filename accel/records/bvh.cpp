#include "accel/records/bvh.h"

namespace etendue {

static_assert(RecordStructure<RecordBvh>);

namespace {

float margin(const Bounds& b) {
  const vec3 d = b.upper - b.lower;
  return d.x + d.y + d.z;
}

Bounds joined(Bounds a, const Bounds& b) {
  a.extend(b);
  return a;
}

}  // namespace

RecordBvh::Leaf::Leaf() {
  std::fill_n(&centre[0][0], 3 * width, 0.0f);
  std::fill_n(radius_squared, width, std::numeric_limits<float>::quiet_NaN());
}

RecordBvh::Node::Node() {
  std::fill_n(&lower[0][0], 3 * width, infinity);
  std::fill_n(&upper[0][0], 3 * width, -infinity);
}

// The box holds every point with a float distance^2 <= radius^2.
Bounds RecordBvh::box_of(const RecordSphere& sphere) {
  return {sphere.centre - reach(sphere.radius), sphere.centre + reach(sphere.radius)};
}

void RecordBvh::put(Leaf& leaf, std::uint32_t i, const Entry& entry) {
  for (int axis = 0; axis < 3; ++axis) leaf.centre[axis][i] = entry.sphere.centre[axis];
  leaf.radius[i] = entry.sphere.radius;
  leaf.radius_squared[i] = square(entry.sphere.radius);
  leaf.id[i] = entry.sphere.id;
}

void RecordBvh::put(Node& node, std::uint32_t i, const Entry& entry) {
  for (int axis = 0; axis < 3; ++axis) {
    node.lower[axis][i] = entry.box.lower[axis];
    node.upper[axis][i] = entry.box.upper[axis];
  }
  node.child[i] = entry.child;
}

RecordBvh::Entry RecordBvh::get(const Leaf& leaf, std::uint32_t i) {
  const RecordSphere sphere{{leaf.centre[0][i], leaf.centre[1][i], leaf.centre[2][i]}, leaf.radius[i], leaf.id[i]};
  return {box_of(sphere), sphere, no_id};
}

RecordBvh::Entry RecordBvh::get(const Node& node, std::uint32_t i) {
  return {{{node.lower[0][i], node.lower[1][i], node.lower[2][i]}, {node.upper[0][i], node.upper[1][i], node.upper[2][i]}},
          {},
          node.child[i]};
}

Bounds RecordBvh::box_of(const Leaf& leaf) {
  Bounds box;
  for (std::uint32_t i = 0; i < leaf.count; ++i) box.extend(get(leaf, i).box);
  return box;
}

Bounds RecordBvh::box_of(const Node& node) {
  Bounds box;
  for (std::uint32_t i = 0; i < node.count; ++i) box.extend(get(node, i).box);
  return box;
}

// Orders the entries for the best cut and returns how many are before it.
std::uint32_t RecordBvh::best_cut(Overflow& entries) {
  constexpr std::uint32_t count = width + 1;
  Overflow best = entries;
  std::uint32_t best_position = fewest;
  float least = infinity;
  for (int axis = 0; axis < 3; ++axis) {
    std::stable_sort(entries.begin(), entries.end(), [axis](const Entry& a, const Entry& b) {
      return a.box.lower[axis] + a.box.upper[axis] < b.box.lower[axis] + b.box.upper[axis];
    });
    std::array<float, count> behind{};  // margin of entries i, i + 1, ...
    Bounds box;
    for (std::uint32_t i = count - 1; i >= fewest; --i) behind[i] = margin(box = joined(box, entries[i].box));
    box = {};
    for (std::uint32_t i = 1; i <= count - fewest; ++i) {
      box.extend(entries[i - 1].box);
      if (i < fewest || !(margin(box) + behind[i] < least)) continue;
      least = margin(box) + behind[i];
      best_position = i;
      best = entries;
    }
  }
  entries = best;
  return best_position;
}

std::uint32_t RecordBvh::best_child(const Node& node, const Bounds& box) {
  std::uint32_t best = 0;
  float least_growth = infinity, least_margin = infinity;
  for (std::uint32_t i = 0; i < node.count; ++i) {
    const Bounds child = get(node, i).box;
    const float size = margin(child), growth = margin(joined(child, box)) - size;
    if (!(growth < least_growth || (growth == least_growth && size < least_margin))) continue;
    best = i;
    least_growth = growth;
    least_margin = size;
  }
  return best;
}

// Adds to a node or leaf. Where it is full, cuts it and returns the index of the new sibling; else no_id.
template <class Kind>
std::uint32_t RecordBvh::add(std::vector<Kind>& all, std::uint32_t index, const Entry& entry) {
  if (Kind& here = all[index]; here.count < width) {
    put(here, here.count++, entry);
    return no_id;
  }
  Overflow entries;
  for (std::uint32_t i = 0; i < width; ++i) entries[i] = get(all[index], i);
  entries[width] = entry;
  const std::uint32_t cut = best_cut(entries);
  Kind lower, upper;
  for (std::uint32_t i = 0; i <= width; ++i) {
    Kind& half = i < cut ? lower : upper;
    put(half, half.count++, entries[i]);
  }
  all[index] = lower;
  all.push_back(upper);
  return static_cast<std::uint32_t>(all.size() - 1);
}

void RecordBvh::insert(const vec3& centre, float radius, std::uint32_t id) {
  if (!is_record_sphere(centre, radius)) return;
  const RecordSphere sphere{centre, radius, id};
  if (radius > 1e30f) return everywhere_.push_back(sphere);
  if (leaves_.empty()) leaves_.emplace_back();
  const Entry entry{box_of(sphere), sphere, no_id};
  struct Step {
    std::uint32_t node, child;
  };
  std::array<Step, 32> path;
  std::uint32_t at = root_;
  for (std::uint32_t depth = 0; depth < height_; ++depth) {
    const std::uint32_t child = best_child(nodes_[at], entry.box);
    path[depth] = {at, child};
    at = nodes_[at].child[child];
  }
  std::uint32_t sibling = add(leaves_, at, entry);
  for (std::uint32_t depth = height_; depth-- > 0;) {
    const bool above_leaves = depth + 1 == height_;
    const auto box = [&](std::uint32_t child) { return above_leaves ? box_of(leaves_[child]) : box_of(nodes_[child]); };
    const auto [node, child] = path[depth];
    Entry grown = get(nodes_[node], child);
    grown.box = sibling == no_id ? joined(grown.box, entry.box) : box(grown.child);
    put(nodes_[node], child, grown);
    if (sibling != no_id) sibling = add(nodes_, node, {box(sibling), {}, sibling});
  }
  if (sibling == no_id) return;
  Node root;
  for (const std::uint32_t child : {root_, sibling})
    put(root, root.count++, {height_ == 0 ? box_of(leaves_[child]) : box_of(nodes_[child]), {}, child});
  nodes_.push_back(root);
  root_ = static_cast<std::uint32_t>(nodes_.size() - 1);
  ++height_;
}

void RecordBvh::covering(const vec3& p, Neighbours& out) const {
  out.clear();
  if (!is_finite(p)) return;
  for (const RecordSphere& sphere : everywhere_) add_if_covering(sphere, p, out);
  struct Waiting {
    std::uint32_t index, level;  // level 0: a leaf
  };
  std::array<Waiting, width * 24> waiting;
  std::size_t count = 0;
  if (!leaves_.empty()) waiting[count++] = {root_, height_};
  while (count > 0) {
    const auto [index, level] = waiting[--count];
    if (level == 0) {
      const Leaf& leaf = leaves_[index];
      for (std::uint32_t i = 0; i < width; ++i) {
        const float d2 = distance_squared(vec3(leaf.centre[0][i], leaf.centre[1][i], leaf.centre[2][i]), p);
        if (d2 <= leaf.radius_squared[i]) out.push_back({leaf.id[i], d2});
      }
      continue;
    }
    const Node& node = nodes_[index];
    for (std::uint32_t i = 0; i < width; ++i) {
      const bool inside = (p.x >= node.lower[0][i]) & (p.x <= node.upper[0][i]) & (p.y >= node.lower[1][i]) &
                          (p.y <= node.upper[1][i]) & (p.z >= node.lower[2][i]) & (p.z <= node.upper[2][i]);
      waiting[count] = {node.child[i], level - 1};
      count += inside;
    }
  }
  sort_by_id(out);
}

}  // namespace etendue
