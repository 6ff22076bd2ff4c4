#include "experiments/kinds/second_level.h"

#include <algorithm>

namespace etendue {

namespace {

// Appends an object as an instance places it; both hold triangles alone.
void write_out(Object& world, const Object& object, const Transform& to_world) {
  const auto first_vertex = static_cast<std::uint32_t>(world.geometry.positions.size());
  const auto first_primitive = world.geometry.primitive_count(), first_shape = static_cast<std::uint32_t>(world.shapes.size());
  world.shape_of.resize(first_primitive, 0);
  for (const vec3& position : object.geometry.positions) world.geometry.positions.push_back(to_world.point(position));
  for (const uvec3& corners : object.geometry.triangles) world.geometry.triangles.push_back(corners + first_vertex);
  const std::size_t vertices = world.geometry.positions.size();
  if (!object.normals.empty()) world.normals.resize(first_vertex, vec3(0));
  for (const vec3& normal : object.normals) world.normals.push_back(to_world.normal(normal));
  if (!object.uvs.empty()) world.uvs.resize(first_vertex, vec2(0));
  world.uvs.insert(world.uvs.end(), object.uvs.begin(), object.uvs.end());
  if (!world.normals.empty()) world.normals.resize(vertices, vec3(0));
  if (!world.uvs.empty()) world.uvs.resize(vertices, vec2(0));
  for (std::uint32_t i = 0; i < object.shapes.size(); ++i) {
    Shape shape = object.shapes[i];
    shape.first_primitive += first_primitive;
    shape.flip_normal ^= to_world.swaps_handedness();  // the winding's normal turns over with it
    world.shapes.push_back(shape);
    world.shape_of.insert(world.shape_of.end(), shape.primitive_count, first_shape + i);
  }
}

}  // namespace

Scene with_second_level(const Scene& scene) {
  Scene changed = scene;
  const Bounds bounds = scene.bounds();
  const float diagonal = glm::length(bounds.diagonal()), size = 0.001f * diagonal;
  Object object;
  object.geometry.positions = {vec3(0), vec3(size, 0, 0), vec3(0, 0, size)};
  object.geometry.triangles = {{0, 1, 2}};
  object.shapes = {{.first_primitive = 0, .primitive_count = 1}};
  const vec3 centre = bounds.centre();
  const vec3 beneath(centre.x, bounds.lower.y - 0.01f * diagonal, centre.z);
  changed.instances.push_back({static_cast<std::uint32_t>(scene.objects.size()), Transform::translate(beneath)});
  changed.objects.push_back(std::move(object));
  return changed;
}

std::optional<Scene> without_second_level(const Scene& scene) {
  if (std::ranges::any_of(scene.objects, [](const Object& object) { return !object.geometry.quadrics.empty(); }))
    return std::nullopt;
  Scene changed = scene;
  changed.objects.resize(1);
  changed.instances.resize(1);
  for (std::size_t i = 1; i < scene.instances.size(); ++i)
    write_out(changed.objects[0], scene.objects[scene.instances[i].object], scene.instances[i].to_world);
  return changed;
}

}  // namespace etendue
