#include "integrators/guiding/guided_directions.h"

#include "framework/core/arc.h"
#include "framework/core/sampling.h"

#include <limits>

namespace etendue {

namespace {

constexpr float below_one = 0x1.fffffep-1f;
constexpr std::size_t most_nodes = 65535;  // as far as a child's index counts

// The quadrant that a point lies in; the point becomes its place there. Without a branch: it could not be predicted.
int descend(vec2& square) {
  square *= 2.0f;
  const int right = square.x >= 1, top = square.y >= 1;
  square -= vec2(right, top);
  return right + 2 * top;
}

}  // namespace

vec2 square_from_direction(const vec3& direction) {
  return glm::clamp(vec2(0.5f * (direction.z + 1), turn_of(direction.x, direction.y)), 0.0f, below_one);
}

vec3 direction_from_square(const vec2& square) {
  const float z = 2 * square.x - 1, radius = safe_sqrt(1 - z * z);
  const auto turn = cos_sin_of_turn(square.y);
  return {radius * turn.cosine, radius * turn.sine, z};
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

DirectionDensity::Split::Split(float low, float high) : Split() {
  if (!(low + high > 0)) return;
  share = low / (low + high);
  if (share < std::numeric_limits<float>::min()) share = 0;  // whose reciprocal would be infinite
  stretch = {1 / share, 1 / (1 - share)};  // an empty half is not chosen
}

bool DirectionDensity::Split::choose(float& u) const {
  const bool upper = u >= share;
  const float begin = float_of(bits_of(share) & (upper ? 0xffffffffu : 0u));
  u = std::min((u - begin) * stretch[upper], below_one);
  return upper;
}

DirectionDensity::DirectionDensity(const DirectionTree& learnt) : nodes_(learnt.nodes_.size()) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const DirectionTree::Node& from = learnt.nodes_[i];
    const auto& flux = from.flux;
    const float all = DirectionTree::sum(from);
    if (!(all > 0)) continue;  // even, and what is below it too
    Node& node = nodes_[i];
    node.x = {flux[0] + flux[2], flux[1] + flux[3]};
    node.y = {Split(flux[0], flux[2]), Split(flux[1], flux[3])};
    for (std::size_t quadrant = 0; quadrant < 4; ++quadrant) node.density[quadrant] = 4 * flux[quadrant] / all;
    node.child = from.child;
  }
}

float DirectionDensity::density(const vec2& square) const {
  vec2 place = square;
  float density = 1;
  for (std::size_t index = 0;;) {
    const Node& node = nodes_[index];
    const int quadrant = descend(place);
    density *= node.density[quadrant];
    index = node.child[quadrant];
    if (index == 0) return density;
  }
}

DirectionDensity::Sample DirectionDensity::sample(vec2 u) const {
  vec2 corner(0);
  float size = 1, density = 1;
  for (std::size_t index = 0;;) {
    const Node& node = nodes_[index];
    // First the half in x, then the quarter within it; u becomes its place in what was chosen.
    const bool right = node.x.choose(u.x), top = node.y[right].choose(u.y);
    const int quadrant = right + 2 * top;
    density *= node.density[quadrant];
    size *= 0.5f;
    corner += size * vec2(right, top);
    index = node.child[quadrant];
    if (index == 0) break;
  }
  return {glm::min(corner + size * u, below_one), density};
}

}  // namespace etendue
