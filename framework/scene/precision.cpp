#include "framework/scene/precision.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

namespace etendue {

namespace {

constexpr float fewest_ulps = 4096;             // of an instance: a clearance of 4 is a thousandth of it
constexpr float fewest_ulps_of_primitive = 16;  // a clearance of 4 leaves half of it

// What lies in bounds spans `extent` metres; `ulp` is from one float to the next at its largest coordinate.
struct Coarseness {
  float extent = 0, distance = 0, ulp = 0;

  Coarseness(const Bounds& bounds, const vec3& origin) {
    extent = max_component(bounds.diagonal());
    distance = max_component(glm::max(glm::abs(bounds.lower + origin), glm::abs(bounds.upper + origin)));
    ulp = std::nextafter(distance, infinity) - distance;
  }
  float ulps() const { return extent / ulp; }
};

// The coarsest of many, and how many are too coarse.
struct Coarsest {
  float fewest;
  std::uint64_t count = 0, of = 0;
  std::optional<Coarseness> worst = {};

  void add(const Coarseness& c) {
    ++of;
    if (!(c.ulps() < fewest)) return;
    ++count;
    if (!worst || c.ulps() < worst->ulps()) worst = c;
  }
  std::string told() const {
    return fmt::format("{:.3g} m at {:.3g} m from the origin, where floats lie {:.2g} m apart", worst->extent, worst->distance,
                       worst->ulp);
  }
};

}  // namespace

std::vector<std::string> precision_warnings(const Scene& scene) {
  Coarsest objects{fewest_ulps}, primitives{fewest_ulps_of_primitive};
  std::vector<Bounds> of_object(scene.objects.size());
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const Geometry& g = scene.objects[o].geometry;
    for (std::uint32_t i = 0; i < g.primitive_count(); ++i) {
      if (!g.is_valid(i)) continue;
      const Bounds bounds = g.primitive_bounds(i);
      of_object[o].extend(bounds);
      primitives.add({bounds, o == 0 ? scene.origin : vec3(0)});
    }
  }
  for (const Instance& instance : scene.instances)
    if (const Bounds& bounds = of_object[instance.object]; !bounds.empty())
      objects.add({instance.to_world.bounds(bounds), scene.origin});
  std::vector<std::string> warnings;
  if (objects.worst)
    warnings.push_back(fmt::format(
        "{} {}: corners, contacts and shadows are as coarse; move it to the origin",
        objects.of == 1 ? "the scene spans"
                        : fmt::format("{} of {} objects are small for where they are, the smallest", objects.count, objects.of),
        objects.told()));
  if (primitives.worst)
    warnings.push_back(
        fmt::format("{} of {} primitives are small for where they are, the smallest {}: rays may start beyond them",
                    primitives.count, primitives.of, primitives.told()));
  return warnings;
}

}  // namespace etendue
