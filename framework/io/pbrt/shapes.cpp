// Shapes, objects and instances. Shapes are placed in their object's space when they are read.

#include "framework/io/gzip.h"
#include "framework/io/mesh/obj.h"
#include "framework/io/mesh/ply.h"
#include "framework/io/mesh/smf.h"
#include "framework/io/pbrt/quadrics.h"
#include "framework/io/pbrt/reader.h"
#include "framework/io/place_quadric.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace etendue {

namespace {

// Quadrilaterals of which a corner is off the others' plane by more than a hundredth of the diagonal.
std::ptrdiff_t count_bent(const TriangleMesh& mesh) {
  return std::count_if(mesh.quads.begin(), mesh.quads.end(), [&](std::uint32_t q) {
    const uvec3 t = mesh.triangles[q];
    const vec3 a = mesh.positions[t.x], d = mesh.positions[mesh.triangles[q + 1].z];
    const vec3 normal = glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
    return std::abs(glm::dot(normal, d - a)) > 0.01f * glm::length(normal) * glm::length(d - mesh.positions[t.y]);
  });
}

// Quadrilaterals that show their texture or their normals otherwise over two triangles than over a bilinear patch: where a
// parallelogram's fourth corner lacks a tenth of the diagonal, in place, texture coordinates or normal.
std::ptrdiff_t count_stretched(const TriangleMesh& mesh, bool shows_texture) {
  return std::count_if(mesh.quads.begin(), mesh.quads.end(), [&](std::uint32_t q) {
    const uvec3 t = mesh.triangles[q];
    const std::uint32_t last = mesh.triangles[q + 1].z;
    const auto lack = [&](const auto& values) { return glm::length(values[t.x] + values[t.z] - values[t.y] - values[last]); };
    const auto is_off = [&](const auto& values) { return lack(values) > 0.1f * glm::length(values[t.z] - values[t.x]); };
    const bool off = is_off(mesh.positions);
    if (shows_texture && (off || (!mesh.uvs.empty() && is_off(mesh.uvs)))) return true;
    if (mesh.normals.empty()) return false;
    float turn = 0;
    for (const std::uint32_t corner : {t.y, t.z, last})
      turn = std::max(turn, glm::length(mesh.normals[corner] - mesh.normals[t.x]));
    return lack(mesh.normals) > 0.1f || (off && turn > 0.1f);
  });
}

// Does what 'discarddegenerateUVs' asks for: it drops texture coordinates where two corners of a triangle of some size have the
// same ones.
void discard_degenerate_uvs(TriangleMesh& mesh) {
  if (mesh.uvs.empty() || mesh.normals.empty()) return;
  const auto is_degenerate = [&](const uvec3& t) {
    const vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
    if (0.5f * glm::length(glm::cross(a - b, c - b)) < 1e-7f) return false;
    const vec2 u = mesh.uvs[t.x], v = mesh.uvs[t.y], w = mesh.uvs[t.z];
    return u == v || v == w || w == u;
  };
  if (std::none_of(mesh.triangles.begin(), mesh.triangles.end(), is_degenerate)) return;
  mesh.uvs.clear();
  mesh.warnings.emplace_back("its texture coordinates are degenerate and left out, as in pbrt-v3");
}

}  // namespace

void PbrtReader::shape(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "Shape");
  require_known("Shape", "shape", type, where);
  PbrtParams params(lexer, titled(token.text, type), lexer.where(token), version3_);
  params.add_defaults(attributes_.defaults["shape"]);
  if (version3_ && type != "trianglemesh" && type != "plymesh")
    for (const char* name : {"alpha", "shadowalpha"}) params.drop(name, "which knows it of trianglemesh and plymesh alone");
  if (type == "trianglemesh")
    place(triangle_mesh(params), params, params.owner());
  else if (type == "plymesh" || type == "objmesh")
    mesh_file(lexer, params);
  else if (type == "loopsubdiv")
    subdivided_mesh(params);
  else if (type == "curve")
    curve(params);
  else if (type == "bilinearmesh")
    bilinear_mesh(params);
  else if (type == "heightfield")
    height_field(params);
  else if (type == "nurbs")
    nurbs(params);
  else
    quadric(*read_quadric(type, params), params);
  params.ignore({"alpha", "shadowalpha"});
  take_no_material_from(params);
  params.finish();
}

// In pbrt-v3 a shape may give parameters of its material, which come before the material's own.
void PbrtReader::take_no_material_from(const PbrtParams& params) {
  if (!version3_) return;
  for (const PbrtParam& param : params.all()) {
    if (param.used || !is_of_material_in_version3(param.name)) continue;
    approximate(params.where(param.name),
                fmt::format("{}: '{}' changes the material for this shape alone in pbrt-v3, which is not supported: give the "
                            "shape a Material of its own",
                            params.owner(), param.name),
                "the material as it is without that");
    params.ignore({param.name});
  }
}

void PbrtReader::quadric(const PbrtQuadric& quadric, const PbrtParams& params) {
  if (attributes_.glow && !attributes_.glow->two_sided && ctm().swaps_handedness())
    warn(params.where(), params.owner() +
                             ": under a mirroring transform pbrt shows the other side of a light than it takes "
                             "light from; here both are the latter");
  const auto* const glass = std::get_if<Dielectric>(&materials_[attributes_.material].material);
  if (glass && !glass->thin && ctm().swaps_handedness())
    warn(params.where(), params.owner() +
                             ": under a mirroring transform pbrt takes what lies outside for the inside of glass; here it is "
                             "as without the mirroring");
  if (quadric.whole)
    place(*quadric.whole, quadric.patch, params);
  else
    place_patch(quadric.patch, params);
}

// Drops what is not as many as the points, as pbrt does, but for the first where `may_exceed`.
template <class Value>
void PbrtReader::keep_as_many(const PbrtParams& params, std::string_view name, std::size_t points, bool may_exceed,
                              std::vector<Value>& values) {
  if (values.empty() || values.size() == points) return;
  const bool keeps_first = may_exceed && values.size() > points;
  warn(params.where(name), fmt::format("{}: '{}' has {} values, but there are {} points: {}, as by pbrt", params.owner(), name,
                                       values.size(), points, keeps_first ? "the first count" : "left out"));
  values.resize(keeps_first ? points : 0);
}

TriangleMesh PbrtReader::triangle_mesh(const PbrtParams& params) {
  TriangleMesh mesh;
  mesh.positions = params.points3("P");
  mesh.normals = params.points3("N");
  const std::size_t vertices = mesh.positions.size();
  if (vertices == 0) params.fail("P", "is missing or empty; expected points");
  for (const char* name : {"uv", "st"})
    if (auto uvs = params.points2(name); !uvs.empty()) {
      keep_as_many(params, name, vertices, version3_, uvs);
      if (!uvs.empty()) mesh.uvs = std::move(uvs);
    }
  keep_as_many(params, "N", vertices, false, mesh.normals);
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
  params.ignore({"faceIndices"});
  if (version3_ && params.boolean("discarddegenerateUVs", false)) discard_degenerate_uvs(mesh);
  return mesh;
}

void PbrtReader::mesh_file(PbrtLexer& lexer, const PbrtParams& params) {
  const std::string file = params.string("filename", "");
  if (file.empty()) params.fail("filename", "is missing");
  params.approximate("displacement", "surfaces are not displaced", "the mesh without its fine relief");
  params.ignore({"displacement.edgelength", "edgelength"});
  const SceneFiles::File read = files_.read(file, *lexer.file(), params.where("filename"));
  const std::string extension = extension_of(file);
  try {
    TriangleMesh mesh = extension == ".obj"   ? parse_obj(read.bytes, read.path)
                        : extension == ".smf" ? parse_smf(read.bytes, read.path)
                                              : parse_ply(read.bytes, read.path);
    if (const auto bent = version3_ ? 0 : count_bent(mesh))
      warn(params.where("filename"),
           fmt::format("{} quadrilaterals are bent: two triangles each, where pbrt-v4 has a bilinear patch", bent));
    if (const auto stretched = version3_ ? 0 : count_stretched(mesh, needs_uvs(params)))
      warn(params.where("filename"),
           fmt::format("{} quadrilaterals show their texture or normals over two triangles each, where pbrt-v4 has a bilinear "
                       "patch that shows them otherwise",
                       stretched));
    if (version3_ && params.boolean("discarddegenerateUVs", false)) discard_degenerate_uvs(mesh);
    place(std::move(mesh), params, "'" + file + "'");
  } catch (const Error& e) {
    throw has_place(e, params) ? e : Error(params.where("filename"), e.what());
  }
}

bool PbrtReader::glows_by_image() const { return attributes_.glow && attributes_.glow->texture != no_id && !open_definition_; }

ShapeLook PbrtReader::look(const PbrtParams& params, bool flip_normal, std::uint32_t material, std::uint32_t mask) {
  auto glow = attributes_.glow;
  if (glow && open_definition_) {
    approximate(params.where(),
                fmt::format("{}: shapes of an object cannot emit light; place it outside ObjectBegin", params.owner()),
                "a surface without emission, as in pbrt");
    glow.reset();
  }
  return {material, flip_normal, glow, mask};
}

// Gives a light that states its power the radiance of all of its area.
void PbrtReader::spread_power(ShapeLook& look, double area, std::size_t shapes) const {
  if (!look.glow || !attributes_.glows_by_power) return;
  look.glow->radiance *= static_cast<float>(static_cast<double>(shapes) / (pi * area * (look.glow->two_sided ? 2 : 1)));
}

void PbrtReader::spread_power(ShapeLook& look, const TriangleMesh& mesh, const PbrtParams& params, std::size_t shapes) {
  if (!look.glow || !attributes_.glows_by_power) return;
  std::vector<double> areas;  // of triangles and quadrilaterals
  auto quad = mesh.quads.begin();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const uvec3& t = mesh.triangles[i];
    const auto& p = mesh.positions;
    const double area = 0.5 * glm::length(glm::cross(dvec3(p[t[1]] - p[t[0]]), dvec3(p[t[2]] - p[t[0]])));
    if (quad != mesh.quads.end() && *quad + 1 == i) {
      areas.back() += area;
      ++quad;
    } else {
      areas.push_back(area);
    }
  }
  const double sum = std::accumulate(areas.begin(), areas.end(), 0.0);
  if (shapes != 1 && *std::max_element(areas.begin(), areas.end()) > 1.001 * sum / static_cast<double>(areas.size()))
    approximate(params.where(), params.owner() + ": each of its faces is a light of the same 'power'",
                "the same radiance all over, which adds up to as much");
  spread_power(look, sum, shapes == 0 ? areas.size() : shapes);
  if (!is_finite(look.glow->radiance) || max_component(look.glow->radiance) > brightest)
    throw Error(params.where(), fmt::format("{}: the radiance of its 'power' is beyond {:g}", params.owner(), brightest));
}

bool PbrtReader::needs_uvs(const PbrtParams& params) {
  const MaterialEntry& entry = materials_[attributes_.material];
  return entry.textured || entry.relief || entry.opacity || glows_by_image() || varying_alpha(params);
}

// Version 4 makes one patch of a quadrilateral, over the unit square; version 3 begins the second triangle at the last corner.
void PbrtReader::give_uvs_of_quads(TriangleMesh& mesh) const {
  give_default_uvs(mesh);
  constexpr vec2 second[2][3] = {{{0, 0}, {1, 1}, {0, 1}}, {{1, 0}, {1, 1}, {0, 0}}};
  for (const std::uint32_t q : mesh.quads)
    for (int corner = 0; corner < 3; ++corner) mesh.uvs[mesh.triangles[q + 1][corner]] = second[version3_ ? 1 : 0][corner];
}

// pbrt-v3 lights a scene from the side of a mesh's normals as they are given (Triangle::Sample), but its rays find the light on
// the other side under ReverseOrientation or a mirroring transform, if not under both. Other shapes, and meshes of version 4,
// are at one with themselves.
bool PbrtReader::keeps_side_of_normals(const TriangleMesh& mesh, const PbrtParams& params, bool is_triangles) {
  if (!version3_ || !is_triangles || mesh.normals.empty()) return false;
  if (!attributes_.glow || attributes_.glow->two_sided || open_definition_) return false;
  if (attributes_.reverse_orientation != ctm().swaps_handedness())
    warn(params.where(), params.owner() +
                             ": under ReverseOrientation or a mirroring transform pbrt-v3 takes the light of a mesh from the "
                             "side of its normals and shows it on the other; here both are the former");
  return true;
}

void PbrtReader::place(TriangleMesh mesh, const PbrtParams& params, const std::string& name, std::size_t shapes) {
  const auto opacity = constant_opacity(params);
  if (!opacity) return;
  const Transform& t = ctm();
  const bool keeps_side = keeps_side_of_normals(mesh, params, shapes == 0);
  const bool reverse = attributes_.reverse_orientation && !keeps_side;
  for (vec3& p : mesh.positions) {
    p = t.point(p);
    if (!within_reach(p))
      throw Error(params.where(), fmt::format("{}: placed, a vertex lies beyond {:g} m", params.owner(), farthest));
  }
  for (vec3& n : mesh.normals) n = reverse ? -t.normal(n) : t.normal(n);
  mend_attributes(mesh, name);
  for (const std::string& warning : mesh.warnings) warn(params.where(), warning);
  if (mesh.uvs.empty() && !mesh.quads.empty() && needs_uvs(params)) give_uvs_of_quads(mesh);
  if (mesh.triangles.empty()) return;
  ShapeLook appearance = look(params, reverse != t.swaps_handedness(), no_id, no_id);
  spread_power(appearance, mesh, params, shapes);  // over what alpha cuts away, too, as in pbrt
  appearance.mask = add_mask(params, mesh, *opacity);
  if (mesh.triangles.empty()) return;
  appearance.material = material_on(mesh, params);
  const std::size_t triangles = mesh.triangles.size();
  Definition& definition = open_definition_ ? *open_definition_ : world_;
  const std::uint64_t invalid = definition.parts[0].builder.add(std::move(mesh), appearance);
  left_out_.add(params.where().text() + ": " + name, triangles, invalid);
}

void PbrtReader::place_patch(const SurfacePatch& patch, const PbrtParams& params) {
  place(tessellate(patch), params, params.owner(), 1);
}

void PbrtReader::place(const Quadric& quadric, const SurfacePatch& patch, const PbrtParams& params) {
  Transform t = ctm();
  const MaterialEntry& entry = materials_[attributes_.material];
  const bool textured = entry.textured, mirrored = textured && std::holds_alternative<Sphere>(quadric);
  // pbrt's v runs up a sphere, ours down; mirrored, it is the same sphere.
  if (mirrored) t = t * Transform::scale({1, 1, -1});
  const bool glows = attributes_.glow && !open_definition_;
  if (entry.field || entry.opacity || entry.relief || glows_by_image() || varying_alpha(params))
    return place_patch(patch, params);
  std::optional<Quadric> placed;
  try {
    placed = placed_quadric(quadric, t, textured);
  } catch (const Error& e) {
    throw Error(params.where(), fmt::format("{}: {}", params.owner(), e.what()));
  }
  if (!placed && glows) return place_patch(patch, params);  // no instance can emit
  const auto opacity = constant_opacity(params);
  if (!opacity) return;
  ShapeLook appearance =
      look(params, attributes_.reverse_orientation, scene_material(attributes_.material), constant_mask(*opacity));
  Definition& definition = open_definition_ ? *open_definition_ : world_;
  if (placed) {
    spread_power(appearance, quadric_area(*placed), 1);
    definition.parts[0].builder.add(*placed, appearance);
    return;
  }
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
  if (!is_new && !version3_) throw Error(where, fmt::format("object '{}' is defined twice", name));
  if (!is_new) {
    warn(where, fmt::format("object '{}' is defined again: its later instances are of this one, as in pbrt-v3", name));
    entry->second = {};
  }
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
    throw Error(where, unknown_name("object", name, names) + or_further_down());
  }
  instantiate(found->second, ctm());
}

// Objects enter the scene with their first instance.
void PbrtReader::instantiate(Definition& definition, const Transform& to_world) {
  for (PlacedObject& part : definition.parts) {
    if (!part.scene_index) {
      if (part.builder.empty()) continue;
      part.scene_index = static_cast<std::uint32_t>(scene_.objects.size());
      scene_.objects.push_back(part.builder.take());
    }
    add_instance(scene_, {*part.scene_index, to_world * part.to_parent});
  }
}

}  // namespace etendue
