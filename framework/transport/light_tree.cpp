#include "framework/transport/light_tree.h"

#include "framework/core/check.h"
#include "framework/core/elementary.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace etendue {

namespace {

constexpr int bins = 12;             // per axis, at whose borders a node may be split
constexpr int levels = 32;           // of choices at most, for which a trail has room
constexpr float cone_slack = 1e-3f;  // radians by which unions of cones, and cosines by which emission, exceed what they hold
constexpr std::uint32_t leaf_bit = 0x80000000u;  // of a child that is a light
constexpr float least_distance2 = 1e-36f;        // m^2, so that no weight overflows
constexpr float radius_slack = 1e-4f;            // by which spheres do, of the radius

// Four numbers of a node's children.
using Four = float __attribute__((vector_size(16)));
constexpr Four one{1, 1, 1, 1};

Four load(const float* numbers) {
  Four four;
  std::memcpy(&four, numbers, sizeof(four));
  return four;
}
Four larger(Four a, Four b) { return a > b ? a : b; }
// 0 of what is negative.
Four root(Four a) {
  a = larger(a, 0 * one);
#if defined(__SSE2__)
  return _mm_sqrt_ps(a);
#else
  for (int i = 0; i < 4; ++i) a[i] = std::sqrt(a[i]);
  return a;
#endif
}

// Directions within half_angle of the axis.
struct Cone {
  vec3 axis{0, 0, 1};
  float half_angle = -1;  // below 0: of no directions
};

float angle_between(const vec3& a, const vec3& b) { return math::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)); }

// The smallest that holds both, and a little more.
Cone united(Cone a, Cone b) {
  if (a.half_angle < b.half_angle) std::swap(a, b);
  if (b.half_angle < 0 || a.half_angle >= pi) return a;
  const float between = angle_between(a.axis, b.axis);
  if (between + b.half_angle <= a.half_angle) return a;
  const float half_angle = 0.5f * (a.half_angle + between + b.half_angle) + cone_slack;
  const vec3 across = glm::cross(a.axis, b.axis);
  const float sine = glm::length(across);
  if (half_angle >= pi || !(sine > 0))
    return between > 0.5f * pi || half_angle >= pi ? Cone{a.axis, pi} : Cone{a.axis, half_angle};
  const float turn = half_angle - a.half_angle;
  const vec3 towards = glm::cross(across / sine, a.axis);  // from a's axis, in the plane of both
  return {glm::normalize(math::cos(turn) * a.axis + math::sin(turn) * towards), half_angle};
}

// Lights together, as an Emitter.
struct Group {
  Bounds bounds;
  Cone normals;
  float theta_emission = 0;
  double intensity = 0;
  bool two_sided = false;

  void add(const Group& other) {
    bounds.extend(other.bounds);
    normals = united(normals, other.normals);
    theta_emission = std::max(theta_emission, other.theta_emission);
    intensity += other.intensity;
    two_sided |= other.two_sided;
  }
  // The surface area orientation heuristic: intensity times the measure of directions times the area of the box.
  double cost() const {
    if (!(intensity > 0)) return 0;
    const double o = normals.half_angle, w = std::min<double>(o + theta_emission, pi);
    const double sine = math::sin(o), cosine = math::cos(o);
    const double directions = 2 * pi * (1 - cosine) + 0.5 * pi * (2 * w * sine - math::cos(o - 2 * w) - 2 * o * sine + cosine);
    const dvec3 d = bounds.diagonal();
    return intensity * directions * 2 * (d.x * d.y + d.y * d.z + d.z * d.x);
  }
};

}  // namespace

class LightTree::Builder {
 public:
  Builder(LightTree& tree, std::span<const Emitter> lights) : tree_(tree) {
    for (std::uint32_t i = 0; i < lights.size(); ++i) {
      const Emitter& e = lights[i];
      if (!(e.intensity > 0)) continue;
      items_.push_back(
          {{e.bounds, {e.axis, e.theta_normals}, e.theta_emission, e.intensity, e.two_sided}, e.bounds.centre(), i});
    }
    tree_.trails_.assign(lights.size(), 0);
    if (items_.empty()) return;
    halves_.reserve(2 * items_.size());
    halves_.emplace_back();
    halve(0, items_, 0);
    total_ = halves_[0].group.intensity;
    tree_.nodes_.emplace_back();
    fill(0, 0, 0, 0);
  }

 private:
  struct Item {
    Group light;
    vec3 centre;
    std::uint32_t id;
  };
  // A node of the binary tree that is built first.
  struct Half {
    Group group;
    bool is_leaf = true;
    std::uint32_t first = 0;  // child of two; of a leaf, the light
  };

  // Fills a half, at `depth` choices from the root, and what is below it.
  void halve(std::uint32_t half, std::span<Item> items, int depth) {
    Group whole;
    Bounds centres;
    for (const Item& item : items) {
      whole.add(item.light);
      centres.extend(item.centre);
    }
    halves_[half].group = whole;
    if (items.size() == 1) {
      halves_[half].first = items[0].id;
      return;
    }
    const std::size_t split = divide(items, whole, centres, levels - depth);
    const auto first = static_cast<std::uint32_t>(halves_.size());
    halves_[half].first = first;
    halves_[half].is_leaf = false;
    halves_.resize(halves_.size() + 2);
    halve(first, items.first(split), depth + 1);
    halve(first + 1, items.subspan(split), depth + 1);
  }

  // Fills a node of the wide tree with the children of a binary one, of which those of the largest cost are opened.
  void fill(std::uint32_t node, std::uint32_t binary, std::uint64_t trail, int depth) {
    CHECK(depth < levels);
    std::vector<std::uint32_t> children{binary};
    while (children.size() < width) {
      const auto inner = [&](std::uint32_t i) { return halves_[i].is_leaf ? -1.0 : halves_[i].group.cost(); };
      const auto largest = std::max_element(children.begin(), children.end(),
                                            [&](std::uint32_t l, std::uint32_t r) { return inner(l) < inner(r); });
      if (halves_[*largest].is_leaf) break;
      const std::uint32_t first = halves_[*largest].first;
      *largest = first;
      children.push_back(first + 1);
    }
    for (int i = 0; i < static_cast<int>(children.size()); ++i) {
      const Half& child = halves_[children[i]];
      const std::uint64_t way = trail | static_cast<std::uint64_t>(i) << (2 * depth);
      set_child(tree_.nodes_[node], i, child.group);
      if (child.is_leaf) {
        tree_.nodes_[node].child[i] = child.first | leaf_bit;
        tree_.trails_[child.first] = way;
        continue;
      }
      const auto next = static_cast<std::uint32_t>(tree_.nodes_.size());
      tree_.nodes_.emplace_back();
      tree_.nodes_[node].child[i] = next;
      fill(next, children[i], way, depth + 1);
    }
  }

  void set_child(Node& node, int i, const Group& group) const {
    const vec3 largest = glm::max(glm::abs(group.bounds.lower), glm::abs(group.bounds.upper)), centre = group.bounds.centre();
    const float normals = group.normals.half_angle;
    node.x[i] = centre.x;
    node.y[i] = centre.y;
    node.z[i] = centre.z;
    node.radius[i] = 0.5f * glm::length(group.bounds.diagonal()) * (1 + radius_slack) +
                     4 * std::numeric_limits<float>::epsilon() * glm::length(largest);
    node.axis_x[i] = group.normals.axis.x;
    node.axis_y[i] = group.normals.axis.y;
    node.axis_z[i] = group.normals.axis.z;
    node.cos_normals[i] = normals >= pi ? -2 : math::cos(normals);
    node.sin_normals[i] = normals >= pi ? 0 : math::sin(normals);
    node.least_cosine[i] = group.theta_emission >= pi ? -2 : math::cos(group.theta_emission) - cone_slack;
    node.intensity[i] = static_cast<float>(group.intensity / total_);
    node.two_sided[i] = group.two_sided ? 1.0f : 0.0f;
  }

  // Divides the items where the cost of both sides is least, over bins along each axis; or in the middle where no bin divides
  // them, or where `levels_left` of choices would not be enough for all.
  std::size_t divide(std::span<Item> items, const Group& whole, const Bounds& centres, int levels_left) {
    const auto needed = static_cast<int>(std::bit_width(items.size() - 1));
    const vec3 extent = centres.diagonal(), size = whole.bounds.diagonal();
    const int longest = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    double least = std::numeric_limits<double>::infinity();
    int best_axis = longest, best_bin = -1;
    const auto bin_of = [&](const Item& item, int axis) {
      const float at = (item.centre[axis] - centres.lower[axis]) / extent[axis];
      return std::clamp(static_cast<int>(at * bins), 0, bins - 1);
    };
    for (int axis = 0; axis < 3 && needed < levels_left; ++axis) {
      if (!(extent[axis] > 0)) continue;
      std::array<Group, bins> groups;
      std::array<std::size_t, bins> counts{};
      for (const Item& item : items) {
        const int bin = bin_of(item, axis);
        groups[bin].add(item.light);
        ++counts[bin];
      }
      std::array<double, bins> above{};  // cost of all from a bin on
      Group sum;
      for (int i = bins - 1; i > 0; --i) {
        sum.add(groups[i]);
        above[i] = sum.cost();
      }
      sum = {};
      const double regular = max_component(size) / static_cast<double>(size[axis]);  // thin boxes are split across
      std::size_t below = 0;
      for (int i = 0; i + 1 < bins; ++i) {
        sum.add(groups[i]);
        below += counts[i];
        if (below == 0 || below == items.size()) continue;
        const double cost = regular * (sum.cost() + above[i + 1]);
        if (cost < least) {
          least = cost;
          best_axis = axis;
          best_bin = i;
        }
      }
    }
    if (best_bin >= 0) {
      const auto middle =
          std::partition(items.begin(), items.end(), [&](const Item& i) { return bin_of(i, best_axis) <= best_bin; });
      return static_cast<std::size_t>(middle - items.begin());
    }
    const std::size_t half = items.size() / 2;
    std::nth_element(
        items.begin(), items.begin() + static_cast<std::ptrdiff_t>(half), items.end(),
        [&](const Item& a, const Item& b) { return std::pair(a.centre[longest], a.id) < std::pair(b.centre[longest], b.id); });
    return half;
  }

  LightTree& tree_;
  std::vector<Item> items_;
  std::vector<Half> halves_;
  double total_ = 0;  // intensity
};

LightTree::LightTree(std::span<const Emitter> lights) { Builder(*this, lights); }

// Weighs all four children at once, without a branch.
LightTree::Weights LightTree::importance(const Node& node, const vec3& position) {
  const Four x = position.x - load(node.x), y = position.y - load(node.y), z = position.z - load(node.z);
  const Four radius = load(node.radius), radius2 = radius * radius;
  const Four distance2 = x * x + y * y + z * z, over_distance = 1 / root(distance2);
  const Four along = (load(node.axis_x) * x + load(node.axis_y) * y + load(node.axis_z) * z) * over_distance;
  const Four cos_axis = ((load(node.two_sided) > 0) & (along < 0)) ? -along : along, sin_sphere = radius * over_distance;
  const Four sin_axis = root(1 - cos_axis * cos_axis), cos_sphere = root(1 - sin_sphere * sin_sphere);
  const Four cos_normals = load(node.cos_normals), sin_normals = load(node.sin_normals);
  const Four cos_beyond = cos_axis * cos_normals + sin_axis * sin_normals;  // of theta_w - theta_o
  const Four sin_beyond = sin_axis * cos_normals - cos_axis * sin_normals;
  const auto is_beyond = (distance2 > radius2) & (cos_axis < cos_normals) & (cos_beyond < cos_sphere);
  const Four cosine = is_beyond ? cos_beyond * cos_sphere + sin_beyond * sin_sphere : one;  // of theta'
  const Four least2 = larger(0.25f * radius2, least_distance2 * one);
  const Four weight = larger(cosine, cone_slack * one) * (load(node.intensity) / larger(distance2, least2));
  const Four reaching = cosine < load(node.least_cosine) ? 0 * one : weight;
  Weights weights;
  std::memcpy(weights.each, &reaching, sizeof(reaching));
  weights.sum = (static_cast<double>(reaching[0]) + reaching[1]) + (static_cast<double>(reaching[2]) + reaching[3]);
  return weights;
}

LightTree::Chosen LightTree::choose(const vec3& position, double& u) const {
  if (empty()) return {no_id, 0};
  // The numbers that lead here begin at `begin` and are as many as `probability` says.
  double begin = 0, probability = 1;
  std::uint32_t next = 0;
  while ((next & leaf_bit) == 0) {
    const Node& node = nodes_[next];
    const Weights weights = importance(node, position);
    if (!(weights.sum > 0)) return {no_id, 0};
    // The ends of the children's numbers, times the sum of weights: the choice need not wait for a division.
    const double number = (u - begin) * weights.sum, first = weights.each[0] * probability;
    const double second = first + weights.each[1] * probability, third = second + weights.each[2] * probability;
    int chosen = (number >= first ? 1 : 0) + (number >= second ? 1 : 0) + (number >= third ? 1 : 0);
    while (!(weights.each[chosen] > 0)) chosen = (chosen + width - 1) % width;  // rounding may lead beyond the last that counts
    const double before[width] = {0, first, second, third};
    begin += before[chosen] / weights.sum;
    probability *= weights.each[chosen] / weights.sum;
    next = node.child[chosen];
  }
  u = std::clamp((u - begin) / probability, 0.0, 0x1.fffffffffffffp-1);
  return {next & ~leaf_bit, probability};
}

double LightTree::probability(const vec3& position, std::uint32_t light) const {
  if (empty()) return 0;
  double probability = 1;
  std::uint32_t next = 0;
  for (std::uint64_t trail = trails_[light]; (next & leaf_bit) == 0; trail >>= 2) {
    const Node& node = nodes_[next];
    const Weights weights = importance(node, position);
    const auto child = static_cast<int>(trail & 3);
    if (!(weights.each[child] > 0)) return 0;
    probability *= weights.each[child] / weights.sum;
    next = node.child[child];
  }
  return next == (light | leaf_bit) ? probability : 0;
}

}  // namespace etendue
