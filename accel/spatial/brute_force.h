// Brute force: every primitive for every ray. Without boxes that could lose a hit, it is the reference for the other
// structures, and fast enough for a handful of primitives.
#pragma once

#include "accel/kernels/counting.h"
#include "accel/kernels/leaf.h"

namespace etendue {

class BruteForce {
 public:
  // `geometry` must outlive the structure.
  explicit BruteForce(const Geometry& geometry);

  Hit closest(const Ray& ray) const { return closest_with(ray, CountNothing{}); }
  bool occluded(const Ray& ray) const { return occluded_with(ray, CountNothing{}); }
  Hit closest_counted(const Ray& ray, TraversalCounters& counters) const { return closest_with(ray, CountWork{counters}); }
  bool occluded_counted(const Ray& ray, TraversalCounters& counters) const { return occluded_with(ray, CountWork{counters}); }
  RayStructureStats stats() const;

 private:
  template <class Count>
  Hit closest_with(const Ray& ray, Count count) const;
  template <class Count>
  bool occluded_with(const Ray& ray, Count count) const;

  LeafBlocks blocks_;
  LeafBlocks::Run all_;
};

template <class Count>
Hit BruteForce::closest_with(const Ray& ray, Count count) const {
  if (!is_traceable(ray)) return {};
  Hit hit;
  hit.t = ray.t_max;
  const BlockRay block_ray(ray);
  if (blocks_.mixed())
    blocks_.closest<true>(block_ray, all_, hit, count);
  else
    blocks_.closest<false>(block_ray, all_, hit, count);
  if (!hit) return {};
  hit.instance = 0;
  return hit;
}

template <class Count>
bool BruteForce::occluded_with(const Ray& ray, Count count) const {
  if (!is_traceable(ray)) return false;
  const BlockRay block_ray(ray);
  return blocks_.mixed() ? blocks_.occluded<true>(block_ray, all_, count) : blocks_.occluded<false>(block_ray, all_, count);
}

struct RayEntry brute_entry();  // its row of the registry

}  // namespace etendue
