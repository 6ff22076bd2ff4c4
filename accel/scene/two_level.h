// Two levels: one structure per object, shared by its instances, under a binary tree over the instances' boxes. They are built
// only for scenes that have instances.
//
// A ray is moved into object space by the inverse transform; its direction is not renormalised, so t means the same on both
// levels. The bottom may be any ray structure, the top any builder's tree.
#pragma once

#include "accel/bvh/layout_binary.h"
#include "accel/kernels/queries.h"
#include "framework/scene/scene.h"

namespace etendue {

// The instances of a scene with their boxes in world space, padded against the rounding of both transforms. Ids are instances';
// those of objects without a valid primitive are left out.
BuildItems instance_items(const Scene& scene);

// t_min and t_max stay: the direction is not normalised.
inline Ray to_object_space(const Transform& to_world, const Ray& ray) {
  return {to_world.inverse_point(ray.origin), ray.t_min, to_world.inverse_vector(ray.direction), ray.t_max};
}

template <RayStructure Bottom>
class TwoLevel : public Queries<TwoLevel<Bottom>> {
 public:
  // `bottoms` by object; `top` over instance_items(scene).
  TwoLevel(std::vector<Bottom> bottoms, const Scene& scene, const BinaryTree& top);

  template <bool any_hit, class Count>
  Hit trace(const Ray& ray, Count count) const;
  RayStructureStats stats() const;

 private:
  struct Placed {
    Transform to_world;
    std::uint32_t object, instance;
    bool is_identity;
  };

  std::vector<Bottom> bottoms_;
  std::vector<Placed> placed_;  // in the order of the top level's leaves
  BinaryLayout top_;
  double sah_cost_ = 0;
};

template <RayStructure Bottom>
TwoLevel<Bottom>::TwoLevel(std::vector<Bottom> bottoms, const Scene& scene, const BinaryTree& top)
    : bottoms_(std::move(bottoms)), top_(top) {
  for (const std::uint32_t id : top.primitives) {
    const Instance& instance = scene.instances[id];
    placed_.push_back({instance.to_world, instance.object, id, instance.to_world.is_identity()});
  }
  // The cost is as for one level, with a leaf at the cost of its instances' bottoms.
  std::vector<double> costs;  // which take a pass over a bottom's leaves each
  for (const Bottom& bottom : bottoms_) costs.push_back(bottom.stats().sah_cost);
  for (const TreeNode& node : top.nodes) {
    double cost = node.is_leaf() ? 0 : 1;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) cost += costs[placed_[i].object];
    sah_cost_ += cost * node.bounds.half_area() / top.nodes[0].bounds.half_area();
  }
  if (!std::isfinite(sah_cost_)) sah_cost_ = 0;
}

template <RayStructure Bottom>
template <bool any_hit, class Count>
Hit TwoLevel<Bottom>::trace(const Ray& ray, Count count) const {
  if (!is_traceable(ray)) return {};
  Hit best;
  best.t = ray.t_max;
  top_.traverse(ray, best.t, count, [&](std::uint32_t first, std::uint32_t size) {
    for (const Placed& placed : std::span(placed_).subspan(first, size)) {
      Ray local = placed.is_identity ? ray : to_object_space(placed.to_world, ray);
      local.t_max = best.t;
      const Hit hit = count.template trace<any_hit>(bottoms_[placed.object], local);
      if (!hit || (hit.t == best.t && placed.instance > best.instance)) continue;
      best = hit;
      best.instance = placed.instance;
      if (any_hit) return true;
    }
    return false;
  });
  return best ? best : Hit{};
}

template <RayStructure Bottom>
RayStructureStats TwoLevel<Bottom>::stats() const {
  RayStructureStats stats{top_.bytes() + placed_.size() * sizeof(Placed), top_.node_count(), 0, 0, sah_cost_};
  for (const Bottom& bottom : bottoms_) {
    const RayStructureStats of_bottom = bottom.stats();
    stats.bytes += of_bottom.bytes;
    stats.nodes += of_bottom.nodes;
    stats.references += of_bottom.references;
    stats.depth = std::max(stats.depth, of_bottom.depth);
  }
  stats.depth += top_.depth();
  if (!bottoms_.empty()) stats.layout = bottoms_[0].stats().layout;
  return stats;
}

}  // namespace etendue
