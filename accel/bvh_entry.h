// The registry's row of a bounding volume hierarchy: any builder, in any layout, optimised or not. For accel/registry.cpp.
#pragma once

#include "accel/memory_need.h"
#include "accel/over_scene.h"
#include "accel/ray/build_lbvh.h"
#include "accel/ray/build_lbvh_packs.h"
#include "accel/ray/bvh.h"
#include "accel/ray/pack_test.h"
#include "accel/ray/reinsertion.h"
#include "accel/ray/wide_bvh.h"
#include "accel/registry.h"
#include "framework/core/error.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <optional>
#include <string>

namespace etendue {

// The parameters of a builder, and of the layout of its trees in memory.
template <class BuilderParams>
struct BvhParams : BuilderParams {
  std::string layout = "binary";
  int reinsertion = 0;

  BvhParams() { this->leaf_size = 0; }
};

template <class Visitor, class BuilderParams>
void describe(Visitor& v, BvhParams<BuilderParams>& params) {
  describe(v, static_cast<BuilderParams&>(params));
  v.choice("layout", params.layout, {"binary", "wide4", "wide8", "wide16", "auto"},
           "nodes of two children; or of 4, 8 or 16, with SIMD packs of triangles as leaves; or what suits scene and machine");
  v.integer("reinsertion", params.reinsertion, 0, 100, "passes",
            "of optimisation, at most: subtrees put where they cost least");
}

// Bottom levels in a wide layout. For a quick build the tree goes down to what a pack takes; for an optimised one, to single
// primitives, of which the collapse makes the leaves.
template <class Wide, class Params, class Build>
std::unique_ptr<RayQuery> wide_over_scene(const Scene& scene, const Params& params, MemoryWatch* watch, const Build& build) {
  CollapseOptions options;
  if (params.leaf_size > 0) options.leaf_size = static_cast<std::uint32_t>(params.leaf_size);
  if constexpr (requires { params.primitive_cost; }) options.leaf_cost = 1.5f * params.primitive_cost;  // of a whole pack
  Params fine = params, single = params;
  single.leaf_size = 1;
  fine.leaf_size = params.reinsertion > 0 ? 1 : Wide::tree_leaf_size;
  if (params.leaf_size > 0) fine.leaf_size = std::min(fine.leaf_size, params.leaf_size);
  if constexpr (requires { fine.primitive_cost; }) fine.primitive_cost = 0;  // so many are a leaf in any case
  const bool to_packs = params.leaf_size == 0 && params.reinsertion == 0;
  return over_scene(
      scene, watch,
      [&](const Geometry& geometry) {
        if constexpr (std::derived_from<Params, LbvhParams>)
          if (to_packs)
            if (auto packs = build_lbvh_packs<typename Wide::LeafPack>(geometry, fine))
              return Wide(geometry, std::move(*packs));
        std::optional<VertexIds> vertices;
        std::vector<BuildItem> items;
        tbb::parallel_invoke([&] { vertices.emplace(geometry); }, [&] { items = build_items(geometry); });
        const PackTest packs = PackTest::of<typename Wide::LeafPack>(*vertices);
        Params limits = fine;
        if (to_packs) limits.packs = &packs;
        const BinaryTree tree = build(std::move(items), limits, &geometry);
        CollapseOptions collapse = options;
        collapse.leaves_are_packs = to_packs && static_cast<int>(tree.depth) < limits.max_depth;
        collapse.each_is_a_pack = collapse.leaves_are_packs && geometry.quadrics.empty();
        return Wide(*vertices, tree, collapse);
      },
      [&](std::vector<BuildItem> items) { return build(std::move(items), single, nullptr); });
}

// The layout that traces fastest: the widest that the machine's instructions support, but sixteen children only for meshes, and
// for triangles so few that they mostly fit in a few packs, which are tested whole. (For numbers between, any layout needs two
// or three visits, which cost less with narrower nodes.)
inline std::string resolved_layout(const std::string& layout, const Scene& scene) {
  if (layout != "auto") return layout;
  constexpr std::uint32_t few = 48, mesh = 4096;
  std::uint32_t largest = 0;
  for (const Object& object : scene.objects) largest = std::max(largest, object.geometry.primitive_count());
  const Isa isa = supported_isas().back();
  return isa == Isa::avx512 && (largest <= few || largest >= mesh) ? "wide16" : isa >= Isa::avx2 ? "wide8" : "binary";
}

// A row of the table for a builder. The tree over instances has the same builder and the binary layout. `space(params)`: the
// builder's BuilderSpace.
template <class BuilderParams, class Space>
RayEntry bvh_entry(const char* name, const char* summary, const Space& space,
                   BinaryTree (*build_tree)(std::vector<BuildItem>, const BuilderParams&, const Geometry*)) {
  using Params = BvhParams<BuilderParams>;
  const auto build = [build_tree](std::vector<BuildItem> items, const Params& params, const Geometry* geometry) {
    BinaryTree tree = build_tree(std::move(items), params, geometry);
    reinsert_subtrees(tree, params.reinsertion);
    return tree;
  };
  const auto binary_params = [name](const ParamMap& map) {
    auto params = read_watched<Params>(map, name, nullptr);
    if (params.leaf_size == 0) params.leaf_size = TreeLimits().leaf_size;
    return params;
  };
  RayEntry entry{.name = name, .summary = summary, .params = list_params<WithMemory<Params>>()};
  entry.need = [=](const Scene& scene, const ParamMap& map) {
    const auto params = read_watched<Params>(map, name, nullptr);
    return scene_need(scene, [&](const Geometry& geometry) {
      return bvh_need(geometry, resolved_layout(params.layout, scene), params.leaf_size, params.reinsertion > 0, space(params));
    });
  };
  entry.build = [=, need = entry.need](const Scene& scene, const ParamMap& map, MemoryWatch* watch) {
    auto params = read_watched<Params>(map, name, watch);
    if constexpr (requires { params.bytes_per_reference; }) {
      double references = 0;
      for (const Object& object : scene.objects) references += space(params).references * object.geometry.primitive_count();
      if (watch != nullptr && references > 0)
        params.bytes_per_reference = static_cast<std::uint64_t>(static_cast<double>(need(scene, map).peak) / references);
    }
    const std::string layout = resolved_layout(params.layout, scene);
    if (layout == "wide4") return wide_over_scene<Wide4Bvh>(scene, params, watch, build);
    if (layout == "wide8") return wide_over_scene<Wide8Bvh>(scene, params, watch, build);
    if (layout == "wide16") return wide_over_scene<Wide16Bvh>(scene, params, watch, build);
    if (params.leaf_size == 0) params.leaf_size = TreeLimits().leaf_size;
    return over_scene(
        scene, watch, [&](const Geometry& geometry) { return Bvh(geometry, build(build_items(geometry), params, &geometry)); },
        [&](std::vector<BuildItem> items) { return build(std::move(items), params, nullptr); });
  };
  entry.tree = [=](const Geometry& geometry, const ParamMap& map) {
    return build(build_items(geometry), binary_params(map), &geometry);
  };
  entry.builder = [=](const ParamMap& map) -> TreeBuilder {
    const auto params = binary_params(map);
    if (params.layout != "binary" && params.layout != "auto")
      throw Error(map.at("layout").where,
                  std::string(name) + ": layout '" + params.layout + "' cannot change over time; expected binary");
    if (const auto budget = read_with_memory<Params>(map, name).budget; budget.memory > 0)
      throw Error(map.at("memory").where,
                  std::string(name) + ": trees that change over time take no memory budget; expected none");
    return [params, build](std::vector<BuildItem> items) { return build(std::move(items), params, nullptr); };
  };
  return entry;
}

// A row for a builder that sees boxes only, with the space it takes per primitive.
template <class BuilderParams, BinaryTree (*build)(std::vector<BuildItem>, const BuilderParams&)>
RayEntry bvh_entry(const char* name, const char* summary, double bytes_per_primitive) {
  return bvh_entry<BuilderParams>(
      name, summary,
      [=](const BuilderParams& params) {
        constexpr int enough = 32;  // for any number of primitives: runs are halved in time (must_halve), to what a pack takes
        return BuilderSpace{bytes_per_primitive, 1, std::derived_from<BuilderParams, LbvhParams> && params.max_depth >= enough};
      },
      [](std::vector<BuildItem> items, const BuilderParams& params, const Geometry*) {
        return build(std::move(items), params);
      });
}

}  // namespace etendue
