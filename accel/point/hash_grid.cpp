#include "accel/point/hash_grid.h"

#include "framework/core/rng.h"

#include <bit>

namespace etendue {

static_assert(PointStructure<HashGrid>);

namespace {

constexpr int bits_per_axis = 21, max_cell = (1 << bits_per_axis) - 1;

// Above r by what rounding allows: no point with a float distance^2 <= r^2 lies farther than this along any axis.
float reach(float r) { return r * (1 + 8 * std::numeric_limits<float>::epsilon()) + 1e-22f; }

}  // namespace

// Monotone along each axis, so that a box of positions covers a box of cells.
uvec3 HashGrid::cell(const vec3& p) const {
  return uvec3(glm::clamp((p - bounds_.lower) / cell_size_, vec3(0), vec3(max_cell)));
}

HashGrid::Key HashGrid::key(const uvec3& cell) {
  return static_cast<Key>(cell.x) << (2 * bits_per_axis) | static_cast<Key>(cell.y) << bits_per_axis | static_cast<Key>(cell.z);
}

// Where the cell is, or the free slot where it would be.
std::size_t HashGrid::slot_of(Key key) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t i = mix_bits(key) & mask;
  while (slots_[i].count != 0 && slots_[i].key != key) i = (i + 1) & mask;
  return i;
}

void HashGrid::grow_table() {
  std::vector<Slot> old(2 * slots_.size());
  old.swap(slots_);
  for (const Slot& slot : old)
    if (slot.count != 0) slots_[slot_of(slot.key)] = slot;
}

// Fills the table with each cell's count, and `keys` with each point's cell.
void HashGrid::count_cells(std::span<const vec3> points, std::vector<Key>& keys) {
  slots_.assign(std::bit_ceil(points.size() / points_per_cell * 2 + 16), {});
  cell_count_ = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    keys[i] = key(cell(points[i]));
    Slot& slot = slots_[slot_of(keys[i])];
    slot.key = keys[i];
    if (slot.count++ == 0 && 2 * ++cell_count_ > slots_.size()) grow_table();
  }
}

void HashGrid::build(std::span<const vec3> points) {
  points_.clear();
  slots_.clear();
  cell_count_ = 0;
  bounds_ = {};
  if (points.empty()) return;
  for (const vec3& p : points) bounds_.extend(p);

  // Photons lie on surfaces: their number in a cell grows as its size squared. The first guess spreads them over the
  // bounds' surface; two corrections bring the mean of the occupied cells near the aim.
  const float extent = max_component(bounds_.diagonal()), smallest = std::max(extent / (max_cell / 2), 1e-30f);
  const float cells = static_cast<float>(points.size()) / points_per_cell;
  cell_size_ = std::max(std::sqrt(2 * bounds_.half_area() / cells), smallest);
  std::vector<Key> keys(points.size());
  count_cells(points, keys);
  for (int round = 0; round < 2; ++round) {
    const float mean = static_cast<float>(points.size()) / static_cast<float>(cell_count_);
    const float size = std::clamp(cell_size_ * std::sqrt(points_per_cell / mean), smallest, std::max(extent, smallest));
    if (mean > 0.5f * points_per_cell && mean < 2 * points_per_cell) break;
    if (size == cell_size_) break;
    cell_size_ = size;
    count_cells(points, keys);
  }

  std::uint32_t first = 0;
  for (Slot& slot : slots_) {
    slot.first = first;
    first += slot.count;
  }
  std::vector<std::uint32_t> filled(slots_.size());
  points_.resize(points.size());
  for (std::uint32_t id = 0; id < points.size(); ++id) {
    const std::size_t slot = slot_of(keys[id]);
    points_[slots_[slot].first + filled[slot]++] = {points[id], id};
  }
}

void HashGrid::collect(const Point* begin, const Point* end, const vec3& p, float r, Neighbours& out) const {
  for (const Point* point = begin; point != end; ++point) {
    const float d2 = distance_squared(point->position, p);
    if (d2 <= r * r) out.push_back({point->id, d2});
  }
}

void HashGrid::within(const vec3& p, float r, Neighbours& out) const {
  out.clear();
  if (points_.empty() || !can_find(p, r)) return;
  const vec3 lower = glm::max(p - reach(r), bounds_.lower), upper = glm::min(p + reach(r), bounds_.upper);
  if (lower.x > upper.x || lower.y > upper.y || lower.z > upper.z) return;
  const uvec3 begin = cell(lower), end = cell(upper);
  const dvec3 covered = dvec3(end - begin) + 1.0;
  if (covered.x * covered.y * covered.z > static_cast<double>(cell_count_))
    return collect(points_.data(), points_.data() + points_.size(), p, r, out);
  for (unsigned x = begin.x; x <= end.x; ++x)
    for (unsigned y = begin.y; y <= end.y; ++y)
      for (unsigned z = begin.z; z <= end.z; ++z) {
        const Slot& slot = slots_[slot_of(key({x, y, z}))];
        const Point* const run = points_.data() + slot.first;
        collect(run, run + slot.count, p, r, out);
      }
}

// Balls of growing radius until one holds enough: then the nearest are all inside it. The first is small, as clusters may be
// much denser than the mean; the next ones are as large as the density met so far asks for.
void HashGrid::nearest(const vec3& p, std::size_t k, float r_max, Neighbours& out) const {
  out.clear();
  if (points_.empty() || k == 0 || !can_find(p, r_max)) return;
  const float to_bounds = glm::length(p - glm::clamp(p, bounds_.lower, bounds_.upper));
  float r = std::min(to_bounds + 0.25f * cell_size_, r_max);
  for (within(p, r, out); out.size() < std::min(k, points_.size()) && r < r_max; within(p, r, out)) {
    const float missing = static_cast<float>(k) / static_cast<float>(out.size() + 1);
    r = std::min(r * std::clamp(std::sqrt(1.5f * missing), 1.5f, 4.0f), r_max);
  }
  keep_nearest(out, k);
}

}  // namespace etendue
