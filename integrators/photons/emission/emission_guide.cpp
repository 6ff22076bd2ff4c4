#include "integrators/photons/emission/emission_guide.h"

#include "integrators/photons/photon_wave.h"

namespace etendue {

namespace {

constexpr float uniform_part = 0.1f;
constexpr std::size_t fewest_pilots = 32, fewest_useful = 3, fewest_useful_of_quarters = 32;
constexpr int deepest = 40;
constexpr std::uint32_t rounds = 4;

struct Tally {
  std::size_t count = 0, useful_count = 0;
  float all = 0, useful = 0;  // weights

  void add(const EmissionGuide::Pilot& pilot) {
    ++count;
    all += pilot.weight;
    if (!pilot.useful) return;
    ++useful_count;
    useful += pilot.weight;
  }
  // Root of the useful share, which one pilot of mean weight, half of it useful, draws away from 0 and 1.
  float root() const {
    const float one = count > 0 ? all / static_cast<float>(count) : 1;
    return std::sqrt((useful + 0.5f * one) / (all + one));
  }
};

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

int EmissionGuide::widest_difference(std::span<const Pilot> pilots, const Cell& cell, int parts, float below) {
  int best = -1;
  for (int d = 0; d < emission_dimensions; ++d) {
    const float scale = static_cast<float>(parts) / (cell.upper[d] - cell.lower[d]);
    Tally tallies[4];
    for (const Pilot& pilot : pilots)
      tallies[std::min(parts - 1, static_cast<int>((pilot.numbers[d] - cell.lower[d]) * scale))].add(pilot);
    float root = 0;
    for (int part = 0; part < parts; ++part) root += tallies[part].root() / static_cast<float>(parts);
    if (root < below) {
      below = root;
      best = d;
    }
  }
  return best;
}

std::uint32_t EmissionGuide::grow(std::span<Pilot> pilots, const Cell& cell, int depth) {
  const auto id = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({});
  Tally tally;
  for (const Pilot& pilot : pilots) tally.add(pilot);
  nodes_[id].mass = cell.volume() * tally.root();
  if (depth >= deepest || tally.count < fewest_pilots || tally.useful_count < fewest_useful) return id;

  int best = widest_difference(pilots, cell, 2, 0.98f * tally.root());
  // A useful region in the middle makes quarters differ and not halves; quarters of few useful pilots differ by chance.
  if (best < 0 && tally.useful_count >= fewest_useful_of_quarters)
    best = widest_difference(pilots, cell, 4, 0.95f * tally.root());
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

EmissionGuide learn_guide(const RenderContext& context, const RoughMaterials& rough_materials, const PhotonPass& pass,
                          std::uint32_t pilot_count) {
  const std::uint64_t key = hash_keys(pass.key, 1);
  std::vector<EmissionGuide::Pilot> pilots(pilot_count), so_far;
  const PathNumbers of_pilots(context.seed, pass, key);
  EmissionGuide guide({});
  for (std::uint32_t round = 0; round < rounds; ++round) {
    const std::uint32_t begin = pilot_count / rounds * round,
                        end = round + 1 < rounds ? begin + pilot_count / rounds : pilot_count;
    trace_in_chunks(end - begin, [&](std::uint32_t first, std::uint32_t last, Photons& out) {
      const auto share = [&](std::uint32_t i, EmissionNumbers& numbers) {
        const float density = guide.warp(numbers);
        pilots[i] = {numbers, 1 / density, false};
        return 1.0f;
      };
      PhotonWave wave(context, rough_materials, pass);
      wave.trace(of_pilots, begin + first, begin + last, share, out, [&](std::uint32_t i) { pilots[i].useful = true; });
      out.clear();
    });
    so_far.assign(pilots.begin(), pilots.begin() + end);
    guide = EmissionGuide(so_far);
  }
  return guide;
}

}  // namespace

Photons trace_by_importance(const RenderContext& context, const RoughMaterials& rough_materials, const PhotonPass& pass) {
  const std::uint32_t pilots = pass.count / 4, count = pass.count - pilots;
  const EmissionGuide guide = learn_guide(context, rough_materials, pass, pilots);
  const PathNumbers of_pass(context.seed, pass, pass.key);
  const float share = 1 / static_cast<float>(count);
  return trace_in_chunks(count, [&](std::uint32_t first, std::uint32_t last, Photons& out) {
    const auto guided = [&](std::uint32_t, EmissionNumbers& numbers) { return share / guide.warp(numbers); };
    PhotonWave(context, rough_materials, pass).trace(of_pass, first, last, guided, out);
  });
}

}  // namespace etendue
