#include "accel/points/sphere_bvh.h"

#include "accel/bvh/build/morton_order.h"
#include "accel/points/placed_points.h"

namespace etendue {

static_assert(PointStructure<SphereBvh>);

namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

using Lanes = float __attribute__((vector_size(16), may_alias));

// Squared distances of p to eight points or boxes; NaN where there is none. The order of operations is distance_squared's.
void point_distances(const float (&position)[3][8], const vec3& p, float (&out)[8]) {
  for (int half = 0; half < 8; half += 4) {
    const auto offset = [&](int axis) { return *reinterpret_cast<const Lanes*>(position[axis] + half) - p[axis]; };
    const Lanes x = offset(0), y = offset(1), z = offset(2);
    *reinterpret_cast<Lanes*>(out + half) = x * x + y * y + z * z;
  }
}

void box_distances(const float (&lower)[3][8], const float (&upper)[3][8], const vec3& p, float (&out)[8]) {
  for (int half = 0; half < 8; half += 4) {
    const auto outside = [&](int axis) {
      const Lanes below = *reinterpret_cast<const Lanes*>(lower[axis] + half) - p[axis];
      const Lanes above = p[axis] - *reinterpret_cast<const Lanes*>(upper[axis] + half), zero = {};
      const Lanes farther = above > below ? above : below;
      return zero > farther ? zero : farther;  // in this order a comparison with NaN yields NaN
    };
    const Lanes x = outside(0), y = outside(1), z = outside(2);
    *reinterpret_cast<Lanes*>(out + half) = x * x + y * y + z * z;
  }
}

// Four times the squared distances of p to the boxes' centres.
void centre_distances(const float (&lower)[3][8], const float (&upper)[3][8], const vec3& p, float (&out)[8]) {
  for (int half = 0; half < 8; half += 4) {
    const auto offset = [&](int axis) {
      return *reinterpret_cast<const Lanes*>(lower[axis] + half) + *reinterpret_cast<const Lanes*>(upper[axis] + half) -
             2 * p[axis];
    };
    const Lanes x = offset(0), y = offset(1), z = offset(2);
    *reinterpret_cast<Lanes*>(out + half) = x * x + y * y + z * z;
  }
}

}  // namespace

Bounds SphereBvh::bounds_of_leaf(std::size_t leaf) const {
  Bounds bounds;
  const auto& position = leaves_[leaf].position;
  for (std::uint32_t i = 0; i < width && position[0][i] == position[0][i]; ++i)
    bounds.extend(vec3(position[0][i], position[1][i], position[2][i]));
  return bounds;
}

Bounds SphereBvh::bounds_of_node(const Node& node) {
  Bounds bounds;
  for (std::uint32_t i = 0; i < width && node.lower[0][i] == node.lower[0][i]; ++i) {
    bounds.extend(vec3(node.lower[0][i], node.lower[1][i], node.lower[2][i]));
    bounds.extend(vec3(node.upper[0][i], node.upper[1][i], node.upper[2][i]));
  }
  return bounds;
}

void SphereBvh::build(std::span<const vec3> points) {
  leaves_.clear();
  nodes_.clear();
  level_begin_.assign(1, 0);
  BuildItems items(points.size());
  parallel_for(points.size(), 1 << 14, [&](std::size_t i) {
    items[i] = {{points[i], points[i]}, static_cast<std::uint32_t>(i)};
  });
  std::erase_if(items, [](const BuildItem& item) { return !is_finite(item.bounds.lower); });
  if (items.empty()) return;
  sort_by_morton_code(items);
  count_ = items.size();

  resize_on_huge_pages(leaves_, (items.size() + width - 1) / width);
  parallel_for(leaves_.size(), 1 << 10, [&](std::size_t leaf) {
    for (std::uint32_t i = 0; i < width; ++i) {
      const std::size_t item = leaf * width + i;
      const bool there = item < items.size();
      for (int axis = 0; axis < 3; ++axis) leaves_[leaf].position[axis][i] = there ? items[item].bounds.lower[axis] : nan;
      leaves_[leaf].id[i] = there ? items[item].id : no_id;
    }
  });
  std::size_t below = leaves_.size();
  for (std::size_t level = 1; level == 1 || below > 1; ++level) {
    const std::size_t count = (below + width - 1) / width, begin = nodes_.size();
    level_begin_.push_back(begin);
    nodes_.resize(begin + count);
    parallel_for(count, 1 << 10, [&](std::size_t n) {
      for (std::uint32_t i = 0; i < width; ++i) {
        const std::size_t child = n * width + i;
        Bounds bounds{vec3(nan), vec3(nan)};
        if (child < below)
          bounds = level == 1 ? bounds_of_leaf(child) : bounds_of_node(nodes_[level_begin_[level - 1] + child]);
        for (int axis = 0; axis < 3; ++axis) {
          nodes_[begin + n].lower[axis][i] = bounds.lower[axis];
          nodes_[begin + n].upper[axis][i] = bounds.upper[axis];
        }
      }
    });
    below = count;
  }
  bounds_ = bounds_of_node(nodes_.back());
}

bool SphereBvh::find(const vec3& p, float r, std::size_t most, Neighbours& out) const {
  out.clear();
  if (leaves_.empty() || !can_find(p, r)) return true;
  const float limit = r * r;
  std::array<Place, width * 11> waiting;  // ten levels above the leaves of 2^32 points
  std::size_t count = 0;
  waiting[count++] = {root_level(), 0, 0};
  alignas(32) float distances[width];
  while (count > 0) {
    const std::uint32_t level = waiting[--count].level, index = waiting[count].index;
    if (level > 0) {
      const Node& here = node(level, index);
      box_distances(here.lower, here.upper, p, distances);
      for (std::uint32_t i = 0; i < width; ++i) {
        waiting[count] = {level - 1, index * width + i, distances[i]};
        count += distances[i] <= limit;
      }
      continue;
    }
    const Leaf& leaf = leaves_[index];
    point_distances(leaf.position, p, distances);
    Neighbour found[width];
    std::size_t within = 0;
    for (std::uint32_t i = 0; i < width; ++i) {
      found[within] = {leaf.id[i], distances[i]};
      within += distances[i] <= limit;
    }
    out.insert(out.end(), found, found + within);
    if (out.size() > most) return false;
  }
  return true;
}

// The distance of the second nearest point; of the nearest where there is one only.
float SphereBvh::first_radius(const vec3& p) const {
  alignas(32) float distances[width];
  float first = infinity, second = infinity;
  const auto look_into = [&](const Leaf& leaf) {
    point_distances(leaf.position, p, distances);
    for (const float d2 : distances) {
      if (!(d2 < second)) continue;
      second = std::max(first, d2);
      first = std::min(first, d2);
    }
  };
  // The first pass goes down to the child whose centre is nearest (boxes that the curve's leaps make large have theirs far
  // off), where the points most often are. The second finds all that is nearer.
  std::uint32_t down = 0;
  for (std::uint32_t level = root_level(); level > 0; --level) {
    centre_distances(node(level, down).lower, node(level, down).upper, p, distances);
    std::uint32_t nearest = 0;
    for (std::uint32_t i = 1; i < width; ++i)
      if (distances[i] < distances[nearest]) nearest = i;
    down = down * width + nearest;
  }
  look_into(leaves_[down]);
  std::array<Place, width * 11> waiting;
  std::size_t count = 0;
  waiting[count++] = {root_level(), 0, 0};
  while (count > 0) {
    const auto [level, index, distance] = waiting[--count];
    if (!(distance < second)) continue;
    if (level == 0) {
      if (index != down) look_into(leaves_[index]);
      continue;
    }
    box_distances(node(level, index).lower, node(level, index).upper, p, distances);
    for (std::uint32_t i = 0; i < width; ++i) {
      waiting[count] = {level - 1, index * width + i, distances[i]};
      count += distances[i] < second;
    }
  }
  return std::sqrt(second < infinity ? second : first);
}

void SphereBvh::nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const {
  out.clear();
  if (leaves_.empty() || k == 0 || !can_find(p, r_max)) return;
  const float smallest = std::max(1e-6f * max_component(bounds_.diagonal()), 1e-30f);
  nearest_by_growing_balls(*this, count_, bounds_, std::max(first_radius(p), smallest), p, k, r_max, out);
}

}  // namespace etendue
