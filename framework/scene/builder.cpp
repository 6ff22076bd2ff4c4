#include "framework/scene/builder.h"

#include "framework/core/check.h"

namespace etendue {

MeshData quad(const vec3& a, const vec3& b, const vec3& c, const vec3& d) {
  return {{a, b, c, d}, {{0, 1, 2}, {0, 2, 3}}, {}, {{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
}

MeshData box(const vec3& lower, const vec3& upper) {
  MeshData mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.emplace_back(i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z);
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

MeshData transformed(MeshData mesh, const Transform& transform) {
  for (vec3& p : mesh.positions) p = transform.point(p);
  for (vec3& n : mesh.normals) n = glm::normalize(transform.normal(n));
  if (transform.swaps_handedness())
    for (uvec3& t : mesh.triangles) std::swap(t.y, t.z);
  return mesh;
}

std::uint32_t SceneBuilder::material(Material material) {
  scene_.materials.push_back(std::move(material));
  return static_cast<std::uint32_t>(scene_.materials.size() - 1);
}

void SceneBuilder::mesh(const MeshData& mesh, std::uint32_t material, const std::optional<Rgb>& emitted) {
  CHECK(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size());
  CHECK(mesh.uvs.empty() || mesh.uvs.size() == mesh.positions.size());
  Object& world = scene_.objects[0];
  Geometry& g = world.geometry;
  const auto first_vertex = static_cast<std::uint32_t>(g.positions.size());
  const Shape shape{.first_primitive = static_cast<std::uint32_t>(g.triangles.size()),
                    .primitive_count = static_cast<std::uint32_t>(mesh.triangles.size()),
                    .material = material,
                    .has_normals = !mesh.normals.empty(),
                    .has_uvs = !mesh.uvs.empty()};
  g.positions.insert(g.positions.end(), mesh.positions.begin(), mesh.positions.end());
  for (const uvec3& t : mesh.triangles) g.triangles.push_back(t + first_vertex);
  // Attribute arrays come into being with the first mesh that has them.
  const auto append = [&](auto& all, const auto& some) {
    if (some.empty() && all.empty()) return;
    all.resize(first_vertex);
    all.insert(all.end(), some.begin(), some.end());
    all.resize(g.positions.size());
  };
  append(world.normals, mesh.normals);
  append(world.uvs, mesh.uvs);
  if (emitted) emissions_.push_back({static_cast<std::uint32_t>(world.shapes.size()), *emitted, false});
  world.shapes.push_back(shape);
}

void SceneBuilder::quadric(const Quadric& quadric, std::uint32_t material, const std::optional<Rgb>& emitted, bool inward) {
  quadrics_.push_back({quadric, material, emitted, inward});
}

void SceneBuilder::camera(const vec3& eye, const vec3& target, float fov_degrees, ivec2 resolution, const vec3& up) {
  // Seen along +z with y up, world x = up x forward runs to the left in a right-handed world: mirror it.
  const auto look_at = Transform::look_at(eye, target, up);
  CHECK(look_at.has_value());
  scene_.camera.to_world = *look_at * Transform::scale({-1, 1, 1});
  scene_.camera.fov = fov_degrees * pi / 180;
  scene_.resolution = resolution;
}

void SceneBuilder::closed_form(std::string source, std::function<dvec3(const Ray&)> radiance) {
  scene_.closed_form = ClosedForm{std::move(source), std::move(radiance)};
}

Scene SceneBuilder::finish() {
  Object& world = scene_.objects[0];
  for (const PendingQuadric& q : quadrics_) {
    const Shape shape{.first_primitive = world.geometry.primitive_count(),
                      .primitive_count = 1,
                      .material = q.material,
                      .flip_normal = q.inward};
    world.geometry.quadrics.push_back(q.quadric);
    if (q.emitted) emissions_.push_back({static_cast<std::uint32_t>(world.shapes.size()), *q.emitted, false});
    world.shapes.push_back(shape);
  }
  if (!world.normals.empty()) world.normals.resize(world.geometry.positions.size());
  if (!world.uvs.empty()) world.uvs.resize(world.geometry.positions.size());
  finish_scene(scene_, emissions_);
  return std::move(scene_);
}

}  // namespace etendue
