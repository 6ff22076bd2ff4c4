// One bounding box per mesh, and a test of every primitive in the meshes whose box the ray meets: the first step beyond brute
// force ([Rubin1980], with the single level that a model's meshes give).
//
// A mesh is a Shape of the object: a file's mesh with its material, or one quadric. Its primitives lie together and are tested
// four at a time. Work grows with the primitives of the meshes that are met, so a scene of one large mesh costs what brute
// force costs. Memory: 32 bytes per mesh, 44 per triangle (the copied vertices and ids).
#pragma once

#include "accel/kernels/counting.h"
#include "accel/kernels/leaf.h"
#include "accel/kernels/traversal_limit.h"
#include "framework/scene/scene.h"

namespace etendue {

class MeshBounds {
 public:
  // `object` must outlive the structure. Primitives that no shape names make one more mesh.
  explicit MeshBounds(const Object& object);

  Hit closest(const Ray& ray) const { return closest_with(ray, CountNothing{}); }
  bool occluded(const Ray& ray) const { return occluded_with(ray, CountNothing{}); }
  Hit closest_counted(const Ray& ray, TraversalCounters& counters) const { return closest_with(ray, CountWork{counters}); }
  bool occluded_counted(const Ray& ray, TraversalCounters& counters) const { return occluded_with(ray, CountWork{counters}); }
  // Nodes are the meshes' boxes. The SAH cost includes testing every box, since all lie in the box of the whole.
  RayStructureStats stats() const;

 private:
  struct Mesh {
    Bounds bounds;
    LeafBlocks::Run primitives;
  };

  template <class Count, class Leaf>
  void traverse(const Ray& ray, const float& t_best, Count& count, const Leaf& leaf) const;
  template <class Count>
  Hit closest_with(const Ray& ray, Count count) const;
  template <class Count>
  bool occluded_with(const Ray& ray, Count count) const;

  LeafBlocks blocks_;
  std::vector<Mesh> meshes_;
  Bounds bounds_;
  double sah_cost_ = 0;
};

template <class Count, class Leaf>
void MeshBounds::traverse(const Ray& ray, const float& t_best, Count& count, const Leaf& leaf) const {
  const SlabRay slab(ray);
  const TraversalLimit limit_beyond(ray, largest_coordinate(bounds_));
  for (const Mesh& mesh : meshes_) {
    count.node();
    if (slab_entry(slab, mesh.bounds.lower, mesh.bounds.upper, ray.t_min, limit_beyond(t_best)) == infinity) continue;
    if (leaf(mesh.primitives)) return;
  }
}

template <class Count>
Hit MeshBounds::closest_with(const Ray& ray, Count count) const {
  if (!is_traceable(ray)) return {};
  Hit hit;
  hit.t = ray.t_max;
  const BlockRay block_ray(ray);
  traverse(ray, hit.t, count, [&](LeafBlocks::Run run) {
    if (blocks_.mixed())
      blocks_.closest<true>(block_ray, run, hit, count);
    else
      blocks_.closest<false>(block_ray, run, hit, count);
    return false;
  });
  if (!hit) return {};
  hit.instance = 0;
  return hit;
}

template <class Count>
bool MeshBounds::occluded_with(const Ray& ray, Count count) const {
  if (!is_traceable(ray)) return false;
  bool found = false;
  const BlockRay block_ray(ray);
  traverse(ray, ray.t_max, count, [&](LeafBlocks::Run run) {
    return found =
               blocks_.mixed() ? blocks_.occluded<true>(block_ray, run, count) : blocks_.occluded<false>(block_ray, run, count);
  });
  return found;
}

struct RayEntry bounds_entry();  // its row of the registry

}  // namespace etendue
