// Shapes, shapegroups and instances. Shapes are placed in their group's space when they are read.

#include "framework/core/elementary.h"
#include "framework/io/mesh/ply.h"
#include "framework/io/mesh/serialized.h"
#include "framework/io/mesh/tessellate.h"
#include "framework/io/mitsuba/reader.h"
#include "framework/io/mitsuba/vertex_normals.h"
#include "framework/io/place_quadric.h"
#include "framework/scene/builder.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

namespace {

TriangleMesh as_mesh(MeshData data) {
  return {std::move(data.positions), {}, std::move(data.uvs), std::move(data.triangles), {}};
}

// Meshes in the place of quadrics get the texture coordinates of Mitsuba's shapes.
struct MeshOfQuadric {
  TriangleMesh operator()(const Sphere& s) const {
    TriangleMesh mesh = tessellate(revolved(
        2 * pi, arc_segments(pi), [&](float v) { return s.radius * vec2(1, -1) * from_pole(pi * v); },
        [](float v) { return vec2(math::cos(pi * v), math::sin(pi * v)); }));
    for (vec3& p : mesh.positions) p += s.centre;
    for (vec2& uv : mesh.uvs) uv.y = 1 - uv.y;
    return mesh;
  }
  TriangleMesh operator()(const Disk& d) const {
    TriangleMesh mesh = tessellate(revolved(
        2 * pi, 1, [&](float v) { return vec2(glm::mix(d.radius, d.inner_radius, v), 0); }, [](float) { return vec2(-1, 0); }));
    for (vec2& uv : mesh.uvs) uv = {1 - uv.y, uv.x};
    return mesh;
  }
  TriangleMesh operator()(const Cylinder& c) const {
    const Frame frame = Frame::from_normal(c.axis);
    TriangleMesh mesh = tessellate(revolved(
        2 * pi, 1, [&](float v) { return vec2(c.radius, c.length * v); }, [](float) { return vec2(0, 1); }));
    for (vec3& p : mesh.positions) p = c.base + frame.to_world(p);
    for (vec3& n : mesh.normals) n = frame.to_world(n);
    return mesh;
  }
};

// Does a cylinder stay one under a transform, with round ends across its axis?
bool stays_round(const Transform& t, const vec3& axis) {
  const Frame frame = Frame::from_normal(axis);
  const vec3 x = t.vector(frame.tangent), y = t.vector(frame.bitangent), z = t.vector(axis);
  const float a = glm::length(x), b = glm::length(y), c = glm::length(z);
  constexpr float rounding = 1e-4f;
  return std::abs(a - b) <= rounding * a && std::abs(glm::dot(x, y)) <= rounding * a * b &&
         std::abs(glm::dot(x, z)) <= rounding * a * c && std::abs(glm::dot(y, z)) <= rounding * b * c;
}

// Each face has the corners of a unit square as its texture coordinates.
MeshData cube_faces() {
  constexpr vec3 faces[6][4] = {
      {{1, -1, -1}, {1, -1, 1}, {-1, -1, 1}, {-1, -1, -1}}, {{1, 1, -1}, {-1, 1, -1}, {-1, 1, 1}, {1, 1, 1}},
      {{1, -1, -1}, {1, 1, -1}, {1, 1, 1}, {1, -1, 1}},     {{1, -1, 1}, {1, 1, 1}, {-1, 1, 1}, {-1, -1, 1}},
      {{-1, -1, 1}, {-1, 1, 1}, {-1, 1, -1}, {-1, -1, -1}}, {{1, 1, -1}, {1, -1, -1}, {-1, -1, -1}, {-1, 1, -1}}};
  MeshData cube;
  for (const auto& face : faces) {
    const MeshData side = quad(face[0], face[1], face[2], face[3]);
    for (const uvec3& t : side.triangles) cube.triangles.push_back(t + static_cast<std::uint32_t>(cube.positions.size()));
    cube.positions.insert(cube.positions.end(), side.positions.begin(), side.positions.end());
    cube.uvs.insert(cube.uvs.end(), {{0, 1}, {1, 1}, {1, 0}, {0, 0}});
  }
  return cube;
}

}  // namespace

std::span<const MitsubaReader::ShapeType> MitsubaReader::shape_types() {
  using R = MitsubaReader;
  static constexpr ShapeType table[] = {
      {"obj",
       "as it is, polygons as fans of their first corner, without its own materials; before version 2 a bsdf for each of them "
       "by its name, and one part by shape_index; max_smooth_angle approximated by smooth normals",
       &R::obj_mesh},
      {"ply", "as it is", &R::ply_mesh},
      {"serialized", "versions 3 and 4, by shape_index", &R::serialized_mesh},
      {"rectangle", "as it is", &R::rectangle},
      {"cube", "as it is", &R::cube},
      {"sphere", "as it is; under an uneven scale a sphere all the same, as in Mitsuba (warned)", &R::sphere},
      {"disk", "as it is; with a texture a mesh", &R::disk},
      {"cylinder", "as it is; under an uneven scale elliptic, which Mitsuba 2 and the first of 3 make round (warned)",
       &R::cylinder},
      {"shapegroup", "as it is", &R::shape_group},
      {"instance", "as it is", &R::instance},
      {"merge", "the shapes in it", &R::merge},
      {"bsplinecurve", "approximated: left out", &R::other_shape},
      {"deformable", "approximated: left out", &R::other_shape},
      {"ellipsoids", "approximated: left out", &R::other_shape},
      {"ellipsoidsmesh", "approximated: left out", &R::other_shape},
      {"hair", "approximated: left out", &R::other_shape},
      {"heightfield", "approximated: left out", &R::other_shape},
      {"linearcurve", "approximated: left out", &R::other_shape},
      {"sdfgrid", "approximated: left out", &R::other_shape},
  };
  return table;
}

void MitsubaReader::shape(const XmlElement& element, Group& group) {
  visit(element);
  const Properties of = properties(element);
  (this->*find_type(shape_types(), of).handler)(of, group);
  of.objects({"sensor"});
  of.finish();
}

// None where the shape is no surface and does not emit: it is left out. A light that is none stops no ray.
std::optional<ShapeLook> MitsubaReader::look(const Properties& of, const Group& group, MaterialEntry& entry, bool has_uvs) {
  leave_out_media(of);
  const auto glow = area_emitter(of, has_uvs);
  if (glow && !group.in_world)
    throw Error(of.where(), fmt::format("{}: shapes of a shapegroup cannot emit light; place it outside", of.title()));
  const bool flip = of.boolean("flip_normals", false);
  if (entry.invisible && !glow) return std::nullopt;
  if (!entry.two_sided && one_sided_++ == 0) first_one_sided_ = of.where();
  if (entry.invisible && mask_of_nothing_ == no_id)
    mask_of_nothing_ = add_texture(ImageTexture{.size = {1, 1}, .texels = {Rgb(0)}});
  const std::uint32_t mask = entry.invisible ? mask_of_nothing_ : entry.mask;
  if (has_uvs || !entry.relief) return ShapeLook{scene_material(entry), flip, glow, mask};
  approximate(of.where(), fmt::format("{}: only meshes with texture coordinates may have relief", of.title()),
              "a smooth surface");
  MaterialEntry smooth = entry;
  smooth.relief.reset();
  smooth.scene_index.reset();
  return ShapeLook{scene_material(smooth), flip, glow, mask};
}

void MitsubaReader::place(TriangleMesh mesh, const Properties& of, Group& group, const std::string& name, bool outward) {
  const Transform t = of.transform("to_world");
  of.ignore({"face_normals"});
  if (const auto seen = look(of, group, materials_[material_of(of)], !mesh.uvs.empty()))
    place(std::move(mesh), t, *seen, of, group, name, outward);
}

// `outward`: the mesh is a solid's or a plane's own, whose side a mirroring transform does not change.
void MitsubaReader::place(TriangleMesh mesh, const Transform& t, ShapeLook seen, const Properties& of, Group& group,
                          const std::string& name, bool outward) {
  for (vec3& p : mesh.positions) {
    p = t.point(p);
    if (!within_reach(p)) throw Error(of.where(), fmt::format("{}: placed, a vertex lies beyond {:g} m", of.title(), farthest));
  }
  if (of.boolean("face_normals", version0() && mesh.face_normals))  // later versions do not ask the file
    mesh.normals.clear();
  else if (mesh.normals.empty() && !outward)
    mesh.normals = smooth_normals(mesh);
  else
    for (vec3& n : mesh.normals) n = t.normal(n);
  if (seen.flip_normal)
    for (vec3& n : mesh.normals) n = -n;
  seen.flip_normal ^= outward && t.swaps_handedness();
  if (mesh.uvs.empty() && (uses_uvs(scene_.materials[seen.material]) || seen.mask != no_id)) {
    const auto* metal = std::get_if<Conductor>(&scene_.materials[seen.material]);
    if (metal && metal->is_anisotropic() && !version0())
      approximate(of.where(), fmt::format("{}: anisotropic metal without texture coordinates is not supported", of.title()),
                  "a brush along the first edge of each triangle");
    give_default_uvs(mesh);  // Mitsuba's are the weights of the second and the third corner
    for (const uvec3& corners : mesh.triangles) mesh.uvs[corners.z] = {0, 1};
  }
  mend_attributes(mesh, name);
  for (const std::string& warning : mesh.warnings) warn(of.where(), warning);
  const std::size_t triangles = mesh.triangles.size();
  left_out_.add(of.where().text() + ": " + name, triangles, group.parts[0].builder.add(std::move(mesh), seen));
}

// Adds what all meshes of files have, beside their own.
void MitsubaReader::finish_file_mesh(const Properties& of, bool flip_v, TriangleMesh& mesh) {
  if (of.boolean("flip_tex_coords", flip_v))
    for (vec2& uv : mesh.uvs) uv.y = 1 - uv.y;
  of.ignore({"srgb", "collapse"});
  if (of.has("max_smooth_angle"))
    approximate(of.where("max_smooth_angle"), fmt::format("{}: 'max_smooth_angle' is not supported", of.title()),
                "the file's own normals, or smooth ones");
}

void MitsubaReader::file_mesh(const Properties& of, Group& group, bool flip_v,
                              TriangleMesh (*parse)(const SceneFiles::File&, int), int index) {
  const SceneFiles::File file = read_file_of(of);
  TriangleMesh mesh;
  try {
    mesh = parse(file, index);
  } catch (const Error& e) {
    throw Error(of.where("filename"), e.what());
  }
  finish_file_mesh(of, flip_v, mesh);
  place(std::move(mesh), of, group, "'" + of.string("filename", "") + "'", false);
}

void MitsubaReader::ply_mesh(const Properties& of, Group& group) {
  file_mesh(
      of, group, false, [](const SceneFiles::File& file, int) { return parse_ply(file.bytes, file.path); }, 0);
}

void MitsubaReader::serialized_mesh(const Properties& of, Group& group) {
  file_mesh(
      of, group, false, [](const SceneFiles::File& file, int index) { return parse_serialized(file.bytes, file.path, index); },
      of.integer("shape_index", 0, 0, 1 << 24));
}

void MitsubaReader::rectangle(const Properties& of, Group& group) {
  place(as_mesh(quad({-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0})), of, group, of.title(), true);
}

void MitsubaReader::cube(const Properties& of, Group& group) { place(as_mesh(cube_faces()), of, group, of.title(), true); }

// Under any transform it stays a sphere.
void MitsubaReader::sphere(const Properties& of, Group& group) {
  const Transform to_world = of.transform("to_world");
  const float scale = glm::length(to_world.vector({1, 0, 0}));
  float radius = of.number("radius", 1, 1e-30f);
  vec3 centre = of.point("center", vec3(0));
  if (version0()) centre /= scale;  // there the scale is that of the radius alone
  Transform t = to_world * Transform::translate(centre);
  if (!t.similarity_scale()) {
    warn(of.where("to_world"), of.title() +
                                   ": 'to_world' distorts it: it stays a sphere, as wide as along its first axis, as in "
                                   "Mitsuba; a texture on it is not turned");
    radius *= scale;
    t = Transform::translate(t.point(vec3(0))) * Transform::scale({t.swaps_handedness() ? -1.0f : 1.0f, 1, 1});
  }
  place(Sphere{vec3(0), radius}, t, of, group);
}

void MitsubaReader::disk(const Properties& of, Group& group) {
  place(Disk{vec3(0), 1, {0, 0, 1}, 0}, of.transform("to_world"), of, group);
}

void MitsubaReader::cylinder(const Properties& of, Group& group) {
  const vec3 p0 = of.point("p0", vec3(0)), p1 = of.point("p1", {0, 0, 1});
  const float length = glm::length(p1 - p0);
  if (!(length > 0) || !std::isfinite(length)) of.fail("p1", "is 'p0': the cylinder has no height");
  const Transform t = of.transform("to_world");
  const vec3 axis = (p1 - p0) / length;
  if (!version0() && !stays_round(t, axis))
    warn(of.where("to_world"), of.title() +
                                   ": 'to_world' distorts it: elliptic or slanted, as in the newer releases of Mitsuba 3; in "
                                   "Mitsuba 2 and the first of 3 it stays round");
  place(Cylinder{p0, of.number("radius", 1, 1e-30f), axis, length, false}, t, of, group);
}

void MitsubaReader::place(const Quadric& quadric, const Transform& to_group, const Properties& of, Group& group) {
  MaterialEntry& entry = materials_[material_of(of)];
  auto appearance = look(of, group, entry, true);
  if (!appearance) return;
  // From version 2 on a mirroring transform turns spheres inside out.
  if (!version0() && std::holds_alternative<Sphere>(quadric)) appearance->flip_normal ^= to_group.swaps_handedness();
  const bool glows_by_image = appearance->glow && appearance->glow->texture != no_id;
  const auto place_mesh = [&] {
    place(std::visit(MeshOfQuadric(), quadric), to_group, *appearance, of, group, of.title(), true);
  };
  const bool polar = entry.textured && std::holds_alternative<Disk>(quadric);  // ours has u around and v inwards
  if (entry.relief || glows_by_image || polar) return place_mesh();
  std::optional<Quadric> placed;
  try {
    placed = placed_quadric(quadric, to_group, entry.textured);
  } catch (const Error& e) {
    throw Error(of.where(), fmt::format("{}: {}", of.title(), e.what()));
  }
  if (placed) {
    group.parts[0].builder.add(*placed, *appearance);
    return;
  }
  if (appearance->glow) return place_mesh();  // no instance can emit
  Part part{{}, to_group, {}};
  part.builder.add(quadric, *appearance);
  if (!group.in_world) {
    group.parts.push_back(std::move(part));
    return;
  }
  Group alone;
  alone.parts[0] = std::move(part);
  instantiate(alone, Transform());
}

// Only its instances are seen.
void MitsubaReader::shape_group(const Properties& of, Group& group) {
  if (!group.in_world) throw Error(of.where(), "a shapegroup inside another: groups do not nest");
  const auto [entry, is_new] = groups_.try_emplace(&of.element());
  const auto shapes = of.objects({"shape"});
  if (!is_new) return;
  for (const XmlElement* inner : shapes) shape(*inner, entry->second);
}

void MitsubaReader::instance(const Properties& of, Group& group) {
  if (!group.in_world) throw Error(of.where(), "an instance inside a shapegroup: instances do not nest");
  const auto found = of.objects({"shape"});
  if (found.size() != 1 || properties(*found[0]).type() != "shapegroup")
    throw Error(of.where(), fmt::format("{}: expected one reference to a shapegroup", of.title()));
  const Transform to_world = of.transform("to_world");
  shape(*found[0], group);  // it may stand behind its instances
  instantiate(groups_.at(found[0]), to_world);
}

void MitsubaReader::merge(const Properties& of, Group& group) {
  const Nesting nesting(*this, of.element());
  for (const XmlElement* inner : of.objects({"shape"})) shape(*inner, group);
}

void MitsubaReader::instantiate(Group& group, const Transform& to_world) {
  for (Part& part : group.parts) {
    if (!part.scene_index) {
      if (part.builder.empty()) continue;
      part.scene_index = static_cast<std::uint32_t>(scene_.objects.size());
      scene_.objects.push_back(part.builder.take());
    }
    add_instance(scene_, {*part.scene_index, to_world * part.to_group});
  }
}

void MitsubaReader::other_shape(const Properties& of, Group&) {
  of.ignore_all();
  approximate(of.where(), fmt::format("{} is not supported", of.title()), "nothing: it is missing");
}

}  // namespace etendue
