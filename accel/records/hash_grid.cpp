#include "accel/records/hash_grid.h"

#include "framework/core/rng.h"

namespace etendue {

static_assert(RecordStructure<RecordHashGrid>);

// Powers of two scale exactly, and all else is monotone: a box of positions covers a box of cells.
RecordHashGrid::Cell RecordHashGrid::cell_of(const vec3& p, int level) {
  const auto along = [level](float x) {
    return static_cast<std::int64_t>(std::clamp(std::floor(std::ldexp(static_cast<double>(x), -level)), -0x1p62, 0x1p62));
  };
  return {along(p.x), along(p.y), along(p.z), level};
}

// The slot of the cell, or the free slot where it would be.
std::size_t RecordHashGrid::slot_of(const Cell& cell) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t i = hash_keys(cell.x, cell.y, cell.z, cell.level) & mask;
  while (slots_[i].first != no_id && !(slots_[i].cell == cell)) i = (i + 1) & mask;
  return i;
}

void RecordHashGrid::list(const Cell& cell, const RecordSphere& sphere) {
  std::size_t i = slot_of(cell);
  if (slots_[i].first == no_id && 2 * ++cell_count_ > slots_.size()) {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.first != no_id) slots_[slot_of(slot.cell)] = slot;
    i = slot_of(cell);
  }
  listed_.push_back({sphere, slots_[i].first});
  slots_[i] = {cell, static_cast<std::uint32_t>(listed_.size() - 1)};
}

void RecordHashGrid::insert(const vec3& centre, float radius, std::uint32_t id) {
  if (!is_record_sphere(centre, radius)) return;
  const RecordSphere sphere{centre, radius, id};
  if (radius > 1e30f) return everywhere_.push_back(sphere);
  const float about = reach(radius);
  const int level = std::ilogb(2 * about) + 1;
  if (std::find(levels_.begin(), levels_.end(), level) == levels_.end()) levels_.push_back(level);
  const Cell begin = cell_of(centre - about, level), end = cell_of(centre + about, level);
  for (std::int64_t x = begin.x; x <= end.x; ++x)
    for (std::int64_t y = begin.y; y <= end.y; ++y)
      for (std::int64_t z = begin.z; z <= end.z; ++z) list({x, y, z, level}, sphere);
}

void RecordHashGrid::covering(const vec3& p, Neighbours& out) const {
  out.clear();
  if (!is_finite(p)) return;
  for (const RecordSphere& sphere : everywhere_) add_if_covering(sphere, p, out);
  for (const int level : levels_)
    for (std::uint32_t i = slots_[slot_of(cell_of(p, level))].first; i != no_id; i = listed_[i].next)
      add_if_covering(listed_[i].sphere, p, out);
  sort_by_id(out);
}

}  // namespace etendue
