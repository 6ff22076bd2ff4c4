// The registry's row of a bounding volume hierarchy: any builder, in any layout, optimised or not. Layouts know a builder by
// one function alone, so that what traverses trees is compiled once (bvh_entry.cpp) and not again for each builder.
#pragma once

#include "accel/bvh/build/reinsertion.h"
#include "accel/registry.h"
#include "accel/scene/memory_need.h"

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace etendue {

// Holds what a layout asks of a builder beyond its own parameters.
struct TreeTask {
  int leaf_size = TreeLimits().leaf_size;
  const Geometry* geometry = nullptr;     // whose primitives the items are; null: boxes of instances
  const PackTest* packs = nullptr;        // as in TreeLimits
  bool full_leaves = false;               // runs of leaf_size are leaves whatever their tests cost
  MemoryWatch* watch = nullptr;           // for builders whose trees grow with the shape of the scene
  std::uint64_t bytes_per_reference = 0;  // what they report to it; 0: their own estimate
};

// A builder with its parameters, as read from the registry's map.
struct ConfiguredBuilder {
  std::function<BinaryTree(BuildItems, const TreeTask&)> build;
  BuilderSpace space;
  MemoryParams budget;
  std::string layout;
  int leaf_size = 0;  // 0: the layout's own
  int max_depth = 0;
  bool reinsertion = false;
  std::optional<float> primitive_cost;  // in visits of a node, for builders that weigh it
  bool sorts_to_packs = false;          // its trees over triangles are those of lbvh_packs.h
};

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
  v.choice("layout", params.layout, {"binary", "bvh4", "bvh8", "bvh16", "auto"},
           "nodes of two children; or of 4, 8 or 16, with SIMD packs of triangles as leaves; or what suits scene and machine");
  v.integer("reinsertion", params.reinsertion, 0, 100, "passes",
            "of optimisation, at most: subtrees put where they cost least");
}

// Holds for the parameters of a builder whose trees over triangles go straight to packs (lbvh.h).
template <class BuilderParams>
concept SortsToPacks = BuilderParams::sorts_to_packs;

// A row for what `read` configures; `params` are those it reads.
RayEntry bvh_entry(const char* name, const char* summary, std::vector<ParamInfo> params,
                   const std::function<ConfiguredBuilder(const ParamMap&)>& read);

// A row for a builder. `space(params)`: the builder's BuilderSpace.
template <class BuilderParams, class Space>
RayEntry bvh_entry(const char* name, const char* summary, const Space& space,
                   BinaryTree (*build)(BuildItems, const BuilderParams&, const Geometry*)) {
  using Params = WithMemory<BvhParams<BuilderParams>>;
  return bvh_entry(name, summary, list_params<Params>(), [=](const ParamMap& map) {
    const auto params = read_params<Params>(map, name);
    ConfiguredBuilder builder;
    builder.build = [params, build](BuildItems items, const TreeTask& task) {
      BuilderParams own = params;
      own.leaf_size = task.leaf_size;
      own.packs = task.packs;
      if constexpr (requires { own.primitive_cost; })
        if (task.full_leaves) own.primitive_cost = 0;
      if constexpr (requires { own.bytes_per_reference; }) {
        own.watch = task.watch;
        if (task.bytes_per_reference > 0) own.bytes_per_reference = task.bytes_per_reference;
      }
      BinaryTree tree = build(std::move(items), own, task.geometry);
      reinsert_subtrees(tree, params.reinsertion);
      return tree;
    };
    builder.space = space(params);
    builder.budget = params.budget;
    builder.layout = params.layout;
    builder.leaf_size = params.leaf_size;
    builder.max_depth = params.max_depth;
    builder.reinsertion = params.reinsertion > 0;
    if constexpr (requires { params.primitive_cost; }) builder.primitive_cost = params.primitive_cost;
    builder.sorts_to_packs = SortsToPacks<BuilderParams>;
    return builder;
  });
}

// A row for a builder that sees boxes only, with the space it takes per primitive.
template <class BuilderParams, BinaryTree (*build)(BuildItems, const BuilderParams&)>
RayEntry bvh_entry(const char* name, const char* summary, double bytes_per_primitive) {
  return bvh_entry<BuilderParams>(
      name, summary,
      [=](const BuilderParams& params) {
        constexpr int enough = 32;  // for any number of primitives: runs are halved in time (must_halve), to what a pack takes
        return BuilderSpace{bytes_per_primitive, 1, SortsToPacks<BuilderParams> && params.max_depth >= enough};
      },
      [](BuildItems items, const BuilderParams& params, const Geometry*) { return build(std::move(items), params); });
}

}  // namespace etendue
