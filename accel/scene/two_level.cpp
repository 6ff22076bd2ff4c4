#include "accel/scene/two_level.h"

namespace etendue {

namespace {

// The world box of an object's box. Each coordinate passes through sums of up to four products on its way to the world, and the
// ray through as many on its way back: 16 epsilon of the largest sum covers both.
Bounds world_bounds(const Transform& to_world, const Bounds& local) {
  const vec3 extreme = glm::max(glm::abs(local.lower), glm::abs(local.upper));
  vec3 magnitude = glm::abs(to_world.point(vec3(0)));
  for (int axis = 0; axis < 3; ++axis) {
    vec3 unit(0);
    unit[axis] = 1;
    magnitude += glm::abs(to_world.vector(unit)) * extreme[axis];
  }
  const vec3 pad = magnitude * (16 * std::numeric_limits<float>::epsilon());
  const Bounds world = to_world.bounds(local);
  return {world.lower - pad + 0.0f, world.upper + pad + 0.0f};
}

}  // namespace

BuildItems instance_items(const Scene& scene) {
  std::vector<Bounds> of_object(scene.objects.size());
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const Geometry& geometry = scene.objects[i].geometry;
    for (std::uint32_t id = 0; id < geometry.primitive_count(); ++id) {
      if (!geometry.is_valid(id)) continue;
      const Bounds bounds = geometry.primitive_bounds(id);
      of_object[i].extend({bounds.lower + 0.0f, bounds.upper + 0.0f});  // as in build_items
    }
  }
  BuildItems items;
  for (std::uint32_t id = 0; id < scene.instances.size(); ++id) {
    const Instance& instance = scene.instances[id];
    const Bounds& local = of_object[instance.object];
    if (!local.empty()) items.push_back({instance.to_world.is_identity() ? local : world_bounds(instance.to_world, local), id});
  }
  return items;
}

}  // namespace etendue
