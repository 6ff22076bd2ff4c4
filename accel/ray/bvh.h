// Bounding volume hierarchy over one geometry: any builder's tree in the `binary` layout.
#pragma once

#include "accel/ray/layout_binary.h"
#include "accel/ray/leaf.h"

namespace etendue {

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
    return leaves_.mixed() ? closest_in<true>(ray, count) : closest_in<false>(ray, count);
  }
  template <class Count>
  bool occluded_with(const Ray& ray, Count count) const {
    return leaves_.mixed() ? occluded_in<true>(ray, count) : occluded_in<false>(ray, count);
  }
  template <bool mixed, class Count>
  Hit closest_in(const Ray& ray, Count count) const;
  template <bool mixed, class Count>
  bool occluded_in(const Ray& ray, Count count) const;

  LeafBlocks leaves_;
  BinaryLayout layout_;  // its leaves are runs of blocks
  double sah_cost_;
};

template <bool mixed, class Count>
Hit Bvh::closest_in(const Ray& ray, Count count) const {
  if (!is_traceable(ray)) return {};
  Hit hit;
  hit.t = ray.t_max;
  const BlockRay block_ray(ray);
  layout_.traverse(ray, hit.t, count, [&](std::uint32_t first, std::uint32_t size) {
    leaves_.closest<mixed>(block_ray, {first, size}, hit, count);
    return false;
  });
  if (!hit) return {};
  hit.instance = 0;
  return hit;
}

template <bool mixed, class Count>
bool Bvh::occluded_in(const Ray& ray, Count count) const {
  if (!is_traceable(ray)) return false;
  bool found = false;
  const BlockRay block_ray(ray);
  layout_.traverse(ray, ray.t_max, count, [&](std::uint32_t first, std::uint32_t size) {
    return found = leaves_.occluded<mixed>(block_ray, {first, size}, count);
  });
  return found;
}

}  // namespace etendue
