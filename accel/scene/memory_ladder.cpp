// Which structures stand in for one that exceeds its memory budget.
#include "accel/registry.h"
#include "accel/scene/with_masks.h"
#include "accel/scene/with_planes.h"

#include <algorithm>

namespace etendue {

namespace {

// The structure itself, then its replacements, each leaner than the one before.
std::vector<MemoryRung> memory_rungs(const RayEntry& asked, const Scene& scene, const ParamMap& map, bool leaner) {
  const ParamValue bvh16{std::string("bvh16"), {}}, yes{true, {}};
  std::vector<MemoryRung> rungs;
  const auto add = [&](const std::string& name, ParamMap params) {
    params.erase("memory");
    params.erase("over_memory");
    std::string label = name;
    for (const auto& [key, value] : params) label += " " + key + "=" + to_text(value);
    const auto same = [&](const MemoryRung& rung) { return rung.name == label; };
    if (std::any_of(rungs.begin(), rungs.end(), same)) return;
    const RayEntry& entry = find_ray_structure(name, {});
    const auto build = [&entry, &scene, params](MemoryWatch* watch) { return entry.build(scene, params, watch); };
    rungs.push_back({label, entry.need(scene, params), build});
  };
  add(asked.name, map);
  if (leaner && asked.tree) {
    ParamMap own = map;
    own.insert_or_assign("layout", bvh16);
    add(asked.name, own);
  }
  if (leaner && asked.name != "brute")
    for (const char* name : {"binned-sah", "median"}) add(name, {{"layout", bvh16}});
  add("brute", {{"in_place", yes}});
  return rungs;
}

}  // namespace

std::unique_ptr<RayQuery> RayEntry::make(const Scene& scene, const ParamMap& map) const {
  MemoryParams budget;
  ParamReader reader(map, name);
  describe(reader, budget);
  const auto has_primitives = [](const Object& object) { return object.geometry.primitive_count() > 0; };
  std::unique_ptr<RayQuery> built;
  if (budget.memory == 0 || std::none_of(scene.objects.begin(), scene.objects.end(), has_primitives)) {
    built = build(scene, map, nullptr);
  } else {
    const bool leaner = budget.over_memory == "leaner";
    built = build_within(budget, map.at("memory").where, scene.name, memory_rungs(*this, scene, map, leaner));
  }
  return with_masks(with_planes(std::move(built), scene), scene);
}

}  // namespace etendue
