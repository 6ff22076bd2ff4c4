// Trees of boxes against cells of space: claims about octrees, grids, duplicates and overlap, and about what fits into memory.
#include "accel/bvh/bvh.h"
#include "experiments/kinds/claims/claim_scenes.h"
#include "experiments/kinds/claims/measure_tools.h"

#include <fmt/format.h>

namespace etendue {

namespace {

using FigureKind::factor, FigureKind::plain;

MeasureResult measure_cells(const MeasureTask& task) {
  const Scene scene = load_claim_scene(task.scene, task.reading);
  const ClaimRays all = record_claim_rays(scene, task.resolution);
  const auto tree = make_structure(scene, "binned-sah"),
             wide = make_structure(scene, "binned-sah", text_param("layout", "bvh16")),
             octree = make_structure(scene, "octree"), kd = make_structure(scene, "kd-tree"),
             grid = make_structure(scene, "grid");
  // The grid may be slow beyond measure: then all get fewer rays.
  const ClaimRays rays = affordable_sample(*grid, all, 0.5);
  MeasureResult result;
  if (rays.closest.size() < all.closest.size())
    result.remarks.push_back(fmt::format("{}: on {} of {} rays, evenly spread, since the grid takes so long.", task.scene,
                                         rays.closest.size() + rays.shadow.size(), all.closest.size() + all.shadow.size()));
  for (const RayQuery* other : {octree.get(), kd.get(), grid.get()})
    result.disagreements += count_disagreements(*tree, rays.closest, [&](const Ray& ray) { return other->closest(ray); });
  const auto with = [&](const RayQuery& query) { return [&] { trace_rays(query, rays); }; };
  const Times times = take_turns(task, {with(*tree), with(*octree), with(*kd), with(*grid), with(*wide)});
  result.add("octree", ratio_of(times[1], times[0]));
  result.add("kd_tree", ratio_of(times[2], times[0]));
  result.add("grid", ratio_of(times[3], times[0]));
  result.add("octree_over_wide", ratio_of(times[1], times[4]));
  return result;
}

// Leaves of a tree whose box holds a point, or comes as near to it as rounding may have put it off.
std::uint64_t leaves_around(const BinaryTree& tree, const vec3& p, float slack, std::uint32_t node = 0) {
  const TreeNode& n = tree.nodes[node];
  if (!Bounds{n.bounds.lower - slack, n.bounds.upper + slack}.contains(p)) return 0;
  return n.is_leaf() ? 1 : leaves_around(tree, p, slack, n.first) + leaves_around(tree, p, slack, n.first + 1);
}

MeasureResult measure_duplicates(const MeasureTask& task) {
  const Scene scene = load_claim_scene(task.scene, task.reading);
  const Geometry& geometry = scene.objects[0].geometry;
  const auto primitives = static_cast<double>(geometry.valid_primitives().size());
  const auto references = [&](const char* name) {
    return static_cast<double>(make_structure(scene, name)->stats().references) / primitives;
  };
  MeasureResult result;
  result.add("kd_tree", references("kd-tree"));
  result.add("octree", references("octree"));
  result.add("bvh", references("binned-sah"));
  result.add("sbvh", references("sbvh"));
  const BinaryTree tree = find_ray_structure("binned-sah", {}).tree(geometry, {});
  const auto product = make_structure(scene, "binned-sah");
  const float slack = 4 * std::numeric_limits<float>::epsilon() * largest_coordinate(tree.nodes[0].bounds);
  std::uint64_t leaves = 0, hits = 0;
  for (const Ray& ray : record_claim_rays(scene, task.resolution).closest)
    if (const Hit hit = product->closest(ray)) {
      leaves += leaves_around(tree, ray.at(hit.t), slack);
      ++hits;
    }
  result.add("bvh_overlap", hits > 0 ? static_cast<double>(leaves) / static_cast<double>(hits) : 0);
  return result;
}

MeasureResult measure_node_arithmetic(const MeasureTask& task) {
  constexpr double budget = 512.0 * (1 << 20);
  const Scene scene = load_claim_scene(task.scene, task.reading);
  const Geometry& geometry = scene.objects[0].geometry;
  const auto primitives = static_cast<double>(geometry.valid_primitives().size());
  const BinaryTree single = find_ray_structure("binned-sah", {}).tree(geometry, whole_param("leaf_size", 1));
  const BinaryLayout layout(single);
  const double node_bytes = static_cast<double>(layout.bytes()) / static_cast<double>(layout.node_count());
  const auto whole = [&](const ParamMap& params) {
    return budget / (static_cast<double>(make_structure(scene, "binned-sah", params)->stats().bytes) / primitives) / 1e6;
  };
  MeasureResult result;
  result.add("node_bytes", node_bytes);
  result.add("nodes_per_primitive", static_cast<double>(single.nodes.size()) / primitives);
  result.add("million_nodes", budget / node_bytes / 1e6);
  result.add("million_primitives_by_claim", budget / 64 / 2 / 1e6);
  result.add("million_primitives", whole({}));
  result.add("million_primitives_wide", whole(text_param("layout", "bvh16")));
  result.remarks.push_back(
      "The product keeps inner nodes only, with the boxes of both children, and leaves apart: about n nodes of 64 bytes for n "
      "single primitives. What 512 MiB hold is of primitives, leaves and copied vertices included.");
  return result;
}

}  // namespace

std::vector<Measurement> space_measurements() {
  return {{"cells",
           "time for the same rays, over that in a binary tree of boxes (binned SAH)",
           {{"octree", factor, "octree over BVH"},
            {"kd_tree", factor, "kd-tree over BVH"},
            {"grid", factor, "grid over BVH"},
            {"octree_over_wide", factor, "octree over BVH in the bvh16 layout"}},
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
