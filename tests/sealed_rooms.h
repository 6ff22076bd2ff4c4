// Rooms without an opening, with a camera inside and all light outside: whatever is not black in their images has come through
// a wall. Also the lit half of a room beyond a wall without thickness, and what rays that bounce about inside ever leave.
//
// Rooms are about the origin and reach 2 m from it at least in parts, so that their size is 4 m; a Placement scales them and
// moves them far away, vertex by vertex, as floats can hold them there.
#pragma once

#include "framework/core/error.h"
#include "framework/core/rng.h"
#include "framework/io/object_builder.h"
#include "framework/scene/builder.h"
#include "framework/scenes/meshes.h"

#include <functional>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

namespace etendue::testing {

inline constexpr float room_size = 4, light_outside = 1e6f;  // metres; W/(m^2 sr)

struct Placement {
  float scale = 1;
  vec3 offset{0};  // metres
  vec3 operator()(const vec3& p) const { return vec3(dvec3(offset) + double(scale) * dvec3(p)); }
  MeshData operator()(MeshData mesh) const {
    for (vec3& p : mesh.positions) p = (*this)(p);
    return mesh;
  }
  Sphere operator()(const Sphere& s) const { return {(*this)(s.centre), scale * s.radius}; }
  Transform transform() const { return Transform::translate(offset) * Transform::scale(vec3(scale)); }
};

inline Placement far_away(float room_sizes) { return {1, room_size * room_sizes * vec3(1, -0.7f, 0.4f)}; }

struct Room {
  const char* name;
  bool flat;  // walls are planes that meet at right angles
  std::function<Scene(const Placement&)> make;
};

inline Rgb wall_albedo() { return {0.9f, 0.7f, 0.5f}; }

inline void see_from_inside(SceneBuilder& builder, const Placement& place) {
  builder.camera(place(vec3(0)), place({0.6f, 0.4f, 2}), 90, {12, 12});
}

inline void shine_outside(SceneBuilder& builder) {
  builder.light(EnvironmentLight{.scale = Rgb(light_outside), .size = ivec2(0), .texels = {}, .light_to_world = {}});
}

// Six rectangles that share no vertices, which are equal to the bit where they meet.
inline MeshData box_walls(float half) {
  MeshData all;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-half, half}) {
      const auto corner = [&](float u, float v) {
        vec3 p;
        p[axis] = side;
        p[(axis + 1) % 3] = u;
        p[(axis + 2) % 3] = v;
        return p;
      };
      const auto first = static_cast<std::uint32_t>(all.positions.size());
      for (const vec3& p : {corner(-half, -half), corner(half, -half), corner(half, half), corner(-half, half)})
        all.positions.push_back(p);
      all.triangles.push_back(uvec3(0, 1, 2) + first);
      all.triangles.push_back(uvec3(0, 2, 3) + first);
    }
  return all;
}

// 20 * 4^level triangles about the origin.
inline MeshData icosphere(int level, float radius, bool smooth) {
  const float t = 0.5f * (1 + std::sqrt(5.0f));
  MeshData mesh;
  for (const vec3& p : {vec3(-1, t, 0), vec3(1, t, 0), vec3(-1, -t, 0), vec3(1, -t, 0), vec3(0, -1, t), vec3(0, 1, t),
                        vec3(0, -1, -t), vec3(0, 1, -t), vec3(t, 0, -1), vec3(t, 0, 1), vec3(-t, 0, -1), vec3(-t, 0, 1)})
    mesh.positions.push_back(radius * glm::normalize(p));
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (; level > 0; --level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, fresh] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.positions.size()));
      if (fresh) mesh.positions.push_back(radius * glm::normalize(mesh.positions[a] + mesh.positions[b]));
      return at->second;
    };
    std::vector<uvec3> finer;
    for (const uvec3& f : mesh.triangles) {
      const std::uint32_t x = middle(f.x, f.y), y = middle(f.y, f.z), z = middle(f.z, f.x);
      for (const uvec3& g : {uvec3(f.x, x, z), uvec3(f.y, y, x), uvec3(f.z, z, y), uvec3(x, y, z)}) finer.push_back(g);
    }
    mesh.triangles = std::move(finer);
  }
  if (smooth)
    for (const vec3& p : mesh.positions) mesh.normals.push_back(-glm::normalize(p));
  return mesh;
}

// A sphere of 960 triangles of which every vertex lies at a random distance: folds of all angles, to both sides.
inline MeshData crumpled_ball(bool smooth) {
  constexpr std::uint32_t columns = 32, rows = 16;
  Pcg32 random(3, 1);
  MeshData mesh;
  const auto add = [&](const vec3& direction) { mesh.positions.push_back((1.2f + random.next_float()) * direction); };
  add({0, 1, 0});
  for (std::uint32_t row = 1; row < rows; ++row)
    for (std::uint32_t column = 0; column < columns; ++column) {
      const float theta = pi * static_cast<float>(row) / rows, phi = 2 * pi * static_cast<float>(column) / columns;
      add({std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)});
    }
  add({0, -1, 0});
  const auto south = static_cast<std::uint32_t>(mesh.positions.size() - 1);
  const auto vertex = [&](std::uint32_t row, std::uint32_t column) { return 1 + (row - 1) * columns + column % columns; };
  for (std::uint32_t c = 0; c < columns; ++c) {
    mesh.triangles.emplace_back(0, vertex(1, c), vertex(1, c + 1));
    for (std::uint32_t r = 1; r + 1 < rows; ++r) {
      mesh.triangles.emplace_back(vertex(r, c), vertex(r + 1, c), vertex(r + 1, c + 1));
      mesh.triangles.emplace_back(vertex(r, c), vertex(r + 1, c + 1), vertex(r, c + 1));
    }
    mesh.triangles.emplace_back(vertex(rows - 1, c), south, vertex(rows - 1, c + 1));
  }
  if (!smooth) return mesh;
  mesh.normals.assign(mesh.positions.size(), vec3(0));
  for (const uvec3& t : mesh.triangles) {
    const vec3& p = mesh.positions[t.x];
    const vec3 normal = glm::cross(mesh.positions[t.y] - p, mesh.positions[t.z] - p);
    for (const std::uint32_t v : {t.x, t.y, t.z}) mesh.normals[v] += normal;
  }
  for (vec3& n : mesh.normals) n = glm::normalize(n);
  return mesh;
}

// Glass and metals: a refracted ray starts on the far side of the surface that it was found from.
inline void furnish(SceneBuilder& builder, const Placement& place) {
  const auto glass = builder.material(Dielectric{.eta = 1.5f});
  builder.quadric(place(Sphere{{0.6f, 0.1f, 1}, 0.3f}), glass);
  MeshData ball = icosphere(1, 0.3f, true);
  for (vec3& p : ball.positions) p += vec3(-0.3f, 0.5f, 0.9f);
  for (vec3& n : ball.normals) n = -n;
  builder.mesh(place(ball), glass);
  builder.quadric(place(Sphere{{-0.1f, -0.2f, 1.1f}, 0.3f}),
                  builder.material(Conductor{.eta = Rgb(0.2f, 0.9f, 1.2f), .k = Rgb(3.5f, 2.5f, 2), .alpha = vec2(0.3f)}));
  builder.quadric(place(Sphere{{0.3f, 0.75f, 1.1f}, 0.2f}), builder.material(Dielectric{.eta = 1.5f, .alpha = 0.3f}));
}

inline Scene mesh_room(const char* name, const MeshData& walls, const Placement& place, bool furnished = false) {
  SceneBuilder builder(name);
  builder.mesh(place(walls), builder.material(Diffuse{wall_albedo()}));
  if (furnished) furnish(builder, place);
  shine_outside(builder);
  see_from_inside(builder, place);
  return builder.finish();
}

inline Scene quadric_room(const char* name, const Quadric& walls, const Placement& place, bool furnished = false) {
  SceneBuilder builder(name);
  builder.quadric(walls, builder.material(Diffuse{wall_albedo()}), std::nullopt, true);
  if (furnished) furnish(builder, place);
  shine_outside(builder);
  see_from_inside(builder, place);
  return builder.finish();
}

// Six instances of one rectangle: turned, stretched, every other one mirrored. Each reaches beyond its neighbours.
inline Scene instanced_room(const Placement& place) {
  SceneBuilder builder("instances");
  const auto wall = builder.material(Diffuse{wall_albedo()});
  furnish(builder, place);
  shine_outside(builder);
  see_from_inside(builder, place);
  Scene scene = builder.finish();
  ObjectBuilder object;
  object.add(TriangleMesh{.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}},
                          .normals = {},
                          .uvs = {},
                          .triangles = {{0, 1, 2}, {0, 2, 3}},
                          .warnings = {}},
             {.material = wall, .flip_normal = false, .glow = std::nullopt});
  scene.objects.push_back(object.take());
  const Transform turned = place.transform() * Transform::rotate(0.7f, glm::normalize(vec3(1, 2, 3)));
  for (int i = 0; i < 6; ++i) {
    const Transform to_side = i < 4 ? Transform::rotate(0.5f * pi * static_cast<float>(i), {0, 1, 0})
                                    : Transform::rotate(0.5f * pi * static_cast<float>(2 * i - 9), {1, 0, 0});
    const float mirrored = i % 2 == 0 ? -1.0f : 1.0f;
    const Transform to_world = turned * to_side * Transform::translate({0, 0, 2}) *
                               Transform::scale({2.3f * mirrored, 2.6f + 0.1f * static_cast<float>(i), 0.5f});
    scene.instances.push_back({1, to_world.moved(-scene.origin)});
  }
  return scene;
}

// A second box 1 mm around the first, or as near as floats can hold it, shines inwards: a ray that passes one wall is already
// in the light.
inline Scene double_walled_room(const Placement& place) {
  SceneBuilder builder("double walls");
  const auto wall = builder.material(Diffuse{wall_albedo()});
  builder.mesh(place(box_walls(2)), wall);
  const float far = max_component(glm::abs(place.offset)) / place.scale, ulp = far * std::numeric_limits<float>::epsilon();
  const vec3 half(2 + std::max(0.001f, 4 * ulp));
  MeshData outer = box(-half, half);
  for (uvec3& t : outer.triangles) std::swap(t.y, t.z);
  builder.mesh(place(outer), wall, Rgb(light_outside));
  see_from_inside(builder, place);
  return builder.finish();
}

// A lamp outside, `gap` room sizes from a wall, that shines to both sides.
inline Scene lamp_behind_wall(float gap, const Placement& place) {
  SceneBuilder builder("lamp behind a wall");
  const auto wall = builder.material(Diffuse{wall_albedo()});
  builder.mesh(place(box_walls(2)), wall);
  const float z = 2 + room_size * gap;
  builder.mesh(place(quad({-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z})), wall, Rgb(light_outside));
  see_from_inside(builder, place);
  Scene scene = builder.finish();
  for (Light& light : scene.lights) std::get<AreaLight>(light).two_sided = true;
  return scene;
}

// A wall without thickness at z = 0, with the light beyond it. The camera looks at the wall, or at its foot.
enum class Look : std::uint8_t { wall, foot };
inline Scene divided_room(Look look, const Placement& place, std::optional<float> gap = std::nullopt) {
  SceneBuilder builder(look == Look::wall ? "divided room" : "divided room, foot of its wall");
  const auto wall = builder.material(Diffuse{wall_albedo()});
  builder.mesh(place(box_walls(2)), wall);
  builder.mesh(place(quad({-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0})), wall);
  const float z = room_size * gap.value_or(0);
  builder.mesh(place(gap ? quad({-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z})
                         : quad({-0.5f, 1.5f, 0.5f}, {0.5f, 1.5f, 0.5f}, {0.5f, 1.5f, 1.5f}, {-0.5f, 1.5f, 1.5f})),
               wall, Rgb(light_outside));
  if (look == Look::wall)
    builder.camera(place({0.1f, 0, -1.9f}), place({0, 0, 1}), 90, {12, 12});
  else
    builder.camera(place({0.1f, 0, -0.3f}), place({0.1f, -2, -0.02f}), 8, {12, 12});
  Scene scene = builder.finish();
  for (Light& light : scene.lights) std::get<AreaLight>(light).two_sided = true;
  return scene;
}

// A room `length` times as long as it is high and `width` times as wide, turned so that no wall lies along an axis.
inline Scene corridor(const char* name, float length, float width, const Placement& place) {
  const glm::mat3 turn(0.36f, 0.48f, -0.8f, -0.8f, 0.6f, 0, 0.48f, 0.64f, 0.6f);
  MeshData walls = box_walls(2);
  for (vec3& p : walls.positions) p = turn * (p * vec3(length, 1, width));
  return mesh_room(name, walls, place);
}

// All rooms with the light on all sides.
inline std::vector<Room> sealed_rooms() {
  std::vector<Room> rooms = {
      {"box", true, [](const Placement& p) { return mesh_room("box", box_walls(2), p); }},
      {"furnished box", true, [](const Placement& p) { return mesh_room("furnished box", box_walls(2), p, true); }},
      {"double walls", true, double_walled_room},
      {"instances", true, instanced_room},
      {"sphere", false,
       [](const Placement& p) {
         return quadric_room("sphere", p(Sphere{vec3(0), 2}), p);
       }},
      {"furnished sphere", false,
       [](const Placement& p) {
         return quadric_room("furnished sphere", p(Sphere{vec3(0), 2}), p, true);
       }},
      {"cylinder", false,
       [](const Placement& p) {
         return quadric_room("cylinder", Cylinder{p({0, -2, 0}), 2 * p.scale, {0, 1, 0}, 4 * p.scale, true}, p);
       }},
      {"corridor", true, [](const Placement& p) { return corridor("corridor", 1000, 1, p); }},
      {"long corridor", true, [](const Placement& p) { return corridor("long corridor", 1e5f, 1, p); }},
      {"slab", true, [](const Placement& p) { return corridor("slab", 1000, 1000, p); }},
      {"rough ball", false, [](const Placement& p) { return mesh_room("rough ball", rough_ball(vec3(0), 2, 1000), p); }}};
  static constexpr const char* names[2][4] = {
      {"icosphere 20", "icosphere 80", "icosphere 320", "icosphere 1280"},
      {"smooth icosphere 20", "smooth icosphere 80", "smooth icosphere 320", "smooth icosphere 1280"}};
  for (const bool smooth : {false, true}) {
    for (const int level : {0, 2, 3}) {
      const char* name = names[smooth][level];
      rooms.push_back({name, false, [=](const Placement& p) { return mesh_room(name, icosphere(level, 2, smooth), p); }});
    }
    const char* name = smooth ? "smooth crumpled ball" : "crumpled ball";
    rooms.push_back({name, false, [=](const Placement& p) { return mesh_room(name, crumpled_ball(smooth), p); }});
  }
  return rooms;
}

inline Room find_room(std::string_view name) {
  for (const Room& room : sealed_rooms())
    if (room.name == name) return room;
  throw Error("no such room");
}

// Does every triangle have an area left where the room was moved to? Else it is no longer closed.
inline bool survives(const Scene& scene) {
  for (const Object& object : scene.objects)
    if (object.geometry.valid_primitives().size() != object.geometry.primitive_count()) return false;
  return true;
}

}  // namespace etendue::testing
