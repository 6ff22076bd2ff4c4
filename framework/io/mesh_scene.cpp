#include "framework/io/mesh_scene.h"

#include "framework/core/error.h"
#include "framework/io/object_builder.h"

#include <fmt/format.h>

namespace etendue {

namespace {

constexpr float fov = 40 * pi / 180;

Bounds used_bounds(const TriangleMesh& mesh) {
  Bounds bounds;
  for (const uvec3& t : mesh.triangles)
    for (int i = 0; i < 3; ++i) bounds.extend(mesh.positions[t[i]]);
  return bounds;
}

// Far enough for the sphere about the bounds to fit; a mesh without extent is seen from its own distance to the origin, or 1 m.
Camera framing_camera(const Bounds& bounds, const std::string& name) {
  const double diagonal = glm::length(dvec3(bounds.upper) - dvec3(bounds.lower));
  const vec3 target = bounds.centre();
  const double reach = diagonal + glm::length(dvec3(target));
  if (!(reach < 1e18)) throw Error(fmt::format("{}: the mesh reaches {:.3g} m, too far to frame", name, reach));
  float radius = static_cast<float>(0.5 * diagonal);
  if (!(radius > 1e-6f * glm::length(target))) radius = std::max(glm::length(target), 1e-6f);
  const float distance = 1.05f * radius / std::sin(0.5f * fov);
  const vec3 eye = target + distance * glm::normalize(vec3(0.6f, 0.45f, 1));
  Camera camera;
  // look_at is left-handed, meshes are right-handed: without the reflection the picture would be mirrored.
  camera.to_world = *Transform::look_at(eye, target, {0, 1, 0}) * Transform::scale({-1, 1, 1});
  camera.fov = fov;
  return camera;
}

}  // namespace

Scene mesh_scene(TriangleMesh mesh, const std::string& name) {
  Scene scene;
  scene.name = name;
  scene.resolution = {512, 512};
  scene.camera = framing_camera(used_bounds(mesh), name);
  scene.materials.emplace_back(Diffuse{Rgb(0.6f)});
  scene.lights.emplace_back(EnvironmentLight{.scale = Rgb(0.35f), .size = ivec2(0), .texels = {}, .light_to_world = {}});
  scene.lights.emplace_back(DirectionalLight{.direction = glm::normalize(vec3(0.5f, -1, -0.6f)), .irradiance = Rgb(2)});
  scene.warnings = mesh.warnings;
  ObjectBuilder builder;
  builder.add(std::move(mesh), {});
  scene.objects[0] = builder.take();
  finish_scene(scene, {});
  return scene;
}

}  // namespace etendue
