#include "accel/records/octree.h"

namespace etendue {

static_assert(RecordStructure<RecordOctree>);

namespace {

constexpr float epsilon = std::numeric_limits<float>::epsilon();
constexpr float largest_half = 1e30f;    // the root grows no further
constexpr float smallest_half = 1e-18f;  // and its descendants no smaller

unsigned octant(const vec3& centre, const vec3& p) {
  return static_cast<unsigned>(p.x > centre.x) | static_cast<unsigned>(p.y > centre.y) << 1 |
         static_cast<unsigned>(p.z > centre.z) << 2;
}

// The step from a cube's centre to an octant's, or (towards a point) to the doubled cube's.
vec3 towards(unsigned octant, float step) {
  return {octant & 1 ? step : -step, octant & 2 ? step : -step, octant & 4 ? step : -step};
}

bool lies_within(const vec3& centre, float half, const vec3& p) { return max_component(glm::abs(p - centre)) <= half; }

}  // namespace

RecordOctree::RecordOctree(const Bounds& bounds) {
  const bool usable = !bounds.empty() && is_finite(bounds.lower) && is_finite(bounds.upper);
  const float half = usable ? 0.5f * max_component(bounds.diagonal()) : 0;
  root_ = add_node(usable ? bounds.centre() : vec3(0), half > 0 ? std::min(half, largest_half) : 1);
}

// A sphere of radius up to half the side may stand anywhere in the cube, hence a reach of one side; the rest is rounding, of
// the radius, of coordinates, and of squares too small for a float.
std::uint32_t RecordOctree::add_node(const vec3& centre, float half) {
  const float rounding = 8 * epsilon * (max_component(glm::abs(centre)) + 2 * half) + 1e-22f;
  nodes_.push_back({centre, half, 2 * half + rounding, no_id, {}});
  nodes_.back().children.fill(no_id);
  return static_cast<std::uint32_t>(nodes_.size() - 1);
}

void RecordOctree::grow_towards(const vec3& centre) {
  while (!lies_within(nodes_[root_].centre, nodes_[root_].half, centre) && nodes_[root_].half < largest_half) {
    const Node old = nodes_[root_];
    const unsigned direction = octant(old.centre, centre);
    const std::uint32_t grown = add_node(old.centre + towards(direction, old.half), 2 * old.half);
    nodes_[grown].children[~direction & 7] = root_;
    // What was too large for the old root may be so for the new one: the root is where it is found for certain.
    std::swap(nodes_[grown].spheres, nodes_[root_].spheres);
    root_ = grown;
  }
}

void RecordOctree::insert(const vec3& centre, float radius, std::uint32_t id) {
  if (!is_record_sphere(centre, radius)) return;
  grow_towards(centre);
  std::uint32_t node = root_;
  // Goes down while the sphere fits the child: radius at most half its side, and cubes large enough for floats to keep apart.
  if (lies_within(nodes_[root_].centre, nodes_[root_].half, centre)) {
    const auto can_halve = [](const Node& n) {
      return n.half > std::max(smallest_half, 64 * epsilon * max_component(glm::abs(n.centre)));
    };
    while (radius <= 0.5f * nodes_[node].half && can_halve(nodes_[node])) {
      const unsigned i = octant(nodes_[node].centre, centre);
      if (nodes_[node].children[i] == no_id) {
        const float half = 0.5f * nodes_[node].half;
        const std::uint32_t child = add_node(nodes_[node].centre + towards(i, half), half);
        nodes_[node].children[i] = child;
      }
      node = nodes_[node].children[i];
    }
  }
  spheres_.push_back({{centre, radius, id}, nodes_[node].spheres});
  nodes_[node].spheres = static_cast<std::uint32_t>(spheres_.size() - 1);
}

void RecordOctree::collect(const Node& node, const vec3& p, Neighbours& out) const {
  for (std::uint32_t i = node.spheres; i != no_id; i = spheres_[i].next) add_if_covering(spheres_[i].sphere, p, out);
}

void RecordOctree::covering(const vec3& p, Neighbours& out) const {
  out.clear();
  // A query stands near at most 8 cubes of one level, each of which may have 7 siblings waiting.
  thread_local std::vector<std::uint32_t> waiting;
  waiting.assign(1, root_);
  while (!waiting.empty()) {
    const Node& node = nodes_[waiting.back()];
    waiting.pop_back();
    collect(node, p, out);
    for (const std::uint32_t child : node.children)
      if (child != no_id && lies_within(nodes_[child].centre, nodes_[child].reach, p)) waiting.push_back(child);
  }
  sort_by_id(out);
}

}  // namespace etendue
