// Bounding volume hierarchy over one geometry: any builder's tree in the `binary` layout.
#pragma once

#include "accel/bvh/layout_binary.h"
#include "accel/kernels/leaf.h"

namespace etendue {

class Bvh : public LeafQueries<Bvh, LeafTest> {
 public:
  // `geometry` must outlive the structure (its quadrics are looked up; triangles are copied).
  Bvh(const Geometry& geometry, BinaryTree tree);

  template <class Count, class Leaf>
  void traverse(const Ray& ray, const float& t_best, Count& count, const Leaf& leaf) const {
    layout_.traverse(ray, t_best, count, [&](std::uint32_t first, std::uint32_t size) {
      return leaf(Leaves::Run{first, size});
    });
  }
  const Leaves& leaves() const { return leaves_; }
  RayStructureStats stats() const;

 private:
  Leaves leaves_;
  BinaryLayout layout_;  // its leaves are runs of packs
  double sah_cost_;
};

}  // namespace etendue
