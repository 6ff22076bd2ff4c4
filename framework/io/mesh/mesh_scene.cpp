#include "framework/io/mesh/mesh_scene.h"

#include "framework/core/elementary.h"
#include "framework/core/error.h"
#include "framework/io/mesh/left_out.h"
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

// The eye's distance from the target at which all corners of the bounds lie in the image, with a margin of a tenth.
float framing_distance(const Bounds& bounds, const vec3& target, const Transform& to_camera) {
  float distance = 0;
  for (int i = 0; i < 8; ++i) {
    const vec3 corner(i & 1 ? bounds.upper.x : bounds.lower.x, i & 2 ? bounds.upper.y : bounds.lower.y,
                      i & 4 ? bounds.upper.z : bounds.lower.z);
    const vec3 c = to_camera.vector(corner - target);
    distance = std::max(distance, 1.1f * std::max(std::abs(c.x), std::abs(c.y)) / math::tan(0.5f * fov) - c.z);
  }
  return distance;
}

// A mesh without extent is seen from its own distance to the origin, or 1 m.
Camera framing_camera(const Bounds& bounds, const std::string& name) {
  const vec3 target = bounds.centre();
  const double extent = glm::length(dvec3(bounds.upper) - dvec3(bounds.lower)), offset = glm::length(dvec3(target));
  if (!(extent + offset <= farthest))
    throw Error(fmt::format("{}: the mesh reaches {:.3g} m; expected {:g} m at most", name, extent + offset, farthest));
  const vec3 towards_eye = glm::normalize(vec3(0.6f, 0.45f, 1)), up(0, 1, 0);
  float distance = framing_distance(bounds, target, Transform::look_at(towards_eye, vec3(0), up)->inverse());
  if (!(distance > 1e-5 * offset)) distance = offset > 0 ? static_cast<float>(offset) : 1;
  Camera camera;
  // look_at is left-handed, meshes are right-handed: without the reflection the picture would be mirrored.
  camera.to_world = *Transform::look_at(target + distance * towards_eye, target, up) * Transform::scale({-1, 1, 1});
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
  if (mesh.names_materials) scene.warnings.push_back(name + ": the materials it names are not read: all of it is grey");
  ObjectBuilder builder;
  const std::size_t triangles = mesh.triangles.size();
  LeftOutTriangles left_out;
  left_out.add(name, triangles, builder.add(std::move(mesh), {}));
  for (std::string& warning : left_out.warnings()) scene.warnings.push_back(std::move(warning));
  scene.objects[0] = builder.take();
  finish_scene(scene, {});
  return scene;
}

}  // namespace etendue
