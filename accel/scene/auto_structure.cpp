#include "accel/scene/auto_structure.h"

#include <fmt/format.h>

#include <array>

namespace etendue {

namespace {

struct Candidate {
  const char* name;
  int reinsertion;          // passes; 0: none
  double build_ns, ray_ns;  // a primitive, a ray
};

constexpr std::array candidates{Candidate{"lbvh", 0, 65, 162}, Candidate{"binned-sah", 0, 215, 150},
                                Candidate{"sah", 9, 7000, 141}};
constexpr std::uint64_t few_primitives = 4096;
constexpr float default_rays = 1e8f;

struct AutoStructureParams {
  float rays = 0;
};

template <class Visitor>
void describe(Visitor& v, AutoStructureParams& p) {
  v.number("rays", p.rays, 0, 1e18, "rays", "how many are expected; 0: as many as a render's budget lets it trace, else 1e8");
}

using Params = WithMemory<AutoStructureParams>;

std::uint64_t primitives_of(const Scene& scene) {
  std::uint64_t count = 0;
  for (const Object& object : scene.objects) count += object.geometry.primitive_count();
  return count;
}

// The entry that stands for `auto` in a scene, and its parameters.
std::pair<const RayEntry*, ParamMap> chosen_for(const Scene& scene, const ParamMap& map) {
  const auto params = read_params<Params>(map, "auto");
  const MethodChoice choice = choose_structure(scene, params.rays > 0 ? params.rays : default_rays);
  return {&find_ray_structure(choice.name, {}), choice.params};
}

}  // namespace

MethodChoice choose_structure(const Scene& scene, double rays) {
  const auto primitives = static_cast<double>(primitives_of(scene));
  const Candidate* best = &candidates[1];
  const auto nanoseconds = [&](const Candidate& c) { return primitives * c.build_ns + rays * c.ray_ns; };
  if (primitives >= few_primitives)
    for (const Candidate& candidate : candidates)
      if (nanoseconds(candidate) < nanoseconds(*best)) best = &candidate;
  MethodChoice choice{best->name, {{"layout", {std::string("auto"), {}}}}, ""};
  if (best->reinsertion > 0) choice.params["reinsertion"] = {std::int64_t{best->reinsertion}, {}};
  const std::string numbers = fmt::format("{:.3g} rays among {:.0f} primitives", rays, primitives);
  if (primitives < few_primitives)
    choice.why = numbers + ": so few are built in no time that counts";
  else if (best == &candidates[0])
    choice.why = numbers + " do not earn back a better tree than the one soonest built";
  else if (best == &candidates[1])
    choice.why = numbers + " earn back the cuts by surface area, and no optimisation";
  else
    choice.why = numbers + " earn back an optimised tree";
  return choice;
}

RayEntry auto_structure_entry() {
  RayEntry entry{.name = "auto",
                 .summary = "the structure that takes the least time for scene and number of rays, its build included"};
  entry.params = list_params<Params>();
  entry.build = [](const Scene& scene, const ParamMap& map, MemoryWatch* watch) {
    const auto [chosen, params] = chosen_for(scene, map);
    return chosen->build(scene, params, watch);
  };
  entry.need = [](const Scene& scene, const ParamMap& map) {
    const auto [chosen, params] = chosen_for(scene, map);
    return chosen->need(scene, params);
  };
  return entry;
}

}  // namespace etendue
