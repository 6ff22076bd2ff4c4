#include "accel/bvh/bvh_entry.h"

#include "accel/bvh/wide/wide_bvh.h"
#include "framework/core/error.h"

#include <algorithm>

namespace etendue {

namespace {

// The layout that traces fastest: the widest that the chosen instruction set supports, but sixteen children only for meshes,
// and for triangles so few that they mostly fit in a few packs, which are tested whole. (For numbers between, any layout needs
// two or three visits, which cost less with narrower nodes.)
std::string resolved_layout(const std::string& layout, const Scene& scene) {
  if (layout != "auto") return layout;
  constexpr std::uint32_t few = 48, mesh = 4096;
  std::uint32_t largest = 0;
  for (const Object& object : scene.objects) largest = std::max(largest, object.geometry.primitive_count());
  const Isa isa = chosen_isa();
  return isa == Isa::avx512 && (largest <= few || largest >= mesh) ? "bvh16" : isa >= Isa::avx2 ? "bvh8" : "binary";
}

MemoryNeed need_of(const ConfiguredBuilder& builder, const Scene& scene) {
  const std::string layout = resolved_layout(builder.layout, scene);
  return scene_need(scene, [&](const Geometry& geometry) {
    return bvh_need(geometry, layout, builder.leaf_size, builder.reinsertion, builder.space);
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

}  // namespace

RayEntry bvh_entry(const char* name, const char* summary, std::vector<ParamInfo> params,
                   const std::function<ConfiguredBuilder(const ParamMap&)>& read) {
  RayEntry entry{.name = name, .summary = summary, .params = std::move(params)};
  entry.need = [read](const Scene& scene, const ParamMap& map) { return need_of(read(map), scene); };
  entry.build = [read](const Scene& scene, const ParamMap& map, MemoryWatch* watch) {
    const ConfiguredBuilder builder = read(map);
    return bvh_over_scene(scene, resolved_layout(builder.layout, scene), builder, watched_task(builder, scene, watch));
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
