#include "framework/io/object_builder.h"

#include "framework/core/check.h"
#include "framework/core/memory.h"

#include <algorithm>

namespace etendue {

namespace {

// Appends the attributes of `count` vertices, or zeros; nothing as long as no mesh had any.
template <class T>
void append(std::vector<T>& all, const std::vector<T>& some, std::size_t before, std::size_t count) {
  if (some.empty() && all.empty()) return;
  all.resize(before, T(0));
  all.insert(all.end(), some.begin(), some.end());
  all.resize(before + count, T(0));
}

// A vector that is full takes twice its bytes, and keeps them until it is copied.
void require_room(std::size_t bytes, const char* what, const char* expectation) {
  constexpr std::size_t looked_at_from = std::size_t{1} << 26;  // to look takes longer than to copy less
  if (bytes >= looked_at_from) require_memory(2.0 * static_cast<double>(bytes), {}, what, expectation);
}

}  // namespace

void add_instance(Scene& scene, const Instance& instance) {
  auto& all = scene.instances;
  if (all.size() == all.capacity()) require_room(all.size() * sizeof(Instance), "the instances", "fewer of them");
  all.push_back(instance);
}

std::uint64_t ObjectBuilder::add(TriangleMesh mesh, const ShapeLook& look) {
  Geometry& g = object_.geometry;
  const std::size_t before = g.positions.size(), count = mesh.positions.size();
  CHECK_LT(before + count, std::size_t{no_id});
  const std::size_t triangles = g.triangles.size() + mesh.triangles.size();
  if (before > 0 && (before + count > g.positions.capacity() || triangles > g.triangles.capacity()))
    require_room(g.positions.size() * (2 * sizeof(vec3) + sizeof(vec2)) + g.triangles.size() * sizeof(uvec3), "the geometry",
                 "fewer or smaller shapes");
  Part part{{}, look.glow};
  part.shape = {.first_primitive = static_cast<std::uint32_t>(g.triangles.size()),
                .primitive_count = static_cast<std::uint32_t>(mesh.triangles.size()),
                .material = look.material,
                .flip_normal = look.flip_normal,
                .has_normals = !mesh.normals.empty(),
                .has_uvs = !mesh.uvs.empty(),
                .mask = look.mask};
  append(object_.normals, mesh.normals, before, count);
  append(object_.uvs, mesh.uvs, before, count);
  if (before == 0) {
    g.positions = std::move(mesh.positions);
    g.triangles = std::move(mesh.triangles);
  } else {
    g.positions.insert(g.positions.end(), mesh.positions.begin(), mesh.positions.end());
    if (triangles > g.triangles.capacity()) g.triangles.reserve(std::max(triangles, g.triangles.capacity() * 3 / 2));
    for (const uvec3& t : mesh.triangles) g.triangles.push_back(t + static_cast<std::uint32_t>(before));
  }
  meshes_.push_back(part);
  std::uint64_t invalid = 0;
  for (std::uint32_t i = 0; i < part.shape.primitive_count; ++i) invalid += !g.is_valid(part.shape.first_primitive + i);
  return invalid;
}

void ObjectBuilder::add(const Quadric& quadric, const ShapeLook& look) {
  Part part{{}, look.glow};
  part.shape = {.first_primitive = static_cast<std::uint32_t>(object_.geometry.quadrics.size()),
                .primitive_count = 1,
                .material = look.material,
                .flip_normal = look.flip_normal,
                .mask = look.mask};
  object_.geometry.quadrics.push_back(quadric);
  quadrics_.push_back(part);
}

Object ObjectBuilder::take(std::vector<Emission>* emissions) {
  const auto triangles = static_cast<std::uint32_t>(object_.geometry.triangles.size());
  for (Part& part : quadrics_) {
    part.shape.first_primitive += triangles;
    meshes_.push_back(part);
  }
  for (const Part& part : meshes_) {
    if (part.glow) {
      CHECK(emissions != nullptr);
      emissions->push_back(
          {static_cast<std::uint32_t>(object_.shapes.size()), part.glow->radiance, part.glow->two_sided, part.glow->texture});
    }
    object_.shapes.push_back(part.shape);
  }
  meshes_.clear();
  quadrics_.clear();
  return std::exchange(object_, {});
}

}  // namespace etendue
