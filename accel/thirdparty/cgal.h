// CGAL's AABB tree as a ray structure ([Alliez2022]): the baseline of those who come from geometry processing. It is present
// where the library was found. CGAL's AABB tree is GPL-3, and so is a program built with it (see ETENDUE_WITH_CGAL in
// CMakeLists.txt).
//
// Tree, box test and triangle test are CGAL's own, in its kernel Simple_cartesian<double>: no sign is computed exactly, and
// there is no rule for edges shared by triangles or boxes without extent, so a ray may slip through an edge or vertex that it
// meets to within rounding (measured: 2 of 3,000 rays aimed at edges and vertices of a closed sphere), and ties in distance go
// to whichever triangle is tested first. Distances are computed here, in double, from the triangle's plane; a ray within the
// plane misses, as everywhere.
//
// Limits: a query for the closest hit allocates (CGAL's priority queue) and takes no account of t_max until the end; quadrics
// have no place in CGAL's tree and are tested one by one for every ray. Memory: 64 bytes per node, 16 per triangle; the
// geometry is not copied.
#pragma once

#include "framework/scene/geometry.h"

#include <memory>

namespace etendue {

class Cgal {
 public:
  // `geometry` must outlive the structure.
  explicit Cgal(const Geometry& geometry);

  Hit closest(const Ray& ray) const;
  bool occluded(const Ray& ray) const;
  // Primitives are counted; CGAL does not report the nodes it visits.
  Hit closest_counted(const Ray& ray, TraversalCounters& counters) const;
  bool occluded_counted(const Ray& ray, TraversalCounters& counters) const;
  RayStructureStats stats() const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

struct RayEntry cgal_entry();  // its row of the registry

}  // namespace etendue
