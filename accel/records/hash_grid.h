// Hash grids of spheres, one for each size ([Teschner2003]'s hashed cells; levels as [Eitz2007]): the cells of level l have the
// edge 2^l, and a sphere is listed in every cell that it touches on the level whose edge is one to two diameters. These are at
// most eight cells, and a query looks into one cell of each level that holds a sphere.
//
// Insertion takes constant time for any distribution; the time of a lookup grows with the number of levels in use and of
// spheres that share a cell. Cells carry their own coordinates, so none is mistaken for another. Spheres with radii above 1e30
// are tested one by one.
#pragma once

#include "accel/records/record_sphere.h"

namespace etendue {

class RecordHashGrid {
 public:
  RecordHashGrid() : slots_(16) {}

  void insert(const vec3& centre, float radius, std::uint32_t id);
  void covering(const vec3& p, Neighbours& out) const;
  std::uint64_t bytes() const {
    return listed_.size() * sizeof(Listed) + slots_.size() * sizeof(Slot) + levels_.size() * sizeof(int) +
           everywhere_.size() * sizeof(RecordSphere);
  }

 private:
  struct Cell {
    std::int64_t x, y, z;
    int level;
    bool operator==(const Cell&) const = default;
  };
  struct Slot {
    Cell cell;
    std::uint32_t first = no_id;  // of listed_; no_id: free
  };
  struct Listed {
    RecordSphere sphere;
    std::uint32_t next;
  };

  static Cell cell_of(const vec3& p, int level);
  std::size_t slot_of(const Cell& cell) const;
  void list(const Cell& cell, const RecordSphere& sphere);

  std::vector<Slot> slots_;  // open addressing, a power of two
  std::size_t cell_count_ = 0;
  std::vector<Listed> listed_;
  std::vector<int> levels_;  // that hold a sphere
  std::vector<RecordSphere> everywhere_;
};

}  // namespace etendue
