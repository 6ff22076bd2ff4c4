#include "accel/point/sphere_bvh.h"

#include "accel/point/placed_points.h"
#include "accel/ray/morton_order.h"

namespace etendue {

static_assert(PointStructure<SphereBvh>);

namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// Squared distances of p to eight points or boxes; NaN where there is none. The order of operations is distance_squared's.
template <std::uint32_t width>
void point_distances(const float (&position)[3][width], const vec3& p, float* out) {
  for (std::uint32_t i = 0; i < width; ++i) {
    const float x = position[0][i] - p.x, y = position[1][i] - p.y, z = position[2][i] - p.z;
    out[i] = x * x + y * y + z * z;
  }
}

template <std::uint32_t width>
void box_distances(const float (&lower)[3][width], const float (&upper)[3][width], const vec3& p, float* out) {
  for (std::uint32_t i = 0; i < width; ++i) {
    // In this order a comparison with NaN yields NaN.
    const auto outside = [&](int axis) {
      const float below = lower[axis][i] - p[axis], above = p[axis] - upper[axis][i];
      const float farther = above > below ? above : below;
      return 0.0f > farther ? 0.0f : farther;
    };
    const float x = outside(0), y = outside(1), z = outside(2);
    out[i] = x * x + y * y + z * z;
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
  std::vector<BuildItem> items;
  resize_on_huge_pages(items, points.size());
  parallel_for(points.size(), 1 << 14, [&](std::size_t i) {
    items[i] = {{points[i], points[i]}, static_cast<std::uint32_t>(i)};
  });
  std::erase_if(items, [](const BuildItem& item) { return !is_finite(item.bounds.lower); });
  if (items.empty()) return;
  sort_by_morton_code(items);

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
}

template <bool sorted, class Limit, class Visit>
void SphereBvh::traverse(const vec3& p, const Limit& limit, const Visit& visit) const {
  struct Waiting {
    Place place;
    float distance;
  };
  std::array<Waiting, width * 11> waiting;  // ten levels above the leaves of 2^32 points
  std::size_t count = 0;
  waiting[count++] = {{static_cast<std::uint32_t>(level_begin_.size() - 1), 0}, 0};
  while (count > 0) {
    const auto [place, distance] = waiting[--count];
    if (!(distance <= limit())) continue;
    if (place.level == 0) {
      visit(leaves_[place.index]);
      continue;
    }
    const Node& here = node(place);
    float distances[width];
    box_distances(here.lower, here.upper, p, distances);
    const std::size_t begin = count;
    for (std::uint32_t i = 0; i < width; ++i) {
      waiting[count] = {{place.level - 1, place.index * width + i}, distances[i]};
      count += distances[i] <= limit();
    }
    if constexpr (sorted)
      std::sort(waiting.begin() + static_cast<std::ptrdiff_t>(begin), waiting.begin() + static_cast<std::ptrdiff_t>(count),
                [](const Waiting& a, const Waiting& b) { return a.distance > b.distance; });
  }
}

void SphereBvh::within(const vec3& p, float r, Neighbours& out) const {
  out.clear();
  if (leaves_.empty() || !can_find(p, r)) return;
  const float limit = r * r;
  traverse<false>(
      p, [limit] { return limit; },
      [&](const Leaf& leaf) {
        float distances[width];
        point_distances(leaf.position, p, distances);
        Neighbour found[width];
        std::size_t count = 0;
        for (std::uint32_t i = 0; i < width; ++i) {
          found[count] = {leaf.id[i], distances[i]};
          count += distances[i] <= limit;
        }
        out.insert(out.end(), found, found + count);
      });
}

void SphereBvh::nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const {
  out.clear();
  if (leaves_.empty() || k == 0 || !can_find(p, r_max)) return;
  NearestSoFar found(k, r_max * r_max, out);
  traverse<true>(
      p, [&] { return found.worst(); },
      [&](const Leaf& leaf) {
        float distances[width];
        point_distances(leaf.position, p, distances);
        for (std::uint32_t i = 0; i < width; ++i) found.add(leaf.id[i], distances[i]);
      });
  found.sort();
}

}  // namespace etendue
