#include "framework/transport/light_tree.h"

#include "framework/core/check.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace etendue {

namespace {

constexpr int bins = 12;               // per axis, at whose borders a node may be split
constexpr int trail_bits = 32;         // nodes on a way from the root that choose
constexpr float cone_slack = 1e-3f;    // radians by which unions of cones, and cosines by which emission, exceed what they hold
constexpr float radius_slack = 1e-4f;  // by which spheres do, of the radius

// Directions within half_angle of the axis.
struct Cone {
  vec3 axis{0, 0, 1};
  float half_angle = -1;  // below 0: of no directions
};

float angle_between(const vec3& a, const vec3& b) { return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)); }

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
  return {glm::normalize(std::cos(turn) * a.axis + std::sin(turn) * towards), half_angle};
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
    const double directions =
        2 * pi * (1 - std::cos(o)) + 0.5 * pi * (2 * w * std::sin(o) - std::cos(o - 2 * w) - 2 * o * std::sin(o) + std::cos(o));
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
    tree_.nodes_.reserve(2 * items_.size());
    tree_.nodes_.emplace_back();
    build(0, items_, 0, 0);
  }

 private:
  struct Item {
    Group light;
    vec3 centre;
    std::uint32_t id;
  };

  // Fills a node, at `depth` choices from the root, and what is below it.
  void build(std::uint32_t node, std::span<Item> items, std::uint32_t trail, int depth) {
    Group whole;
    Bounds centres;
    for (const Item& item : items) {
      whole.add(item.light);
      centres.extend(item.centre);
    }
    tree_.nodes_[node] = node_of(whole);
    if (items.size() == 1) {
      tree_.nodes_[node].first = items[0].id;
      tree_.trails_[items[0].id] = trail;
      return;
    }
    CHECK(depth < trail_bits);
    const std::size_t split = divide(items, whole, centres, trail_bits - depth);
    const auto first = static_cast<std::uint32_t>(tree_.nodes_.size());
    tree_.nodes_[node].first = first;
    tree_.nodes_[node].is_leaf = false;
    tree_.nodes_.resize(tree_.nodes_.size() + 2);
    build(first, items.first(split), trail, depth + 1);
    build(first + 1, items.subspan(split), trail | 1u << depth, depth + 1);
  }

  static Node node_of(const Group& group) {
    Node node;
    const vec3 largest = glm::max(glm::abs(group.bounds.lower), glm::abs(group.bounds.upper));
    node.centre = group.bounds.centre();
    node.radius = 0.5f * glm::length(group.bounds.diagonal()) * (1 + radius_slack) +
                  4 * std::numeric_limits<float>::epsilon() * glm::length(largest);
    node.axis = group.normals.axis;
    node.cos_normals = group.normals.half_angle >= pi ? -1 : std::cos(group.normals.half_angle);
    node.sin_normals = group.normals.half_angle >= pi ? 0 : std::sin(group.normals.half_angle);
    node.least_cosine = group.theta_emission >= pi ? -2 : std::cos(group.theta_emission) - cone_slack;
    node.intensity = static_cast<float>(group.intensity);
    node.two_sided = group.two_sided;
    return node;
  }

  // Where the cost of both sides is least, over bins along each axis; in the middle where no bin divides the items, or where
  // `levels` of choices would not be enough for all.
  std::size_t divide(std::span<Item> items, const Group& whole, const Bounds& centres, int levels) {
    const auto needed = static_cast<int>(std::bit_width(items.size() - 1));
    const vec3 extent = centres.diagonal(), size = whole.bounds.diagonal();
    const int longest = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    double least = std::numeric_limits<double>::infinity();
    int best_axis = longest, best_bin = -1;
    const auto bin_of = [&](const Item& item, int axis) {
      const float at = (item.centre[axis] - centres.lower[axis]) / extent[axis];
      return std::clamp(static_cast<int>(at * bins), 0, bins - 1);
    };
    for (int axis = 0; axis < 3 && needed < levels; ++axis) {
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
};

LightTree::LightTree(std::span<const Emitter> lights) { Builder(*this, lights); }

double LightTree::importance(const Node& node, const vec3& position) {
  const vec3 towards = position - node.centre;
  const double x = towards.x, y = towards.y, z = towards.z, distance2 = x * x + y * y + z * z;
  const double radius2 = static_cast<double>(node.radius) * node.radius;
  // A point light may be at the position itself.
  const double least2 = std::max(0.25 * radius2, 1e-200);
  if (!(distance2 > radius2)) return node.intensity / std::max(distance2, least2);
  float cosine = 1;  // of theta'
  if (node.cos_normals > -1) {
    const auto distance = static_cast<float>(std::sqrt(distance2));
    const float along = glm::dot(node.axis, towards) / distance;
    const float cos_axis = std::min(node.two_sided ? std::abs(along) : along, 1.0f);
    if (cos_axis < node.cos_normals) {
      const float sin_axis = std::sqrt(std::max(0.0f, 1 - cos_axis * cos_axis));
      const float cos_beyond = cos_axis * node.cos_normals + sin_axis * node.sin_normals;
      const float sin_beyond = sin_axis * node.cos_normals - cos_axis * node.sin_normals;
      const float sin_sphere = node.radius / distance, cos_sphere = std::sqrt(std::max(0.0f, 1 - sin_sphere * sin_sphere));
      if (cos_beyond < cos_sphere) cosine = cos_beyond * cos_sphere + sin_beyond * sin_sphere;
    }
    if (cosine < node.least_cosine) return 0;
    cosine = std::max(cosine, cone_slack);
  }
  return node.intensity * static_cast<double>(cosine) / distance2;
}

double LightTree::share_of_first(std::uint32_t first, const vec3& position) const {
  const double a = importance(nodes_[first], position), b = importance(nodes_[first + 1], position);
  return a + b > 0 ? a / (a + b) : -1;
}

LightTree::Chosen LightTree::choose(const vec3& position, double& u) const {
  if (empty()) return {no_id, 0};
  double probability = 1;
  const Node* node = nodes_.data();
  while (!node->is_leaf) {
    const double share = share_of_first(node->first, position);
    if (share < 0) return {no_id, 0};
    const bool second = u >= share;
    const double of_this = second ? 1 - share : share;
    u = std::min((second ? u - share : u) / of_this, 0x1.fffffffffffffp-1);
    probability *= of_this;
    node = &nodes_[node->first + (second ? 1 : 0)];
  }
  return {node->first, probability};
}

double LightTree::probability(const vec3& position, std::uint32_t light) const {
  if (empty()) return 0;
  double probability = 1;
  const Node* node = nodes_.data();
  for (std::uint32_t trail = trails_[light]; !node->is_leaf; trail >>= 1) {
    const double share = share_of_first(node->first, position);
    if (share < 0) return 0;
    const bool second = (trail & 1u) != 0;
    probability *= second ? 1 - share : share;
    node = &nodes_[node->first + (second ? 1 : 0)];
  }
  return node->first == light ? probability : 0;
}

}  // namespace etendue
