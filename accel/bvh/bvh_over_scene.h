// Any builder's trees, in any layout, over a whole scene. Layouts know a builder by one function alone, so that what traverses
// trees is compiled once (bvh_over_scene.cpp) and not again for each builder.
#pragma once

#include "accel/bvh/build/binary_tree.h"
#include "accel/scene/memory_budget.h"
#include "accel/scene/memory_need.h"
#include "framework/scene/scene.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace etendue {

// What a layout asks of a builder beyond its own parameters.
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

// `layout`: "binary", "bvh4", "bvh8" or "bvh16". The tree over instances has the same builder and the binary layout.
std::unique_ptr<RayQuery> bvh_over_scene(const Scene& scene, const std::string& layout, const ConfiguredBuilder& builder,
                                         const TreeTask& task);

}  // namespace etendue
