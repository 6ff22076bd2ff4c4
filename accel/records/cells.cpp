#include "accel/records/cells.h"

#include <bit>

namespace etendue {

static_assert(RecordStructure<RecordCells>);

namespace {

constexpr unsigned lower_half[3] = {0x55, 0x33, 0x0f};

}  // namespace

RecordCells::RecordCells(const Bounds& bounds) : lower_(-1), cells_(1) {
  const bool usable = !bounds.empty() && is_finite(bounds.lower) && is_finite(bounds.diagonal());
  const float side = usable ? max_component(bounds.diagonal()) : 2;
  if (usable) lower_ = bounds.lower;
  scale_ = vec3(static_cast<float>(1 << levels) / std::max(side, 1e-30f));
}

glm::ivec3 RecordCells::step(const vec3& p) const {
  constexpr float last = (1 << levels) - 1;
  return glm::ivec3(glm::clamp((p - lower_) * scale_, vec3(0), vec3(last)));
}

RecordCells::Box RecordCells::box_of(const RecordSphere& sphere) const {
  const vec3 half(reach(sphere.radius));
  return {step(sphere.centre - half), step(sphere.centre + half)};
}

unsigned RecordCells::eighths(const Box& box, const glm::ivec3& middle) {
  unsigned touched = 0xff;
  for (int a = 0; a < 3; ++a) {
    if (box.lower[a] >= middle[a]) touched &= ~lower_half[a];
    if (box.upper[a] < middle[a]) touched &= lower_half[a];
  }
  return touched;
}

void RecordCells::insert(const vec3& centre, float radius, std::uint32_t id) {
  if (!is_record_sphere(centre, radius)) return;
  const RecordSphere sphere{centre, radius, id};
  insert_into(0, levels, sphere, box_of(sphere));
}

// `level`: a cell's side is 2^level steps. Bits above it are those of the cell's lower corner for the part of a box that lies
// in the cell, so that boxes are cut to cells as they go down.
void RecordCells::insert_into(std::uint32_t index, int level, const RecordSphere& sphere, const Box& box) {
  const int half = level > 0 ? 1 << (level - 1) : 0;
  const glm::ivec3 corner = (box.lower >> level) << level, middle = corner + half;
  if (cells_[index].children == no_id) {
    list(cells_[index], sphere);
    // This is asked again whenever the list has doubled.
    const std::uint32_t count = cells_[index].count;
    if (count <= width || !std::has_single_bit(count - 1) || !cuts(cells_[index], level, middle)) return;
    const auto children = static_cast<std::uint32_t>(cells_.size());
    cells_.resize(cells_.size() + 8);
    const std::uint32_t first = std::exchange(cells_[index].chunks, no_id);
    cells_[index].children = children;
    for (std::uint32_t i = first; i != no_id;) {
      const Chunk chunk = chunks_[i];
      chunks_[i].next = std::exchange(free_, i);
      for (std::uint32_t k = 0; k < chunk.count; ++k) {
        const RecordSphere moved = chunk.sphere(k);
        Box within = box_of(moved);
        within.lower = glm::max(within.lower, corner);
        within.upper = glm::min(within.upper, corner + (2 * half - 1));
        insert_into(index, level, moved, within);
      }
      i = chunk.next;
    }
    return;
  }
  for (unsigned left = eighths(box, middle); left != 0; left &= left - 1) {
    const int child = std::countr_zero(left);
    Box part = box;
    for (int a = 0; a < 3; ++a)
      if (child >> a & 1)
        part.lower[a] = std::max(part.lower[a], middle[a]);
      else
        part.upper[a] = std::min(part.upper[a], middle[a] - 1);
    insert_into(cells_[index].children + static_cast<std::uint32_t>(child), level - 1, sphere, part);
  }
}

// Would half of the children's places in lists be spared? Spheres wider than the cell count as if they filled it: else the
// faces of boxes that coincide would be cut out to the last step.
bool RecordCells::cuts(const Cell& cell, int level, const glm::ivec3& middle) const {
  if (level == 0) return false;
  int places = 0;
  for (std::uint32_t i = cell.chunks; i != no_id; i = chunks_[i].next)
    for (std::uint32_t k = 0; k < chunks_[i].count; ++k) {
      const Box box = box_of(chunks_[i].sphere(k));
      const glm::ivec3 extent = box.upper - box.lower;
      const bool wide = std::max({extent.x, extent.y, extent.z}) >= 1 << level;
      places += wide ? 8 : std::popcount(eighths(box, middle));
    }
  return places <= 4 * static_cast<int>(cell.count);
}

void RecordCells::list(Cell& cell, const RecordSphere& sphere) {
  if (cell.chunks == no_id || chunks_[cell.chunks].count == width) {
    std::uint32_t added = free_;
    if (added == no_id) {
      added = static_cast<std::uint32_t>(chunks_.size());
      chunks_.emplace_back();
    } else {
      free_ = chunks_[added].next;
    }
    Chunk& chunk = chunks_[added];
    std::fill_n(chunk.radius_squared, width, -1.0f);
    chunk.count = 0;
    chunk.next = cell.chunks;
    cell.chunks = added;
  }
  Chunk& chunk = chunks_[cell.chunks];
  const std::uint32_t k = chunk.count++;
  for (int a = 0; a < 3; ++a) chunk.centre[a][k] = sphere.centre[a];
  chunk.radius_squared[k] = sphere.radius * sphere.radius;
  chunk.radius[k] = sphere.radius;
  chunk.id[k] = sphere.id;
  ++cell.count;
}

void RecordCells::covering(const vec3& p, Neighbours& out) const {
  out.clear();
  if (!is_finite(p)) return;
  const glm::ivec3 at = step(p);
  std::uint32_t cell = 0;
  for (int level = levels - 1; cells_[cell].children != no_id; --level) {
    const glm::ivec3 bit = (at >> level) & 1;
    cell = cells_[cell].children + static_cast<std::uint32_t>(bit.x | bit.y << 1 | bit.z << 2);
  }
  for (std::uint32_t i = cells_[cell].chunks; i != no_id; i = chunks_[i].next) {
    const Chunk& chunk = chunks_[i];
    std::array<float, width> d2;
    for (std::uint32_t k = 0; k < width; ++k)
      d2[k] = distance_squared(vec3(chunk.centre[0][k], chunk.centre[1][k], chunk.centre[2][k]), p);
    unsigned covers = 0;
    for (std::uint32_t k = 0; k < width; ++k) covers |= static_cast<unsigned>(d2[k] <= chunk.radius_squared[k]) << k;
    for (; covers != 0; covers &= covers - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(covers));
      out.push_back({chunk.id[k], d2[k]});
    }
  }
  sort_by_id(out);
}

}  // namespace etendue
