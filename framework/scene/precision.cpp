#include "framework/scene/precision.h"

#include "framework/scene/triangle_point.h"

#include <fmt/format.h>

#include <algorithm>
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

// How far rays start off the largest primitive, and what is so small beside it that they may start beyond that.
struct Largest {
  static constexpr float fewest_clearances = 16;
  float extent = 0;              // metres, of the primitive
  std::vector<float> smaller{};  // metres: shapes, instances and the scene's shortest side

  float clearance() const { return clearance_of(vec3(0), extent); }
  void keep_those_too_small() {
    std::erase_if(smaller, [&](float size) { return size > fewest_clearances * clearance(); });
  }
};

// Triangles of which the height is a few clearances at most.
struct Thin {
  static constexpr float fewest_clearances = 4;
  std::uint64_t count = 0;
  float height = 0, extent = 0;  // metres, of the thinnest

  void add(const TrianglePlane& t) {
    const float own_height = t.doubled / t.extent;
    if (own_height > fewest_clearances * clearance_of(vec3(0), t.extent)) return;
    if (count++ > 0 && own_height * extent >= height * t.extent) return;
    height = own_height;
    extent = t.extent;
  }
};

// A sphere or cylinder in an instance that makes it so flat is met where it is seen, but at no place to its thickness.
constexpr float flattest = 16 * 12 * unit_roundoff;

// How thin a transform makes what is as wide as high, over how wide.
float flatness(const Transform& to_world) {
  float widest = 0, steepest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    vec3 unit(0);
    unit[axis] = 1;
    widest = std::max(widest, glm::length(to_world.vector(unit)));
    steepest = std::max(steepest, glm::length(to_world.normal(unit)));
  }
  return 1 / (widest * steepest);
}

bool holds_round(const Geometry& geometry) {
  return std::ranges::any_of(geometry.quadrics, [](const Quadric& q) { return !std::holds_alternative<Disk>(q); });
}

constexpr float smallest_scene = 1e-12f;  // metres: products of six coordinates stay in the range of floats

float shortest_side(const Bounds& bounds) {
  float shortest = infinity;
  for (int axis = 0; axis < 3; ++axis)
    if (const float side = bounds.diagonal()[axis]; side > 0) shortest = std::min(shortest, side);
  return shortest;
}

// Gathers what the checks look at in a scene.
struct Survey {
  Coarsest objects{fewest_ulps}, primitives{fewest_ulps_of_primitive};
  Thin thin;
  Largest largest;
  float flatness_of_round = flattest;
  Bounds all;

  explicit Survey(const Scene& scene) {
    std::vector<Bounds> of_object(scene.objects.size());
    std::vector<float> largest_of(scene.objects.size());  // by object: its largest primitive's extent
    for (std::size_t o = 0; o < scene.objects.size(); ++o)
      for (const Shape& shape : scene.objects[o].shapes) {
        const Bounds of_shape = add_shape(scene.objects[o].geometry, shape, o == 0 ? scene.origin : vec3(0), largest_of[o]);
        if (of_shape.empty()) continue;
        of_object[o].extend(of_shape);
        if (o == 0) largest.smaller.push_back(max_component(of_shape.diagonal()));
      }
    for (const Instance& instance : scene.instances) {
      if (of_object[instance.object].empty()) continue;
      const Bounds bounds = instance.to_world.bounds(of_object[instance.object]);
      const vec3 half(0.5f * largest_of[instance.object]);
      largest.extent = std::max(largest.extent, max_component(instance.to_world.bounds({-half, half}).diagonal()));
      if (const float f = flatness(instance.to_world);
          f < flatness_of_round && holds_round(scene.objects[instance.object].geometry))
        flatness_of_round = f;
      all.extend(bounds);
      objects.add({bounds, scene.origin});
      largest.smaller.push_back(max_component(bounds.diagonal()));
    }
    if (!all.empty()) largest.smaller.push_back(shortest_side(all));
    largest.keep_those_too_small();
  }

 private:
  // The shape's box; `largest_primitive` grows to the extent of its largest.
  Bounds add_shape(const Geometry& g, const Shape& shape, const vec3& origin, float& largest_primitive) {
    Bounds box;
    for (std::uint32_t i = shape.first_primitive; i < shape.first_primitive + shape.primitive_count; ++i) {
      if (!g.is_valid(i)) continue;
      const Bounds bounds = g.primitive_bounds(i);
      box.extend(bounds);
      primitives.add({bounds, origin});
      largest_primitive = std::max(largest_primitive, max_component(bounds.diagonal()));
      if (!g.is_triangle(i)) continue;
      const uvec3 v = g.triangles[i];
      thin.add({g.positions[v.x], g.positions[v.y], g.positions[v.z]});
    }
    return box;
  }
};

}  // namespace

std::vector<std::string> precision_warnings(const Scene& scene) {
  const auto [objects, primitives, thin, largest, flatness_of_round, all] = Survey(scene);
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
  if (thin.count > 0)
    warnings.push_back(
        fmt::format("{} of {} primitives are too thin for their length, the thinnest {:.3g} m by {:.3g} m: rays "
                    "may start beyond them",
                    thin.count, primitives.of, thin.height, thin.extent));
  if (!largest.smaller.empty())
    warnings.push_back(
        fmt::format("rays start {:.2g} m off the largest primitive, which spans {:.3g} m; what touches it is as "
                    "coarse, and the scene has what measures {:.3g} m. Divide the primitive, or shrink it",
                    largest.clearance(), largest.extent, std::ranges::min(largest.smaller)));
  if (flatness_of_round < flattest)
    warnings.push_back(
        fmt::format("an instance makes a sphere or cylinder {:.2g} times as thick as wide, which is less than rays tell: its "
                    "light is wrong. Use a mesh, or a disk",
                    flatness_of_round));
  if (const float extent = all.empty() ? 0 : max_component(all.diagonal()); extent > 0 && extent < smallest_scene)
    warnings.push_back(
        fmt::format("the scene spans {:.3g} m: products of its coordinates leave the range of floats; scale it to "
                    "{:g} m or more",
                    extent, smallest_scene));
  return warnings;
}

}  // namespace etendue
