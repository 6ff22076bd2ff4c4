// Ray tracing without a structure, or with a plain one: scalar tests of one primitive after another; or only of the meshes
// whose box the ray meets; or of the leaves of a binary tree. The product's `brute` and `bounds` test four triangles at once;
// the sources' did not.
#pragma once

#include "experiments/kinds/claims/traversal_variants.h"
#include "framework/scene/scene.h"

namespace etendue {

class NaiveLoop {
 public:
  // Over the world's own geometry, which must outlive this; a mesh is a shape of it.
  NaiveLoop(const Scene& scene, bool boxes) : geometry_(scene.objects[0].geometry), boxes_(boxes) {
    for (const Shape& shape : scene.objects[0].shapes) {
      Mesh& mesh = meshes_.emplace_back();
      for (std::uint32_t id = shape.first_primitive; id < shape.first_primitive + shape.primitive_count; ++id) {
        if (!geometry_.is_valid(id)) continue;
        mesh.ids.push_back(id);
        mesh.bounds.extend(geometry_.primitive_bounds(id));
      }
      if (!mesh.ids.empty()) extent_ = std::max(extent_, largest_coordinate(mesh.bounds));
    }
  }

  Hit closest(const Ray& ray) const { return nearest(ray, false); }
  bool occluded(const Ray& ray) const { return static_cast<bool>(nearest(ray, true)); }

 private:
  struct Mesh {
    Bounds bounds;
    std::vector<std::uint32_t> ids;
  };

  Hit nearest(const Ray& ray, bool any) const {
    const ScalarSlab slab(ray);
    const TriangleRay shear(ray.direction);
    return closest_of(ray, extent_, [&](Hit& hit, const TraversalLimit& limit) {
      for (const Mesh& mesh : meshes_) {
        if (boxes_ && slab.entry(mesh.bounds, limit(hit.t)) == infinity) continue;
        for (const std::uint32_t id : mesh.ids)
          if (intersect_primitive(geometry_, id, ray, shear, hit) && any) return;
      }
    });
  }

  const Geometry& geometry_;
  bool boxes_;
  float extent_ = 0;
  std::vector<Mesh> meshes_;
};

// A tree whose leaves' primitives are tested one by one; it finds closest hits only.
class NaiveTree {
 public:
  NaiveTree(const Geometry& geometry, BinaryTree tree)
      : geometry_(geometry),
        tree_(std::move(tree)),
        nodes_(tree_),
        extent_(tree_.nodes.empty() ? 0 : largest_coordinate(tree_.nodes[0].bounds)) {}

  // Lecture notes have it so: recursion, one box at a time.
  Hit closest(const Ray& ray) const {
    return closest<TraversalOptions{TraversalForm::recursive, true, true}, LoopSlab>(
        ray, [](std::uint32_t, const TraversalLimit&, float) { return true; });
  }

  // Tests only the primitives for which wanted(id, limit, t_best) holds.
  template <TraversalOptions options, class Slab, class Wanted>
  Hit closest(const Ray& ray, const Wanted& wanted) const {
    if (tree_.nodes.empty()) return {};
    const TriangleRay shear(ray.direction);
    return closest_of(ray, extent_, [&](Hit& hit, const TraversalLimit& limit) {
      const auto leaf = [&](std::uint32_t first, std::uint32_t count) {
        for (std::uint32_t i = first; i < first + count; ++i)
          if (const std::uint32_t id = tree_.primitives[i]; wanted(id, limit, hit.t))
            intersect_primitive(geometry_, id, ray, shear, hit);
      };
      traverse<options, Slab>(tree_, nodes_, ray, limit, hit.t, leaf);
    });
  }

  float extent() const { return extent_; }

 private:
  const Geometry& geometry_;
  BinaryTree tree_;
  PackedNodes nodes_;
  float extent_;
};

}  // namespace etendue
