// One bounding box per mesh, and a test of every primitive in the meshes whose box the ray meets: the first step beyond brute
// force ([Rubin1980], with the single level that a model's meshes give).
//
// A mesh is a Shape of the object: a file's mesh with its material, or one quadric. Its primitives lie together and are tested
// four at a time. Work grows with the primitives of the meshes that are met, so a scene of one large mesh costs what brute
// force costs. Memory: 32 bytes per mesh, 44 per triangle (the copied vertices and ids).
#pragma once

#include "accel/kernels/box_test.h"
#include "accel/kernels/leaf.h"
#include "framework/scene/scene.h"

namespace etendue {

class MeshBounds : public LeafQueries<MeshBounds, LeafTest> {
 public:
  // `object` must outlive the structure. Primitives that no shape names make one more mesh.
  explicit MeshBounds(const Object& object);

  template <class Count, class Leaf>
  void traverse(const Ray& ray, const float& t_best, Count& count, const Leaf& leaf) const;
  const Leaves& leaves() const { return leaves_; }
  // Nodes are the meshes' boxes. The SAH cost includes testing every box, since all lie in the box of the whole.
  RayStructureStats stats() const;

 private:
  struct Mesh {
    Bounds bounds;
    Leaves::Run primitives;
  };

  Leaves leaves_;
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
    if (box_interval(slab, mesh.bounds, limit_beyond(t_best)).empty()) continue;
    if (leaf(mesh.primitives)) return;
  }
}

struct RayEntry bounds_entry();  // its row of the registry

}  // namespace etendue
