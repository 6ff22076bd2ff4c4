// Every structure by name. To add one: write its .h/.cpp in its family's folder (bvh/build/, spatial/, points/, records/) and
// a line in registry.cpp.
#pragma once

#include "accel/bvh/build/binary_tree.h"
#include "accel/scene/memory_budget.h"
#include "framework/core/params.h"
#include "framework/query.h"
#include "framework/scene/scene.h"

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

using TreeBuilder = std::function<BinaryTree(BuildItems)>;

struct RayEntry {
  std::string name, summary;
  std::vector<ParamInfo> params = {};
  bool available = true;  // false where the library it adapts was not built in
  // Gives the builder's binary tree over one geometry, before any layout. It is empty for structures that are no trees of
  // boxes.
  std::function<BinaryTree(const Geometry&, const ParamMap&)> tree = {};
  // Likewise the builder alone, over any boxes, for trees that change over time. These lie in the binary layout: another one in
  // the map is an error.
  std::function<TreeBuilder(const ParamMap&)> builder = {};
  // Builds over all of a scene but its planes and masks, whatever its parameter `memory`: one level where it has no instances,
  // two where it has. The structure reports its growth to the watch, if there is one.
  std::function<std::unique_ptr<RayQuery>(const Scene&, const ParamMap&, MemoryWatch*)> build = {};
  // An upper estimate of the memory it takes (memory_need.h).
  std::function<MemoryNeed(const Scene&, const ParamMap&)> need = {};

  // Builds over a scene within the parameter `memory`, or a replacement that says so: first the structure itself in the leanest
  // layout, then trees in that layout by builders that take less memory, and at last brute force that reads the primitives in
  // place and keeps next to nothing (memory_budget.h).
  std::unique_ptr<RayQuery> make(const Scene& scene, const ParamMap& map) const;
};

struct PointEntry {
  std::string name, summary;
  std::function<std::unique_ptr<PointQuery>()> make;
};

struct RecordEntry {
  std::string name, summary;
  std::function<std::unique_ptr<RecordQuery>(const Bounds&)> make;
};

// Whether the structure, named by its label (its name, then perhaps parameters), is another library's. Those use their own
// triangle tests and may miss rays at edges: their disagreements are reported but do not count as failures.
bool is_adapter(std::string_view label);

std::span<const RayEntry> ray_structures();
std::span<const PointEntry> point_structures();
std::span<const RecordEntry> record_structures();

// Throw Error with the nearest names (or saying that the library is absent).
const RayEntry& find_ray_structure(const std::string& name, const Location& where);
const PointEntry& find_point_structure(const std::string& name, const Location& where);
const RecordEntry& find_record_structure(const std::string& name, const Location& where);

}  // namespace etendue
