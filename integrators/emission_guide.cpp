#include "integrators/emission_guide.h"

namespace etendue {

namespace {

constexpr float uniform_part = 0.1f;
constexpr std::size_t fewest_pilots = 32, fewest_useful = 8;
constexpr int deepest = 40;

// Of the useful share, towards one half when there are few pilots to tell.
float root_of_share(std::size_t useful, std::size_t all) {
  return std::sqrt((static_cast<float>(useful) + 0.5f) / (static_cast<float>(all) + 1));
}

}  // namespace

float EmissionGuide::Cell::volume() const {
  float volume = 1;
  for (int d = 0; d < emission_dimensions; ++d) volume *= upper[d] - lower[d];
  return volume;
}

EmissionGuide::EmissionGuide(std::span<Pilot> pilots) {
  Cell all;
  all.upper.fill(1);
  grow(pilots, all, 0);
  // The uniform part, now that the total is known; then each node's density is relative to the whole.
  const float total = nodes_[0].mass;
  const auto mix = [&](auto& self, std::uint32_t id, const Cell& cell) -> void {
    Node& node = nodes_[id];
    node.mass = uniform_part * cell.volume() + (1 - uniform_part) * node.mass / total;
    if (node.dimension < 0) return;
    const auto d = static_cast<std::size_t>(node.dimension);
    Cell lower = cell, upper = cell;
    lower.upper[d] = upper.lower[d] = 0.5f * (cell.lower[d] + cell.upper[d]);
    self(self, node.lower, lower);
    self(self, node.upper, upper);
    const float below = nodes_[node.lower].mass;
    node.lower_share = below / (below + nodes_[node.upper].mass);
  };
  mix(mix, 0, all);
}

std::uint32_t EmissionGuide::grow(std::span<Pilot> pilots, const Cell& cell, int depth) {
  const auto id = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({});
  const auto useful =
      static_cast<std::size_t>(std::count_if(pilots.begin(), pilots.end(), [](const Pilot& p) { return p.useful; }));
  const float undivided = root_of_share(useful, pilots.size());
  nodes_[id].mass = cell.volume() * undivided;
  if (depth >= deepest || pilots.size() < fewest_pilots || useful < fewest_useful) return id;

  // The dimension whose halves differ most.
  int best = -1;
  float best_root = 0.98f * undivided;
  for (int d = 0; d < emission_dimensions; ++d) {
    const float middle = 0.5f * (cell.lower[d] + cell.upper[d]);
    std::size_t below = 0, useful_below = 0;
    for (const Pilot& p : pilots) {
      below += p.numbers[d] < middle;
      useful_below += p.useful && p.numbers[d] < middle;
    }
    const float root =
        0.5f * (root_of_share(useful_below, below) + root_of_share(useful - useful_below, pilots.size() - below));
    if (root < best_root) {
      best_root = root;
      best = d;
    }
  }
  if (best < 0) return id;

  Cell lower_cell = cell, upper_cell = cell;
  const float middle = lower_cell.upper[best] = upper_cell.lower[best] = 0.5f * (cell.lower[best] + cell.upper[best]);
  const auto split =
      std::partition(pilots.begin(), pilots.end(), [&](const Pilot& p) { return p.numbers[best] < middle; }) - pilots.begin();
  const std::uint32_t lower = grow(pilots.first(static_cast<std::size_t>(split)), lower_cell, depth + 1);
  const std::uint32_t upper = grow(pilots.subspan(static_cast<std::size_t>(split)), upper_cell, depth + 1);
  nodes_[id] = {best, 0, lower, upper, nodes_[lower].mass + nodes_[upper].mass};
  return id;
}

float EmissionGuide::warp(EmissionNumbers& numbers) const {
  constexpr float below_one = 0x1.fffffep-1f;
  Cell cell;
  cell.upper.fill(1);
  const Node* node = nodes_.data();
  while (node->dimension >= 0) {
    const auto d = static_cast<std::size_t>(node->dimension);
    const float middle = 0.5f * (cell.lower[d] + cell.upper[d]);
    float& u = numbers[d];
    if (u < node->lower_share) {
      u = std::min(u / node->lower_share, below_one);
      cell.upper[d] = middle;
      node = &nodes_[node->lower];
    } else {
      u = std::min((u - node->lower_share) / (1 - node->lower_share), below_one);
      cell.lower[d] = middle;
      node = &nodes_[node->upper];
    }
  }
  for (int d = 0; d < emission_dimensions; ++d)
    numbers[d] = std::min(cell.lower[d] + numbers[d] * (cell.upper[d] - cell.lower[d]), below_one);
  return node->mass / cell.volume();
}

namespace {

// Independent numbers for a pilot, noted; or the guided ones of a photon.
struct NotedNumbers {
  SampledNumbers numbers;
  EmissionNumbers& noted;
  EmissionNumbers emission() { return noted = numbers.emission(); }
  vec2 pair() { return numbers.pair(); }
};

struct GuidedNumbers {
  SampledNumbers numbers;
  const EmissionNumbers& warped;
  const EmissionNumbers& emission() const { return warped; }
  vec2 pair() { return numbers.pair(); }
};

}  // namespace

Photons trace_by_importance(const RenderContext& context, const Receivers& receivers, const PhotonPass& pass) {
  const std::uint32_t pilot_count = pass.count / 4, count = pass.count - pilot_count;
  const std::uint64_t pilot_key = hash_keys(pass.key, 1);
  std::vector<EmissionGuide::Pilot> pilots(pilot_count);
  trace_in_chunks(pilot_count, [&](std::uint32_t first, std::uint32_t last, Photons& out) {
    PhotonTracer tracer(context, receivers, pass);
    for (std::uint32_t i = first; i < last; ++i, out.clear()) {
      NotedNumbers numbers{{context, pass, pilot_key, i}, pilots[i].numbers};
      pilots[i].useful = tracer.trace(numbers, 1, out);
    }
  });
  const EmissionGuide guide(pilots);

  const float share = 1 / static_cast<float>(count);
  return trace_in_chunks(count, [&](std::uint32_t first, std::uint32_t last, Photons& out) {
    PhotonTracer tracer(context, receivers, pass);
    for (std::uint32_t i = first; i < last; ++i) {
      SampledNumbers uniform(context, pass, pass.key, i);
      EmissionNumbers warped = uniform.emission();
      const float density = guide.warp(warped);
      GuidedNumbers numbers{uniform, warped};
      tracer.trace(numbers, share / density, out);
    }
  });
}

}  // namespace etendue
