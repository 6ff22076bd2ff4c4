#include "accel/bvh/bvh_over_scene.h"

#include "accel/bvh/build/pack_test.h"
#include "accel/bvh/bvh.h"
#include "accel/bvh/wide/lbvh_packs.h"
#include "accel/bvh/wide/wide_bvh.h"
#include "accel/scene/over_scene.h"
#include "framework/core/parallel.h"

#include <algorithm>

namespace etendue {

namespace {

std::unique_ptr<RayQuery> binary_over_scene(const Scene& scene, const ConfiguredBuilder& builder, TreeTask task) {
  if (builder.leaf_size > 0) task.leaf_size = builder.leaf_size;
  return over_scene(
      scene, task.watch,
      [&](const Geometry& geometry) {
        task.geometry = &geometry;
        return Bvh(geometry, builder.build(build_items(geometry), task));
      },
      [&](BuildItems items) {
        task.geometry = nullptr;
        return builder.build(std::move(items), task);
      });
}

// Bottom levels in a wide layout. For a quick build the tree goes down to what a pack takes; for an optimised one, to single
// primitives, of which the collapse makes the leaves.
template <class Wide>
std::unique_ptr<RayQuery> wide_over_scene(const Scene& scene, const ConfiguredBuilder& builder, const TreeTask& task) {
  CollapseOptions options;
  if (builder.leaf_size > 0) options.leaf_size = static_cast<std::uint32_t>(builder.leaf_size);
  if (builder.primitive_cost) options.leaf_cost = 1.5f * *builder.primitive_cost;  // of a whole pack
  TreeTask fine = task, single = task;
  single.leaf_size = 1;
  fine.leaf_size = builder.reinsertion ? 1 : Wide::tree_leaf_size;
  if (builder.leaf_size > 0) fine.leaf_size = std::min(fine.leaf_size, builder.leaf_size);
  fine.full_leaves = true;  // so many are a leaf in any case
  const bool to_packs = builder.leaf_size == 0 && !builder.reinsertion;
  return over_scene(
      scene, task.watch,
      [&](const Geometry& geometry) {
        if (to_packs && builder.sorts_to_packs)
          if (auto packs = build_lbvh_packs<typename Wide::LeafPack>(geometry, {fine.leaf_size, builder.max_depth}))
            return Wide(geometry, std::move(*packs));
        std::optional<VertexIds> vertices;
        BuildItems items;
        // The longer task goes to the thread that comes later: what then remains of it is shared.
        parallel_invoke([&] { items = build_items(geometry); }, [&] { vertices.emplace(geometry); });
        const PackTest packs = PackTest::of<typename Wide::LeafPack>(*vertices);
        fine.geometry = &geometry;
        fine.packs = to_packs ? &packs : nullptr;
        const BinaryTree tree = builder.build(std::move(items), fine);
        CollapseOptions collapse = options;
        collapse.leaves_are_packs = to_packs && static_cast<int>(tree.depth) < builder.max_depth;
        collapse.each_is_a_pack = collapse.leaves_are_packs && geometry.quadrics.empty();
        return Wide(*vertices, tree, collapse);
      },
      [&](BuildItems items) { return builder.build(std::move(items), single); });
}

}  // namespace

std::unique_ptr<RayQuery> bvh_over_scene(const Scene& scene, const std::string& layout, const ConfiguredBuilder& builder,
                                         const TreeTask& task) {
  if (layout == "bvh4") return wide_over_scene<Bvh4>(scene, builder, task);
  if (layout == "bvh8") return wide_over_scene<Bvh8>(scene, builder, task);
  if (layout == "bvh16") return wide_over_scene<Bvh16>(scene, builder, task);
  return binary_over_scene(scene, builder, task);
}

}  // namespace etendue
