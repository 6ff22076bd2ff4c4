#include "integrators/hash_cache_grid.h"

#include "framework/core/parallel.h"
#include "framework/core/rng.h"

#include <numeric>

namespace etendue {

namespace {

constexpr std::size_t shard_count = 128;

std::uint64_t hash(const glm::ivec3& cell, std::uint32_t tag) {
  const auto bits = [](int x) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)); };
  return mix_bits(mix_bits(bits(cell.x) | bits(cell.y) << 32) ^ (bits(cell.z) | std::uint64_t{tag} << 32));
}

// Normals by steps of a third along each axis, and the depth.
std::uint32_t tag_of(const vec3& normal, int depth) {
  std::uint32_t tag = static_cast<std::uint32_t>(depth);
  for (int axis = 0; axis < 3; ++axis) tag = tag * 7 + static_cast<std::uint32_t>(std::lround(3 * normal[axis]) + 3);
  return tag;
}

}  // namespace

const HashGrid::Cell* HashGrid::Table::find(const Key& key) const {
  if (slots.empty()) return nullptr;
  const std::size_t mask = slots.size() - 1;
  for (std::size_t slot = hash(key.cell, key.tag) & mask;; slot = (slot + 1) & mask) {
    if (slots[slot] == 0) return nullptr;
    if (const Cell& cell = cells[slots[slot] - 1]; cell.key == key) return &cell;
  }
}

HashGrid::Cell& HashGrid::Table::at(const Key& key) {
  if (2 * (cells.size() + 1) > slots.size()) {
    slots.assign(std::max<std::size_t>(64, 2 * slots.size()), 0);
    for (std::uint32_t i = 0; i < cells.size(); ++i) {
      std::size_t slot = hash(cells[i].key.cell, cells[i].key.tag) & (slots.size() - 1);
      while (slots[slot] != 0) slot = (slot + 1) & (slots.size() - 1);
      slots[slot] = i + 1;
    }
  }
  const std::size_t mask = slots.size() - 1;
  for (std::size_t slot = hash(key.cell, key.tag) & mask;; slot = (slot + 1) & mask) {
    if (slots[slot] == 0) {
      cells.push_back({key});
      slots[slot] = static_cast<std::uint32_t>(cells.size());
      return cells.back();
    }
    if (Cell& cell = cells[slots[slot] - 1]; cell.key == key) return cell;
  }
}

// The grid's origin is off the scene's corner by odd shares, so that no cell's face lies in an axis-parallel wall.
HashGrid::HashGrid(const Bounds& bounds, const HashGridOptions& options) : options_(options), shards_(shard_count) {
  const Bounds box = bounds.empty() ? Bounds{vec3(-1), vec3(1)} : bounds;
  size_ = std::max(glm::length(box.diagonal()), 1e-6f);
  origin_ = box.lower - size_ * vec3(0.0137f, 0.0211f, 0.0173f);
  begin(0);
}

void HashGrid::begin(std::uint32_t index) {
  const float samples = static_cast<float>(index) + 1;
  finest_ = options_.finest * std::pow(samples, -1.0f / 6);
  enough_ = options_.enough * std::pow(samples, 2.0f / 3);
}

HashGrid::Key HashGrid::key(const vec3& position, std::uint32_t tag, int level) const {
  return {glm::ivec3(glm::floor((position - origin_) / edge(level))), tag};
}

int HashGrid::finest_level(const vec3& position) const {
  const float wanted = finest_ * options_.pixel_angle * glm::length(position - options_.eye);
  return std::clamp(static_cast<int>(std::floor(std::log2(size_ / std::max(wanted, 1e-30f)))), coarsest, deepest);
}

// All that a lookup may ask about one coarsest cell lies in one shard.
std::size_t HashGrid::shard_of(const vec3& position, std::uint32_t tag) const {
  return hash(key(position, tag, coarsest).cell, tag) % shard_count;
}

void HashGrid::add(std::span<const std::vector<CachedValue>> values) {
  // A counting sort by shard that keeps the order.
  std::vector<std::size_t> first{0};
  for (const auto& some : values) first.push_back(first.back() + some.size());
  std::vector<std::uint8_t> shard(first.back());
  parallel_for(values.size(), 1, [&](std::size_t i) {
    for (std::size_t k = 0; k < values[i].size(); ++k)
      shard[first[i] + k] =
          static_cast<std::uint8_t>(shard_of(values[i][k].position, tag_of(values[i][k].normal, values[i][k].depth)));
  });
  std::vector<std::size_t> begin(shard_count + 1, 0);
  for (const std::uint8_t s : shard) ++begin[s + 1u];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<const CachedValue*> sorted(shard.size());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  for (std::size_t i = 0, at = 0; i < values.size(); ++i)
    for (const CachedValue& value : values[i]) sorted[next[shard[at++]]++] = &value;

  parallel_for(shard_count, 1, [&](std::size_t s) {
    std::vector<Table>& levels = shards_[s].levels;
    for (std::size_t i = begin[s]; i < begin[s + 1]; ++i) {
      const CachedValue& value = *sorted[i];
      const int level = finest_level(value.position);
      Cell& cell = levels[static_cast<std::size_t>(level)].at(key(value.position, tag_of(value.normal, value.depth), level));
      cell.new_sum += value.value;
      cell.new_count += 1;
    }
    for (int level = deepest; level >= coarsest; --level)
      for (Cell& cell : levels[static_cast<std::size_t>(level)].cells) {
        if (cell.new_count == 0) continue;
        if (level > coarsest) {
          Cell& parent = levels[static_cast<std::size_t>(level) - 1].at({cell.key.cell >> 1, cell.key.tag});
          parent.new_sum += cell.new_sum;
          parent.new_count += cell.new_count;
        }
        cell.sum += cell.new_sum;
        cell.count += cell.new_count;
        cell.new_sum = Rgb(0);
        cell.new_count = 0;
      }
  });
}

std::optional<Rgb> HashGrid::mean(const vec3& position, const vec3& normal, int depth, const vec2& u) const {
  const Frame frame = Frame::from_normal(normal);
  const vec3 offset = (u.x - 0.5f) * frame.tangent + (u.y - 0.5f) * frame.bitangent;
  const std::uint32_t tag = tag_of(normal, depth);
  for (int level = finest_level(position); level >= coarsest; --level) {
    const vec3 moved = position + edge(level) * offset;
    const Table& table = shards_[shard_of(moved, tag)].levels[static_cast<std::size_t>(level)];
    const Cell* cell = table.find(key(moved, tag, level));
    if (cell != nullptr && cell->count >= enough_) return cell->sum / cell->count;
  }
  return std::nullopt;
}

}  // namespace etendue
