// Trees of boxes against cells of space: claims about octrees, grids, duplicates and overlap, and about what fits into memory.
#include "accel/bvh/bvh.h"
#include "experiments/kinds/claims/measurement.h"

#include <fmt/format.h>

namespace etendue {

namespace {

void measure_cells(Trial& t) {
  const TrialRays all = t.record_rays();
  // The grid may be slow beyond measure: then all get fewer rays.
  const TrialRays rays = affordable_sample(t.make("grid"), all, 0.5);
  if (rays.closest.size() < all.closest.size())
    t.remark(fmt::format("{}: on {} of {} rays, evenly spread, since the grid takes so long.", t.task.scene, rays.size(),
                         all.size()));
  const RayQuery& tree = t.make("binned-sah");
  for (const char* name : {"octree", "kd-tree", "grid"})
    t.hold_to(tree, rays.closest, [&other = t.make(name)](const Ray& ray) { return other.closest(ray); });
  t.race_structures(rays);
}

// Leaves of a tree whose box holds a point, or comes as near to it as rounding may have put it off.
std::uint64_t leaves_around(const BinaryTree& tree, const vec3& p, float slack, std::uint32_t node = 0) {
  const TreeNode& n = tree.nodes[node];
  if (!Bounds{n.bounds.lower - slack, n.bounds.upper + slack}.contains(p)) return 0;
  return n.is_leaf() ? 1 : leaves_around(tree, p, slack, n.first) + leaves_around(tree, p, slack, n.first + 1);
}

double primitives_of(const Trial& t) { return static_cast<double>(t.scene.objects[0].geometry.valid_primitives().size()); }

BinaryTree tree_of(const Trial& t, const ParamMap& params = {}) {
  return find_ray_structure("binned-sah", {}).tree(t.scene.objects[0].geometry, params);
}

void measure_duplicates(Trial& t) {
  for (const auto& [quantity, structure] :
       {std::pair{"kd_tree", "kd-tree"}, {"octree", "octree"}, {"bvh", "binned-sah"}, {"sbvh", "sbvh"}})
    t.count(quantity, static_cast<double>(t.make(structure).stats().references) / primitives_of(t));
  const BinaryTree tree = tree_of(t);
  const RayQuery& product = t.make("binned-sah");
  const float slack = 4 * std::numeric_limits<float>::epsilon() * largest_coordinate(tree.nodes[0].bounds);
  std::uint64_t leaves = 0, hits = 0;
  for (const Ray& ray : t.record_rays().closest)
    if (const Hit hit = product.closest(ray)) {
      leaves += leaves_around(tree, ray.at(hit.t), slack);
      ++hits;
    }
  t.count("bvh_overlap", hits > 0 ? static_cast<double>(leaves) / static_cast<double>(hits) : 0);
}

void measure_node_arithmetic(Trial& t) {
  constexpr double budget = 512.0 * (1 << 20);
  const BinaryTree single = tree_of(t, params_of("leaf_size=1"));
  const BinaryLayout layout(single);
  const double node_bytes = static_cast<double>(layout.bytes()) / static_cast<double>(layout.node_count());
  const auto whole = [&](const RayQuery& structure) {
    return budget / (static_cast<double>(structure.stats().bytes) / primitives_of(t)) / 1e6;
  };
  t.count("node_bytes", node_bytes);
  t.count("nodes_per_primitive", static_cast<double>(single.nodes.size()) / primitives_of(t));
  t.count("million_nodes", budget / node_bytes / 1e6);
  t.count("million_primitives_by_claim", budget / 64 / 2 / 1e6);
  t.count("million_primitives", whole(t.make("binned-sah")));
  t.count("million_primitives_wide", whole(t.make("binned-sah layout=bvh16")));
  t.remark(
      "The product keeps inner nodes only, with the boxes of both children, and leaves apart: about n nodes of 64 bytes for n "
      "single primitives. What 512 MiB hold is of primitives, leaves and copied vertices included.");
}

}  // namespace

std::vector<Measurement> space_measurements() {
  constexpr auto factor = FigureKind::factor, plain = FigureKind::plain;
  return {{"cells",
           "time for the same rays, over that in a binary tree of boxes (binned SAH)",
           {{"octree", factor, "octree over BVH", "octree", "binned-sah"},
            {"kd_tree", factor, "kd-tree over BVH", "kd-tree", "binned-sah"},
            {"grid", factor, "grid over BVH", "grid", "binned-sah"},
            {"octree_over_wide", factor, "octree over BVH in the bvh16 layout", "octree", "binned-sah layout=bvh16"}},
           measure_cells},
          {"duplicates",
           "references to primitives, and leaves around a point of a surface",
           {{"kd_tree", factor, "references per primitive, kd-tree"},
            {"octree", factor, "references per primitive, octree"},
            {"bvh", plain, "references per primitive, BVH"},
            {"sbvh", factor, "references per primitive, BVH with spatial splits"},
            {"bvh_overlap", factor, "leaf boxes around a hit point, BVH"}},
           measure_duplicates},
          {"node-arithmetic",
           "nodes of a tree and their bytes",
           {{"node_bytes", plain, "bytes per node"},
            {"nodes_per_primitive", plain, "nodes per primitive, leaves of one"},
            {"million_nodes", plain, "million nodes in 512 MiB"},
            {"million_primitives_by_claim", plain, "million primitives in 512 MiB, as the claim counts"},
            {"million_primitives", plain, "million primitives in 512 MiB, binary layout"},
            {"million_primitives_wide", plain, "million primitives in 512 MiB, bvh16 layout"}},
           measure_node_arithmetic}};
}

}  // namespace etendue
