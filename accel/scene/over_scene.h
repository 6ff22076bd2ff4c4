// A structure of one geometry over a whole scene, with its parameters as the registry reads them.
#pragma once

#include "accel/scene/memory_budget.h"
#include "accel/scene/two_level.h"

#include <concepts>
#include <memory>
#include <vector>

namespace etendue {

template <RayStructure S>
std::unique_ptr<RayQuery> behind_interface(S structure) {
  return std::make_unique<RayAdapter<S>>(std::move(structure));
}

// Most structures ask for an object's geometry alone.
template <class MakeBottom>
auto make_over(const MakeBottom& make_bottom, const Object& object) {
  if constexpr (std::invocable<const MakeBottom&, const Object&>)
    return make_bottom(object);
  else
    return make_bottom(object.geometry);
}

// A structure over a whole scene, with a second level only where the scene has instances. `make_bottom(geometry)` builds over
// one object, `make_top(items)` the tree over instances.
template <class MakeBottom, class MakeTop>
std::unique_ptr<RayQuery> over_scene(const Scene& scene, MemoryWatch* watch, const MakeBottom& make_bottom,
                                     const MakeTop& make_top) {
  if (!scene.has_instances()) return behind_interface(make_over(make_bottom, scene.objects[0]));
  std::vector<decltype(make_over(make_bottom, scene.objects[0]))> bottoms;
  for (const Object& object : scene.objects) {
    bottoms.push_back(make_over(make_bottom, object));
    if (watch != nullptr) watch->keep(bottoms.back().stats().bytes);
  }
  return behind_interface(TwoLevel(std::move(bottoms), scene, make_top(instance_items(scene))));
}

// Parameters for a structure built under a watch, which may be null.
template <class Params>
Params read_watched(const ParamMap& map, const char* name, const MemoryWatch* watch) {
  Params params = read_params<WithMemory<Params>>(map, name);
  if constexpr (requires { params.watch; }) params.watch = watch;
  return params;
}

}  // namespace etendue
