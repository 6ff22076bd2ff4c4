// Shapes, objects and instances. Shapes are placed in their object's space when they are read.

#include "framework/io/mesh/ply.h"
#include "framework/io/pbrt/reader.h"
#include "framework/io/text.h"

#include <fmt/format.h>

namespace etendue {

namespace {

// pbrt's quadrics in their own space; only whole ones.
void expect_whole(const PbrtParams& params, std::string_view name, float value, float whole) {
  if (std::abs(value - whole) > 1e-6f * std::abs(whole))
    params.fail(name, fmt::format("is {}: only full shapes are supported, which have {:.6g}", value, whole));
}

float read_radius(const PbrtParams& params) {
  const float radius = params.number("radius", 1, 1e-30f);
  expect_whole(params, "phimax", params.number("phimax", 360), 360);
  return radius;
}

Quadric read_sphere(const PbrtParams& params) {
  const float radius = read_radius(params);
  expect_whole(params, "zmin", params.number("zmin", -radius), -radius);
  expect_whole(params, "zmax", params.number("zmax", radius), radius);
  return Sphere{vec3(0), radius};
}

Quadric read_cylinder(const PbrtParams& params) {
  const float radius = read_radius(params);
  const float a = params.number("zmin", -1), b = params.number("zmax", 1);
  if (a == b) params.fail("zmax", "equals zmin: the cylinder has no height");
  return Cylinder{{0, 0, std::min(a, b)}, radius, {0, 0, 1}, std::abs(b - a), false};
}

Quadric read_disk(const PbrtParams& params) {
  const float radius = read_radius(params), inner = params.number("innerradius", 0, 0);
  if (!(inner < radius)) params.fail("innerradius", fmt::format("is {}; expected less than the radius, {}", inner, radius));
  return Disk{{0, 0, params.number("height", 0)}, radius, {0, 0, 1}, inner};
}

// Under a similarity of the given scale.
struct TransformQuadric {
  const Transform& t;
  float scale;

  Quadric operator()(const Sphere& s) const { return Sphere{t.point(s.centre), scale * s.radius}; }
  Quadric operator()(const Cylinder& c) const {
    return Cylinder{t.point(c.base), scale * c.radius, glm::normalize(t.vector(c.axis)), scale * c.length, c.caps};
  }
  Quadric operator()(const Disk& d) const {
    return Disk{t.point(d.centre), scale * d.radius, glm::normalize(t.normal(d.normal)), scale * d.inner_radius};
  }
};

// Does a quadric keep its texture coordinates, which count from the axes of the space it is in?
bool keeps_axes(const Transform& t, float scale) {
  const auto near = [&](const vec3& v, const vec3& axis) { return glm::length(v / scale - axis) < 1e-4f; };
  return near(t.vector({1, 0, 0}), {1, 0, 0}) && near(t.vector({0, 0, 1}), {0, 0, 1}) && !t.swaps_handedness();
}

}  // namespace

void PbrtReader::shape(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "Shape");
  const PbrtParams params(lexer, titled(token.text, type), lexer.where(token));
  params.reject("alpha", "surfaces are opaque");
  params.reject("shadowalpha", "surfaces are opaque");
  if (type == "trianglemesh")
    triangle_mesh(lexer, params);
  else if (type == "plymesh")
    ply_mesh(lexer, params);
  else if (type == "sphere")
    place(read_sphere(params), params);
  else if (type == "cylinder")
    place(read_cylinder(params), params);
  else if (type == "disk")
    place(read_disk(params), params);
  else
    throw Error(where,
                unknown_name("shape", type, std::vector<std::string>{"trianglemesh", "plymesh", "sphere", "cylinder", "disk"}));
  params.finish();
}

void PbrtReader::triangle_mesh(PbrtLexer&, const PbrtParams& params) {
  TriangleMesh mesh;
  mesh.positions = params.points3("P");
  mesh.normals = params.points3("N");
  const std::size_t vertices = mesh.positions.size();
  if (vertices == 0) params.fail("P", "is missing or empty; expected points");
  for (const char* name : {"uv", "st"})
    if (auto uvs = params.points2(name); !uvs.empty()) {
      if (uvs.size() != vertices) params.fail(name, fmt::format("has {} pairs, but there are {} points", uvs.size(), vertices));
      mesh.uvs = std::move(uvs);
    }
  if (!mesh.normals.empty() && mesh.normals.size() != vertices)
    params.fail("N", fmt::format("has {} normals, but there are {} points", mesh.normals.size(), vertices));
  if (params.has("S")) warn(params.where("S"), "tangents are not read; they follow the texture coordinates");
  params.ignore({"S"});

  std::vector<int> indices = params.integers("indices");
  if (indices.empty() && vertices == 3) indices = {0, 1, 2};
  if (indices.empty()) params.fail("indices", "is missing or empty; expected three per triangle");
  if (indices.size() % 3 != 0)
    params.fail("indices", fmt::format("has {} values; expected three per triangle", indices.size()));
  for (std::size_t i = 0; i < indices.size(); ++i)
    if (indices[i] < 0 || static_cast<std::size_t>(indices[i]) >= vertices)
      params.fail("indices", fmt::format("has {} as its value {}, but there are {} points", indices[i], i, vertices));
  mesh.triangles.reserve(indices.size() / 3);
  for (std::size_t i = 0; i < indices.size(); i += 3) mesh.triangles.emplace_back(indices[i], indices[i + 1], indices[i + 2]);
  place(std::move(mesh), params, params.owner());
}

void PbrtReader::ply_mesh(PbrtLexer& lexer, const PbrtParams& params) {
  const std::string file = params.string("filename", "");
  if (file.empty()) params.fail("filename", "is missing");
  params.reject("displacement", "surfaces are not displaced");
  const SceneFiles::File read = files_.read(file, *lexer.file(), params.where("filename"));
  try {
    place(parse_ply(read.bytes, read.path), params, "'" + file + "'");
  } catch (const Error& e) {
    throw Error(params.where("filename"), e.what());
  }
}

ShapeLook PbrtReader::look(const PbrtParams& params, bool flip_normal) {
  if (attributes_.glow && open_definition_)
    throw Error(params.where(),
                fmt::format("{}: shapes of an object cannot emit light; place it outside ObjectBegin", params.owner()));
  return {scene_material(attributes_.material), flip_normal, attributes_.glow};
}

void PbrtReader::place(TriangleMesh mesh, const PbrtParams& params, const std::string& name) {
  const Transform& t = attributes_.ctm;
  const bool reverse = attributes_.reverse_orientation;
  for (vec3& p : mesh.positions) {
    p = t.point(p);
    if (!within_reach(p))
      throw Error(params.where(), fmt::format("{}: placed, a vertex lies beyond {:g} m", params.owner(), farthest));
  }
  for (vec3& n : mesh.normals) n = reverse ? -t.normal(n) : t.normal(n);
  mend_attributes(mesh, name);
  for (const std::string& warning : mesh.warnings) warn(params.where(), warning);
  const std::size_t triangles = mesh.triangles.size();
  Definition& definition = open_definition_ ? *open_definition_ : world_;
  const std::uint64_t invalid = definition.parts[0].builder.add(std::move(mesh), look(params, reverse != t.swaps_handedness()));
  left_out_.add(params.where().text() + ": " + name, triangles, invalid);
}

void PbrtReader::place(const Quadric& quadric, const PbrtParams& params) {
  const ShapeLook appearance = look(params, attributes_.reverse_orientation);
  const bool textured = materials_[attributes_.material].textured;
  Transform t = attributes_.ctm;
  // pbrt's v runs up a sphere, ours down; mirrored, it is the same sphere.
  if (textured && std::holds_alternative<Sphere>(quadric)) t = t * Transform::scale({1, 1, -1});
  Definition& definition = open_definition_ ? *open_definition_ : world_;
  const auto scale = t.similarity_scale();
  if (scale && (!textured || appearance.glow || keeps_axes(t, *scale))) {
    const Quadric placed = std::visit(TransformQuadric{t, *scale}, quadric);
    const Bounds bounds = quadric_bounds(placed);
    if (!within_reach(bounds.lower) || !within_reach(bounds.upper) || !(quadric_area(placed) > 0) ||
        !std::isfinite(quadric_area(placed)))
      throw Error(params.where(), fmt::format("{}: placed, it lies beyond {:g} m, or is too small for single precision",
                                              params.owner(), farthest));
    definition.parts[0].builder.add(placed, appearance);
    return;
  }
  if (appearance.glow)
    throw Error(params.where(), fmt::format("{}: a shape under a transform that distorts it cannot emit light; scale it evenly",
                                            params.owner()));
  PlacedObject part{{}, t, std::nullopt};
  part.builder.add(quadric, appearance);
  if (open_definition_) {
    definition.parts.push_back(std::move(part));
  } else {
    Definition alone;
    alone.parts[0] = std::move(part);
    instantiate(alone, Transform());
  }
}

void PbrtReader::object_begin(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string name = expect_string(lexer, "ObjectBegin");
  if (open_definition_) throw Error(where, "ObjectBegin inside another object");
  const auto [entry, is_new] = definitions_.try_emplace(name);
  if (!is_new) throw Error(where, fmt::format("object '{}' is defined twice", name));
  push(Block::object, lexer.where(token));
  open_definition_ = &entry->second;
}

void PbrtReader::object_end(PbrtLexer& lexer, const Token& token) {
  attributes_ = pop(Block::object, token.text, lexer.where(token));
  open_definition_ = nullptr;
}

void PbrtReader::object_instance(PbrtLexer& lexer, const Token&) {
  const Location where = lexer.where(lexer.peek());
  const std::string name = expect_string(lexer, "ObjectInstance");
  if (open_definition_) throw Error(where, "ObjectInstance inside an object: instances do not nest");
  const auto found = definitions_.find(name);
  if (found == definitions_.end()) {
    std::vector<std::string> names;
    for (const auto& [known, definition] : definitions_) names.push_back(known);
    throw Error(where, unknown_name("object", name, names));
  }
  instantiate(found->second, attributes_.ctm);
}

// Objects enter the scene with their first instance.
void PbrtReader::instantiate(Definition& definition, const Transform& to_world) {
  for (PlacedObject& part : definition.parts) {
    if (!part.scene_index) {
      if (part.builder.empty()) continue;
      part.scene_index = static_cast<std::uint32_t>(scene_.objects.size());
      scene_.objects.push_back(part.builder.take());
    }
    scene_.instances.push_back({*part.scene_index, to_world * part.to_parent});
  }
}

}  // namespace etendue
