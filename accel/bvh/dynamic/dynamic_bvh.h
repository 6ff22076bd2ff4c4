// A bounding volume hierarchy over a geometry that moves: the tree of any builder in the `binary` layout, kept up to date by
// refitting, rebuilding, or both (dynamic_tree.h). The geometry's triangles stay those they are; positions and quadrics change.
//
// A primitive that becomes invalid (NaN, infinite, without area) vanishes from its leaf, and appears there again when it is
// valid again.
#pragma once

#include "accel/bvh/bvh.h"
#include "accel/bvh/dynamic/dynamic_tree.h"

namespace etendue {

class DynamicBvh {
 public:
  // `geometry` must outlive the structure.
  DynamicBvh(const Geometry& geometry, DynamicTree::Build build, const ChangePolicy& policy);

  // Primitives `changed` (each once) of the geometry have changed. No query may run meanwhile.
  TreeUpdate update(std::span<const std::uint32_t> changed);

  Hit closest(const Ray& ray) const { return closest_with(ray, CountNothing{}); }
  bool occluded(const Ray& ray) const { return occluded_with(ray, CountNothing{}); }
  Hit closest_counted(const Ray& ray, TraversalCounters& counters) const { return closest_with(ray, CountWork{counters}); }
  bool occluded_counted(const Ray& ray, TraversalCounters& counters) const { return occluded_with(ray, CountWork{counters}); }
  RayStructureStats stats() const;

 private:
  template <class Count>
  Hit closest_with(const Ray& ray, Count count) const {
    return leaves_.mixed() ? closest_in<true>(tree_.layout(), leaves_, ray, count)
                           : closest_in<false>(tree_.layout(), leaves_, ray, count);
  }
  template <class Count>
  bool occluded_with(const Ray& ray, Count count) const {
    return leaves_.mixed() ? occluded_in<true>(tree_.layout(), leaves_, ray, count)
                           : occluded_in<false>(tree_.layout(), leaves_, ray, count);
  }
  void fill_touched_leaves();

  const Geometry* geometry_;
  DynamicTree tree_;
  LeafBlocks leaves_;  // block i is leaf i of the tree
};

}  // namespace etendue
