// A bounding volume hierarchy over a geometry that moves: the tree of any builder in the `binary` layout, kept up to date by
// refitting, rebuilding, or both (dynamic_tree.h). The geometry's triangles stay those they are; positions and quadrics change.
//
// A primitive that becomes invalid (NaN, infinite, without area) vanishes from its leaf, and appears there again when it is
// valid again.
#pragma once

#include "accel/bvh/bvh.h"
#include "accel/bvh/dynamic/dynamic_tree.h"

namespace etendue {

class DynamicBvh : public LeafQueries<DynamicBvh, LeafTest> {
 public:
  // `geometry` must outlive the structure.
  DynamicBvh(const Geometry& geometry, DynamicTree::Build build, const ChangePolicy& policy);

  // Primitives `changed` (each once) of the geometry have changed. No query may run meanwhile.
  TreeUpdate update(std::span<const std::uint32_t> changed);

  template <class Count, class Leaf>
  void traverse(const Ray& ray, const float& t_best, Count& count, const Leaf& leaf) const {
    tree_.layout().traverse(ray, t_best, count, [&](std::uint32_t first, std::uint32_t size) {
      return leaf(Leaves::Run{first, size});
    });
  }
  const Leaves& leaves() const { return leaves_; }
  RayStructureStats stats() const;

 private:
  void fill_touched_leaves();

  const Geometry* geometry_;
  DynamicTree tree_;
  Leaves leaves_;  // pack i is leaf i of the tree
};

}  // namespace etendue
