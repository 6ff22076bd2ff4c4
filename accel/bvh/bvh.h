// Bounding volume hierarchy over one geometry: any builder's tree in the `binary` layout.
#pragma once

#include "accel/bvh/layout_binary.h"
#include "accel/kernels/leaf.h"

namespace etendue {

// The two queries over a tree in the `binary` layout whose leaves are runs of blocks.
template <bool mixed, class Count>
Hit closest_in(const BinaryLayout& layout, const LeafBlocks& leaves, const Ray& ray, Count count) {
  if (!is_traceable(ray)) return {};
  Hit hit;
  hit.t = ray.t_max;
  const BlockRay block_ray(ray);
  layout.traverse(ray, hit.t, count, [&](std::uint32_t first, std::uint32_t size) {
    leaves.closest<mixed>(block_ray, {first, size}, hit, count);
    return false;
  });
  if (!hit) return {};
  hit.instance = 0;
  return hit;
}

template <bool mixed, class Count>
bool occluded_in(const BinaryLayout& layout, const LeafBlocks& leaves, const Ray& ray, Count count) {
  if (!is_traceable(ray)) return false;
  bool found = false;
  const BlockRay block_ray(ray);
  layout.traverse(ray, ray.t_max, count, [&](std::uint32_t first, std::uint32_t size) {
    return found = leaves.occluded<mixed>(block_ray, {first, size}, count);
  });
  return found;
}

class Bvh {
 public:
  // `geometry` must outlive the structure (its quadrics are looked up; triangles are copied).
  Bvh(const Geometry& geometry, BinaryTree tree);

  Hit closest(const Ray& ray) const { return closest_with(ray, CountNothing{}); }
  bool occluded(const Ray& ray) const { return occluded_with(ray, CountNothing{}); }
  Hit closest_counted(const Ray& ray, TraversalCounters& counters) const { return closest_with(ray, CountWork{counters}); }
  bool occluded_counted(const Ray& ray, TraversalCounters& counters) const { return occluded_with(ray, CountWork{counters}); }
  RayStructureStats stats() const;

 private:
  template <class Count>
  Hit closest_with(const Ray& ray, Count count) const {
    return leaves_.mixed() ? closest_in<true>(layout_, leaves_, ray, count) : closest_in<false>(layout_, leaves_, ray, count);
  }
  template <class Count>
  bool occluded_with(const Ray& ray, Count count) const {
    return leaves_.mixed() ? occluded_in<true>(layout_, leaves_, ray, count) : occluded_in<false>(layout_, leaves_, ray, count);
  }

  LeafBlocks leaves_;
  BinaryLayout layout_;  // its leaves are runs of blocks
  double sah_cost_;
};

}  // namespace etendue
