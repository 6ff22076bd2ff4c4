#include "integrators/path_space/path_space_grid.h"

#include "framework/core/elementary.h"
#include "framework/core/parallel.h"
#include "framework/core/rng.h"

#include <bit>
#include <numeric>

namespace etendue {

namespace {

constexpr std::size_t shard_count = 128;

// Variance of an answer, relative to the variance of a cell's values over their number, as if they all weighed the same. On
// each axis its own cell is asked with probability 1 - a, a its distance from the centre in edges, else the next one, and each
// answers by its plane about the middle of where it is asked: (1 - a)^2 + a^2 for the means and 6 a^2 (1 - a)^2 for the slopes,
// over a in [0, 1/2].
constexpr float of_smooth_planes = 32.0f / 45;
constexpr float parent_excess = 1.0f / 3;  // an error of second order is this part of what it exceeds it by at twice the size
constexpr float kept = 0.5f;               // of the values so far, when as many are to come again
constexpr std::uint32_t normals = 7 * 7 * 7;      // that tags tell apart
constexpr std::uint32_t no_normal = normals / 2;  // the middle one of them, of length 0

std::uint64_t hash(const glm::ivec3& cell, std::uint32_t tag) {
  const auto bits = [](int x) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)); };
  return mix_bits(mix_bits(bits(cell.x) | bits(cell.y) << 32) ^ (bits(cell.z) | std::uint64_t{tag} << 32));
}

// Normals by steps of a third along each axis, and the depth.
std::uint32_t tag_of(const vec3& normal, int depth) {
  const glm::uvec3 steps(glm::floor(3.0f * normal + 3.5f));
  return ((static_cast<std::uint32_t>(depth) * 7 + steps.x) * 7 + steps.y) * 7 + steps.z;
}

// The tangent plane that all normals of a tag share.
const Frame& plane_of(std::uint32_t tag) {
  static const auto planes = [] {
    std::array<Frame, normals> all;
    for (std::uint32_t i = 0; i < normals; ++i)
      all[i] = Frame::from_normal(glm::normalize(vec3(i / 49, i / 7 % 7, i % 7) - 3.0f));
    return all;
  }();
  return planes[tag % normals];
}

// How far a cell reaches from its centre along the plane's axes, in edges.
vec2 reach_in(const Frame& plane) {
  const auto half_extent = [](const vec3& axis) { return 0.5f * (std::abs(axis.x) + std::abs(axis.y) + std::abs(axis.z)); };
  return {half_extent(plane.tangent), half_extent(plane.bitangent)};
}

vec2 in_plane(const Frame& plane, const vec3& v) { return {glm::dot(v, plane.tangent), glm::dot(v, plane.bitangent)}; }

// Reads and writes in one order: `io` is a ByteWriter's add or a ByteReader's take.
template <class Io, class Key>
void transfer(const Io& io, Key& at, PlaneMoments& cell) {
  io(at.cell.x), io(at.cell.y), io(at.cell.z), io(at.tag), io(cell.count), io(cell.squared_weights);
  io(cell.place.x), io(cell.place.y), io(cell.place_square), io(cell.value), io(cell.value_x), io(cell.value_y),
      io(cell.square);
}

}  // namespace

// The slot of the key, or the free slot where it would be.
std::size_t PathSpaceGrid::Table::slot_of(const Key& key) const {
  const std::size_t mask = slots.size() - 1;
  std::size_t i = hash(key.cell, key.tag) & mask;
  while (slots[i].cell != 0 && slots[i].key != key) i = (i + 1) & mask;
  return i;
}

const PlaneMoments* PathSpaceGrid::Table::find(const Key& key) const {
  if (cells.empty()) return nullptr;
  const Slot& slot = slots[slot_of(key)];
  return slot.cell != 0 ? &cells[slot.cell - 1] : nullptr;
}

void PathSpaceGrid::Table::add(const Key& key, const PlaneMoments& moments) {
  if (2 * (cells.size() + 1) > slots.size()) grow();
  Slot& slot = slots[slot_of(key)];
  if (slot.cell == 0) {
    cells.emplace_back();
    keys.push_back(key);
    slot = {key, static_cast<std::uint32_t>(cells.size())};
  }
  cells[slot.cell - 1] += moments;
}

void PathSpaceGrid::Table::grow() {
  std::vector<Slot> old(std::max<std::size_t>(64, 2 * slots.size()));
  slots.swap(old);
  for (const Slot& slot : old)
    if (slot.cell != 0) slots[slot_of(slot.key)] = slot;
}

void PathSpaceGrid::Table::clear() {
  if (cells.empty()) return;
  std::fill(slots.begin(), slots.end(), Slot{});
  keys.clear();
  cells.clear();
}

// The grid's origin is off the scene's corner by odd shares, so that no cell's face lies in an axis-parallel wall.
PathSpaceGrid::PathSpaceGrid(const Bounds& bounds, const PathSpaceGridOptions& options)
    : options_(options), shards_(shard_count) {
  const Bounds box = bounds.empty() ? Bounds{vec3(-1), vec3(1)} : bounds;
  size_ = std::max(glm::length(box.diagonal()), 1e-6f);
  origin_ = box.lower - size_ * vec3(0.0137f, 0.0211f, 0.0173f);
  begin(0);
}

void PathSpaceGrid::begin(std::uint32_t index) {
  const float samples = static_cast<float>(index) + 1;
  finest_ = options_.finest * math::pow(samples, -1.0f / 6);
  enough_ = options_.enough * math::pow(samples, 2.0f / 3);
  if (index < 2 || !std::has_single_bit(index)) return;
  parallel_for(shard_count, 1, [&](std::size_t s) {
    for (Table& table : shards_[s].levels)
      for (PlaneMoments& cell : table.cells) cell *= kept;
  });
}

vec2 PathSpaceGrid::place_in(const Key& key, const Frame& plane, const vec3& position, int level) {
  return in_plane(plane, position * static_cast<float>(1 << level) - (vec3(key.cell) + 0.5f));
}

int PathSpaceGrid::finest_level(const vec3& position) const {
  const float spread = options_.parallel ? 1 : glm::length(position - options_.eye);
  const float wanted = finest_ * options_.pixel_angle * spread;
  return std::clamp(std::ilogb(size_ / std::max(wanted, 1e-30f)), coarsest, deepest);
}

// All that a lookup may ask about one coarsest cell lies in one shard.
PathSpaceGrid::Place PathSpaceGrid::place(const vec3& position, std::uint32_t tag) const {
  const vec3 at = in_grid(position);
  return {at, tag, &shards_[hash(cell_of(at, coarsest), tag) % shard_count]};
}

void PathSpaceGrid::add(std::span<const std::vector<CachedValue>> values) {
  // A counting sort by shard that keeps the order.
  std::vector<std::size_t> first{0};
  for (const auto& some : values) first.push_back(first.back() + some.size());
  std::vector<std::uint8_t> shard(first.back());
  parallel_for(values.size(), 1, [&](std::size_t i) {
    for (std::size_t k = 0; k < values[i].size(); ++k)
      shard[first[i] + k] = static_cast<std::uint8_t>(
          place(values[i][k].position, tag_of(values[i][k].normal, values[i][k].depth)).shard - shards_.data());
  });
  std::vector<std::size_t> begin(shard_count + 1, 0);
  for (const std::uint8_t s : shard) ++begin[s + 1u];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<const CachedValue*> sorted(shard.size());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  for (std::size_t i = 0, at = 0; i < values.size(); ++i)
    for (const CachedValue& value : values[i]) sorted[next[shard[at++]]++] = &value;
  parallel_for(shard_count, 1,
               [&](std::size_t s) { add_to(shards_[s], std::span(sorted).subspan(begin[s], begin[s + 1] - begin[s])); });
}

void PathSpaceGrid::add_to(Shard& shard, std::span<const CachedValue* const> values) const {
  for (const CachedValue* value : values) {
    const int level = finest_level(value->position);
    const std::uint32_t tag = tag_of(value->normal, value->depth);
    const vec3 position = in_grid(value->position);
    const Key at{cell_of(position, level), tag};
    const vec2 place = place_in(at, plane_of(tag), position, level);
    shard.fresh[static_cast<std::size_t>(level)].add(at, PlaneMoments::of(place, value->value));
  }
  for (std::size_t level = deepest; level >= coarsest; --level) {
    Table& fresh = shard.fresh[level];
    for (std::size_t i = 0; i < fresh.cells.size(); ++i) {
      const Key& at = fresh.keys[i];
      shard.levels[level].add(at, fresh.cells[i]);
      if (level == coarsest) continue;
      const vec2 centre = in_plane(plane_of(at.tag), 0.5f * vec3(at.cell & 1) - 0.25f);
      shard.fresh[level - 1].add({at.cell >> 1, at.tag}, fresh.cells[i].in_coarser(centre));
    }
    fresh.clear();
  }
}

float PathSpaceGrid::scatter() const {
  double sum = 0, count = 0;
  for (const Shard& shard : shards_)
    for (const PlaneMoments& cell : shard.levels[coarsest].cells) {
      const float mean = luminance(cell.value) / cell.count;
      if (mean > 0) sum += cell.count * safe_sqrt(cell.square / cell.count / etendue::square(mean) - 1);
      count += cell.count;
    }
  return count > 0 ? static_cast<float>(sum / count) : 0;
}

std::optional<Rgb> PathSpaceGrid::mean(const vec3& position, const vec3& normal, int depth) const {
  const Place at = place(position, tag_of(normal, depth));
  for (int level = finest_level(position); level >= coarsest; --level)
    if (const auto found = answer(at, level, enough_)) return found;
  return std::nullopt;
}

// The place at which a point is looked up in cells of a level: beside it, or its own if nothing answers there.
std::optional<PathSpaceGrid::Place> PathSpaceGrid::jittered(const Place& at, const vec3& position, const vec3& offset,
                                                            int level, float enough) const {
  const Place beside = place(position + edge(level) * offset, at.tag);
  if (find(beside, level, enough)) return beside;
  return find(at, level, enough) ? std::optional(at) : std::nullopt;
}

PathSpaceGrid::Lookup PathSpaceGrid::look_up(const vec3& position, const vec3& normal, int depth, const vec2& u) const {
  const Frame frame = Frame::from_normal(normal);
  const vec3 offset = (u.x - 0.5f) * frame.tangent + (u.y - 0.5f) * frame.bitangent;
  const Place at = place(position, tag_of(normal, depth));
  for (int level = finest_level(position); level >= coarsest; --level)
    if (const auto found = jittered(at, position, offset, level, enough_)) return {*found, level, at, offset};
  return {at, find(at, coarsest, 0) ? coarsest : -1, at, offset};
}

std::optional<Rgb> PathSpaceGrid::smooth_mean(const vec3& position, const vec3& normal, int depth, const vec2& u) const {
  const Lookup found = look_up(position, normal, depth, u);
  return found.level < 0 ? std::nullopt : answer(found.place, found.level, 0);
}

// The answer of a point's cell, if it has enough values.
std::optional<Rgb> PathSpaceGrid::answer(const Place& at, int level, float enough) {
  const PlaneMoments* cell = find(at, level, enough);
  if (cell == nullptr) return std::nullopt;
  const Frame& plane = plane_of(at.tag);
  return cell->fit(place_in(at.key(level), plane, at.position, level), reach_in(plane));
}

const PlaneMoments* PathSpaceGrid::find(const Place& at, int level, float enough) {
  const PlaneMoments* cell = at.shard->levels[static_cast<std::size_t>(level)].find(at.key(level));
  return cell != nullptr && cell->count >= enough ? cell : nullptr;
}

CachedError PathSpaceGrid::error(const vec3& position, const vec3& normal, int depth, const vec2& u, const Rgb& weight) const {
  const Lookup found = look_up(position, normal, depth, u);
  if (found.level < 0) return {};
  const PlaneMoments& cell = *find(found.place, found.level, 0);
  const float scale = luminance(weight), noise = std::sqrt(of_smooth_planes * cell.variance() / cell.effective_count());
  const auto above =
      found.level > coarsest ? jittered(found.own, position, found.offset, found.level - 1, enough_) : std::nullopt;
  if (!above) return {scale * noise};
  const Rgb here = *answer(found.place, found.level, 0), at_twice = *answer(*above, found.level - 1, 0);
  return {scale * noise, scale * parent_excess * luminance(at_twice - here)};
}

std::vector<RecordShape> PathSpaceGrid::cells() const {
  std::vector<RecordShape> shapes;
  for (const Shard& shard : shards_)
    for (int level = deepest; level >= coarsest; --level) {
      const Table& table = shard.levels[static_cast<std::size_t>(level)];
      for (std::size_t i = 0; i < table.cells.size(); ++i) {
        const Key& at = table.keys[i];
        const float edge = this->edge(level);
        const vec3 centre = origin_ + edge * (vec3(at.cell) + 0.5f);
        if (table.cells[i].count < enough_ || level > finest_level(centre)) continue;
        if (level < finest_level(centre) && answered_within(shard, at, level, enough_)) continue;
        shapes.push_back({centre, plane_of(at.tag).normal, 0.5f * edge, vec3(0), true});
      }
    }
  return shapes;
}

// Do finer cells answer everywhere in this one, wherever values were seen?
bool PathSpaceGrid::answered_within(const Shard& shard, const Key& at, int level, float enough) {
  const Table& finer = shard.levels[static_cast<std::size_t>(level) + 1];
  bool any = false;
  for (int child = 0; child < 8; ++child) {
    const Key below{at.cell * 2 + glm::ivec3(child & 1, child >> 1 & 1, child >> 2), at.tag};
    const PlaneMoments* cell = finer.find(below);
    if (cell == nullptr) continue;
    if (cell->count < enough) return false;
    any = true;
  }
  return any;
}

void PathSpaceGrid::write(ByteWriter& out) const {
  for (std::size_t level = coarsest; level <= deepest; ++level) {
    std::uint64_t count = 0;
    for (const Shard& shard : shards_) count += shard.levels[level].cells.size();
    out.add(count);
    for (const Shard& shard : shards_)
      for (std::size_t i = 0; i < shard.levels[level].cells.size(); ++i) {
        Key at = shard.levels[level].keys[i];
        PlaneMoments cell = shard.levels[level].cells[i];
        transfer([&](const auto& value) { out.add(value); }, at, cell);
      }
  }
}

void PathSpaceGrid::read(ByteReader& in, int depths) {
  constexpr std::size_t cell_bytes = 4 * 4 + 17 * 4;
  for (int level = coarsest; level <= deepest; ++level)
    for (std::size_t left = in.take_count(cell_bytes); left > 0; --left) {
      Key at;
      PlaneMoments cell;
      transfer([&](auto& value) { in.take(value); }, at, cell);
      constexpr int farthest = 1 << 30;  // infinite planes reach beyond the scene's bounds
      const bool inside =
          glm::all(glm::greaterThan(at.cell, glm::ivec3(-farthest))) && glm::all(glm::lessThan(at.cell, glm::ivec3(farthest)));
      const std::uint32_t longest = normals * static_cast<std::uint32_t>(depths);
      if (!inside || at.tag >= longest || at.tag % normals == no_normal || !cell.is_valid())
        in.refuse("a cell holds what none can");
      const std::size_t shard = hash(at.cell >> (level - coarsest), at.tag) % shard_count;
      shards_[shard].levels[static_cast<std::size_t>(level)].add(at, cell);
    }
}

}  // namespace etendue
