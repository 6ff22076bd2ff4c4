// The registry's row of a bounding volume hierarchy: any builder, in any layout, optimised or not.
#pragma once

#include "accel/bvh/build/reinsertion.h"
#include "accel/bvh/bvh_over_scene.h"
#include "accel/registry.h"

#include <functional>
#include <string>
#include <utility>
#include <vector>

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
