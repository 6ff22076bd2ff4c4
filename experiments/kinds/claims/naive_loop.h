// Ray tracing without a structure: scalar tests of one primitive after another, or, with boxes, only of the meshes whose box
// the ray meets. The product's `brute` and `bounds` test four triangles at once; the sources' did not.
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
    if (!is_traceable(ray)) return {};
    Hit hit;
    hit.t = ray.t_max;
    const SlabRay slab(ray);
    const TriangleRay shear(ray.direction);
    const TraversalLimit limit(ray, extent_);
    for (const Mesh& mesh : meshes_) {
      if (boxes_ && box_interval(slab, mesh.bounds, limit(hit.t)).empty()) continue;
      for (const std::uint32_t id : mesh.ids)
        if (intersect_primitive(geometry_, id, ray, shear, hit) && any) return hit;
    }
    if (!hit) return {};
    hit.instance = 0;
    return hit;
  }

  const Geometry& geometry_;
  bool boxes_;
  float extent_ = 0;
  std::vector<Mesh> meshes_;
};

// A simple tree: recursive traversal, one box and one primitive at a time. For closest hits.
class NaiveTree {
 public:
  NaiveTree(const Geometry& geometry, BinaryTree tree)
      : geometry_(geometry),
        tree_(std::move(tree)),
        nodes_(tree_),
        extent_(tree_.nodes.empty() ? 0 : largest_coordinate(tree_.nodes[0].bounds)) {}

  Hit closest(const Ray& ray) const {
    if (tree_.nodes.empty() || !is_traceable(ray)) return {};
    Hit hit;
    hit.t = ray.t_max;
    const TriangleRay shear(ray.direction);
    const auto leaf = [&](std::uint32_t first, std::uint32_t count) {
      for (std::uint32_t i = first; i < first + count; ++i)
        intersect_primitive(geometry_, tree_.primitives[i], ray, shear, hit);
    };
    constexpr TraversalOptions recursive{TraversalForm::recursive, true, true};
    Traversal<recursive, LoopSlab, PackedNodes, ObserveNothing, decltype(leaf)>(nodes_, ray, TraversalLimit(ray, extent_),
                                                                                hit.t, {}, leaf)
        .run(tree_.depth);
    if (!hit) return {};
    hit.instance = 0;
    return hit;
  }

 private:
  const Geometry& geometry_;
  BinaryTree tree_;
  PackedNodes nodes_;
  float extent_;
};

}  // namespace etendue
