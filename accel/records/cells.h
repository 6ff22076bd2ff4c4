// Cells that list every sphere which touches them: an octree, subdivided where that separates spheres, so that a query descends
// to one cell and reads only its list.
//
// They are expensive to fill, most of all where radii are alike, and cheap to query: they serve spheres that are queried many
// times more often than inserted. A cell is cut when its list is longer than `width` spheres, unless they would fill most of
// its eighths or are wider than it; so a sphere is listed in about ten cells of its own size, whatever the sizes of others near
// it.
//
// Cells are counted in steps of one grid of 2^20 along each axis of the bounds. The step of a coordinate is found by monotone
// float operations, for queries and for the faces of a sphere's box alike, which makes answers exact without slack. What lies
// beyond the bounds is in the outermost cells: answers stay correct, but get slow as these lists grow.
#pragma once

#include "accel/records/record_sphere.h"

#include <array>

namespace etendue {

class RecordCells {
 public:
  explicit RecordCells(const Bounds& bounds);

  void insert(const vec3& centre, float radius, std::uint32_t id);
  void covering(const vec3& p, Neighbours& out) const;
  std::uint64_t bytes() const { return cells_.size() * sizeof(Cell) + chunks_.size() * sizeof(Chunk); }

 private:
  static constexpr int levels = 20;
  static constexpr std::uint32_t width = 8;

  // A piece of a list; its unused places cover nothing.
  struct Chunk {
    float centre[3][width], radius_squared[width], radius[width];
    std::uint32_t id[width];
    std::uint32_t count, next;

    RecordSphere sphere(std::uint32_t k) const { return {{centre[0][k], centre[1][k], centre[2][k]}, radius[k], id[k]}; }
  };
  // Eight cells lie together, the one above the middle on axis a where bit a of its place is set.
  struct Cell {
    std::uint32_t children = no_id;  // the first of eight; no_id: the cell is not cut
    std::uint32_t chunks = no_id;    // its list
    std::uint32_t count = 0;         // spheres in it
  };
  // Steps of the grid, both ends included.
  struct Box {
    glm::ivec3 lower, upper;
  };

  glm::ivec3 step(const vec3& p) const;
  Box box_of(const RecordSphere& sphere) const;
  static unsigned eighths(const Box& box, const glm::ivec3& middle);  // bit i: child i is touched
  void insert_into(std::uint32_t cell, int level, const RecordSphere& sphere, const Box& box);
  bool cuts(const Cell& cell, int level, const glm::ivec3& middle) const;
  void list(Cell& cell, const RecordSphere& sphere);

  vec3 lower_, scale_;
  std::vector<Cell> cells_;
  std::vector<Chunk> chunks_;
  std::uint32_t free_ = no_id;  // chunks without a list
};

}  // namespace etendue
