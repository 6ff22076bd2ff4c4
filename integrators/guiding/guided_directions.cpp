#include "integrators/guiding/guided_directions.h"

namespace etendue {

namespace {

constexpr float below_one = 0x1.fffffep-1f;
constexpr std::size_t most_nodes = 65535;  // as far as a child's index counts

// The quadrant that a point lies in; the point becomes its place there.
int descend(vec2& square) {
  square *= 2.0f;
  int quadrant = 0;
  for (int axis = 0; axis < 2; ++axis)
    if (square[axis] >= 1) {
      square[axis] -= 1;
      quadrant |= 1 << axis;
    }
  return quadrant;
}

}  // namespace

vec2 square_from_direction(const vec3& direction) {
  const float turn = std::atan2(direction.y, direction.x) / (2 * pi);
  return glm::clamp(vec2(0.5f * (direction.z + 1), turn < 0 ? turn + 1 : turn), 0.0f, below_one);
}

vec3 direction_from_square(const vec2& square) {
  const float z = 2 * square.x - 1, radius = safe_sqrt(1 - z * z), phi = 2 * pi * square.y;
  return {radius * std::cos(phi), radius * std::sin(phi), z};
}

void DirectionTree::add(const vec2& square, float flux) {
  vec2 place = square;
  for (std::size_t node = 0;;) {
    const int quadrant = descend(place);
    nodes_[node].flux[quadrant] += flux;
    node = nodes_[node].child[quadrant];
    if (node == 0) return;
  }
}

float DirectionTree::density(const vec2& square) const {
  vec2 place = square;
  float density = 1;
  for (std::size_t index = 0;;) {
    const Node& node = nodes_[index];
    const float all = sum(node);
    if (!(all > 0)) return density;
    const int quadrant = descend(place);
    density *= 4 * node.flux[quadrant] / all;
    index = node.child[quadrant];
    if (index == 0 || density == 0) return density;
  }
}

DirectionTree::Sample DirectionTree::sample(vec2 u) const {
  vec2 corner(0);
  float size = 1, density = 1;
  for (std::size_t index = 0;;) {
    const Node& node = nodes_[index];
    const float all = sum(node);
    if (!(all > 0)) break;
    // First the half in x, then the quarter within it; u becomes its place in what was chosen.
    const auto choose = [](float& u, float low, float high) {
      const float share = low / (low + high);
      const bool upper = u >= share;
      u = std::min(upper ? (u - share) / (1 - share) : u / share, below_one);
      return upper;
    };
    const bool right = choose(u.x, node.flux[0] + node.flux[2], node.flux[1] + node.flux[3]);
    const bool top = choose(u.y, node.flux[right], node.flux[2 + right]);
    const int quadrant = right + 2 * top;
    density *= 4 * node.flux[quadrant] / all;
    size *= 0.5f;
    corner += size * vec2(right, top);
    index = node.child[quadrant];
    if (index == 0) break;
  }
  return {glm::min(corner + size * u, below_one), density};
}

DirectionTree DirectionTree::refined(float rho) const {
  struct Open {
    std::size_t to;  // node of the new tree
    int from;        // node of this one; -1 below its leaves, where flux counts as evenly spread
    float flux;
    int depth;
  };
  DirectionTree out;
  const float least = rho * flux();
  std::vector<Open> open{{0, 0, flux(), 1}};
  while (!open.empty()) {
    const Open here = open.back();
    open.pop_back();
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const float flux = here.from < 0 ? here.flux / 4 : nodes_[here.from].flux[quadrant];
      if (!(flux > least) || here.depth >= deepest || out.nodes_.size() > most_nodes) continue;
      const int child = here.from < 0 ? 0 : nodes_[here.from].child[quadrant];
      out.nodes_[here.to].child[quadrant] = static_cast<std::uint16_t>(out.nodes_.size());
      open.push_back({out.nodes_.size(), child == 0 ? -1 : child, flux, here.depth + 1});
      out.nodes_.emplace_back();
    }
  }
  return out;
}

}  // namespace etendue
