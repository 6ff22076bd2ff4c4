// The registry's row of a structure that is no tree of boxes by a builder.
#pragma once

#include "accel/bvh/build/sah.h"
#include "accel/registry.h"
#include "accel/scene/memory_need.h"
#include "accel/scene/over_scene.h"

#include <utility>

namespace etendue {

// Trees over instances, for structures that have none of their own.
inline BinaryTree sah_over_instances(BuildItems items) { return build_sah(std::move(items), {}); }
inline BinaryTree leaf_of_instances(BuildItems items) { return single_leaf(items); }

// A structure of one geometry in few lines: `make_bottom(params)` answers a maker of it, `need(geometry, params)` what it
// takes; over instances it has a tree by `make_top`.
template <class Params, class MakeBottom, class Need, class MakeTop>
RayEntry plain_entry(const char* name, const char* summary, const MakeBottom& make_bottom, const Need& need,
                     const MakeTop& make_top) {
  RayEntry entry{.name = name, .summary = summary, .params = list_params<WithMemory<Params>>()};
  entry.build = [=](const Scene& scene, const ParamMap& map, MemoryWatch* watch) {
    return over_scene(scene, watch, make_bottom(read_watched<Params>(map, name, watch)), make_top);
  };
  entry.need = [=](const Scene& scene, const ParamMap& map) {
    const auto params = read_watched<Params>(map, name, nullptr);
    return scene_need(scene, [&](const Geometry& geometry) { return need(geometry, params); });
  };
  return entry;
}

// A structure over cells of space; its instances' tree is a hierarchy of boxes.
template <class Cells, class Params, class Need>
RayEntry cells_entry(const char* name, const char* summary, const Need& need) {
  return plain_entry<Params>(
      name, summary,
      [](const Params& params) { return [params](const Geometry& geometry) { return Cells(geometry, params); }; }, need,
      sah_over_instances);
}

}  // namespace etendue
