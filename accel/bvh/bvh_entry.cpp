#include "accel/bvh/bvh_entry.h"

#include "accel/bvh/build/pack_test.h"
#include "accel/bvh/bvh.h"
#include "accel/bvh/wide/lbvh_packs.h"
#include "accel/bvh/wide/wide_bvh.h"
#include "accel/scene/over_scene.h"
#include "framework/core/error.h"
#include "framework/core/parallel.h"

#include <algorithm>

namespace etendue {

namespace {

// The layout that traces fastest. With vectors of eight and more that is the one of sixteen children for meshes, whose packs
// then take half the memory of narrower ones, and for so few triangles that they mostly fit in a few packs, which are tested
// whole. (For numbers between, any layout needs two or three visits, which cost less with narrower nodes.)
std::string resolved_layout(const std::string& layout, const Scene& scene) {
  if (layout != "auto") return layout;
  constexpr std::uint32_t few = 48, mesh = 4096;
  std::uint32_t largest = 0;
  for (const Object& object : scene.objects) largest = std::max(largest, object.geometry.primitive_count());
  const Isa isa = chosen_isa();
  if (isa < Isa::avx2) return "binary";
  return largest <= few || largest >= mesh ? "bvh16" : "bvh8";
}

// Does the tree of a wide layout go down to single primitives, of which the collapse makes the leaves? That of an optimised one
// does, and so does that over more quadrics than triangles: a leaf tests quadrics one by one, so that they share a leaf only
// where the collapse finds that to cost less (a fifth of the time on builtin:white-furnace).
bool reaches_primitives(const ConfiguredBuilder& builder, const Geometry& geometry) {
  return builder.reinsertion || geometry.quadrics.size() > geometry.triangles.size();
}

MemoryNeed need_of(const ConfiguredBuilder& builder, const Scene& scene) {
  const std::string layout = resolved_layout(builder.layout, scene);
  return scene_need(scene, [&](const Geometry& geometry) {
    return bvh_need(geometry, layout, builder.leaf_size, reaches_primitives(builder, geometry), builder.space);
  });
}

TreeTask watched_task(const ConfiguredBuilder& builder, const Scene& scene, MemoryWatch* watch) {
  TreeTask task{.watch = watch};
  double references = 0;
  for (const Object& object : scene.objects) references += builder.space.references * object.geometry.primitive_count();
  if (watch != nullptr && references > 0)
    task.bytes_per_reference = static_cast<std::uint64_t>(static_cast<double>(need_of(builder, scene).peak) / references);
  return task;
}

// The task of building a tree for the binary layout.
TreeTask binary_task(const ConfiguredBuilder& builder, const Geometry* geometry) {
  TreeTask task{.geometry = geometry};
  if (builder.leaf_size > 0) task.leaf_size = builder.leaf_size;
  return task;
}

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

// Bottom levels in a wide layout. The tree goes down to what a pack takes, or to single primitives (reaches_primitives).
template <class Wide>
std::unique_ptr<RayQuery> wide_over_scene(const Scene& scene, const ConfiguredBuilder& builder, const TreeTask& task) {
  CollapseOptions options;
  if (builder.leaf_size > 0) options.leaf_size = static_cast<std::uint32_t>(builder.leaf_size);
  if (builder.primitive_cost) options.leaf_cost = 1.5f * *builder.primitive_cost;  // of a whole pack
  TreeTask fine = task, single = task;
  single.leaf_size = 1;
  fine.full_leaves = true;  // so many are a leaf in any case
  return over_scene(
      scene, task.watch,
      [&](const Geometry& geometry) {
        const bool single_first = reaches_primitives(builder, geometry), to_packs = builder.leaf_size == 0 && !single_first;
        fine.leaf_size = single_first ? 1 : Wide::tree_leaf_size;
        if (builder.leaf_size > 0) fine.leaf_size = std::min(fine.leaf_size, builder.leaf_size);
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

RayEntry bvh_entry(const char* name, const char* summary, std::vector<ParamInfo> params,
                   const std::function<ConfiguredBuilder(const ParamMap&)>& read) {
  RayEntry entry{.name = name, .summary = summary, .params = std::move(params)};
  entry.need = [read](const Scene& scene, const ParamMap& map) { return need_of(read(map), scene); };
  entry.build = [read](const Scene& scene, const ParamMap& map, MemoryWatch* watch) {
    const ConfiguredBuilder builder = read(map);
    const std::string layout = resolved_layout(builder.layout, scene);
    const TreeTask task = watched_task(builder, scene, watch);
    if (layout == "bvh4") return wide_over_scene<Bvh4>(scene, builder, task);
    if (layout == "bvh8") return wide_over_scene<Bvh8>(scene, builder, task);
    if (layout == "bvh16") return wide_over_scene<Bvh16>(scene, builder, task);
    return binary_over_scene(scene, builder, task);
  };
  entry.tree = [read](const Geometry& geometry, const ParamMap& map) {
    const ConfiguredBuilder builder = read(map);
    return builder.build(build_items(geometry), binary_task(builder, &geometry));
  };
  entry.builder = [read, name = std::string(name)](const ParamMap& map) -> TreeBuilder {
    const ConfiguredBuilder builder = read(map);
    if (builder.layout != "binary" && builder.layout != "auto")
      throw Error(map.at("layout").where, name + ": layout '" + builder.layout + "' cannot change over time; expected binary");
    if (builder.budget.memory > 0)
      throw Error(map.at("memory").where, name + ": trees that change over time take no memory budget; expected none");
    return [builder](BuildItems items) { return builder.build(std::move(items), binary_task(builder, nullptr)); };
  };
  return entry;
}

}  // namespace etendue
