// Shapes that become meshes: subdivision surfaces, curves, bilinear patches and height fields.

#include "framework/core/fuzzing.h"
#include "framework/io/mesh/loop_subdivision.h"
#include "framework/io/pbrt/reader.h"
#include "framework/io/text.h"

#include <fmt/format.h>

namespace etendue {

namespace {

// The control points of each segment of a B-spline as those of a Bezier curve.
std::vector<vec3> bezier_of_spline(const vec3* p, int degree) {
  if (degree == 2) return {0.5f * (p[0] + p[1]), p[1], 0.5f * (p[1] + p[2])};
  const vec3 a = glm::mix(p[0], p[1], 2.0f / 3), b = glm::mix(p[1], p[2], 1.0f / 3), c = glm::mix(p[1], p[2], 2.0f / 3),
             d = glm::mix(p[2], p[3], 1.0f / 3);
  return {0.5f * (a + b), b, c, 0.5f * (c + d)};
}

void append(TriangleMesh& all, const TriangleMesh& some) {
  const auto before = static_cast<std::uint32_t>(all.positions.size());
  all.positions.insert(all.positions.end(), some.positions.begin(), some.positions.end());
  all.normals.insert(all.normals.end(), some.normals.begin(), some.normals.end());
  all.uvs.insert(all.uvs.end(), some.uvs.begin(), some.uvs.end());
  for (const uvec3& t : some.triangles) all.triangles.push_back(t + before);
}

}  // namespace

void PbrtReader::subdivided_mesh(const PbrtParams& params) {
  const int levels = params.integer("levels", params.integer("nlevels", 3, 0, 12), 0, 12);
  params.ignore({"scheme"});
  try {
    place(subdivide(triangle_mesh(params), levels), params, params.owner());
  } catch (const Error& e) {
    const std::string what = e.what();
    throw what.starts_with(params.where().file) ? e : Error(params.where(), fmt::format("{}: {}", params.owner(), what));
  }
}

// Ribbons as strips; others as tubes, which they resemble from all sides.
void PbrtReader::curve(const PbrtParams& params) {
  const int degree = params.integer("degree", 3, 2, 3);
  const std::string basis = params.string("basis", "bezier"), type = params.string("type", "flat");
  if (basis != "bezier" && basis != "bspline") params.fail("basis", fmt::format("is '{}'; expected bezier or bspline", basis));
  if (type != "flat" && type != "cylinder" && type != "ribbon")
    params.fail("type", fmt::format("is '{}'; expected flat, cylinder or ribbon", type));
  const std::vector<vec3> points = params.points3("P"), normals = params.points3("N");
  const int count = static_cast<int>(points.size());
  const bool spline = basis == "bspline";
  const int segments = spline ? count - degree : (count - 1) / degree;
  if (segments < 1 || (!spline && (count - 1) % degree != 0))
    params.fail("P",
                fmt::format("has {} points; expected {}", count,
                            spline ? fmt::format("{} at least", degree + 1) : fmt::format("a multiple of {} and one", degree)));
  if (type == "ribbon" && static_cast<int>(normals.size()) != segments + 1)
    params.fail("N", fmt::format("has {} normals; expected {}", normals.size(), segments + 1));
  const float width = params.number("width", 1, 0), w0 = params.number("width0", width, 0),
              w1 = params.number("width1", width, 0);
  if (type == "flat")
    approximate(params.where(), "Shape \"curve\" of type flat: no surface turns towards each ray", "a tube of the same width");
  params.ignore({"splitdepth"});
  TriangleMesh mesh;
  for (int i = 0; i < segments; ++i) {
    const vec3* const first = points.data() + (spline ? i : i * degree);
    const auto width_at = [&](int k) { return glm::mix(w0, w1, static_cast<float>(k) / static_cast<float>(segments)); };
    const CurveSegment segment{spline ? bezier_of_spline(first, degree) : std::vector<vec3>(first, first + degree + 1),
                               width_at(i), width_at(i + 1)};
    append(mesh, tessellate(type == "ribbon" ? strip_along(segment, normals[i], normals[i + 1]) : tube_along(segment)));
  }
  if (mesh.triangles.empty()) return warn(params.where(), params.owner() + ": has no extent and is left out");
  place(std::move(mesh), params, params.owner());
}

// Patches over four corners: two triangles where they are flat, else 16 x 16 cells.
void PbrtReader::bilinear_mesh(const PbrtParams& params) {
  const std::vector<vec3> p = params.points3("P"), n = params.points3("N");
  const std::vector<vec2> uv = params.points2("uv");
  std::vector<int> indices = params.integers("indices");
  if (indices.empty() && p.size() == 4) indices = {0, 1, 2, 3};
  if (indices.empty() || indices.size() % 4 != 0)
    params.fail("indices", fmt::format("has {} values; expected four per patch", indices.size()));
  if (!n.empty() && n.size() != p.size())
    params.fail("N", fmt::format("has {} normals, but there are {} points", n.size(), p.size()));
  if (!uv.empty() && uv.size() != p.size())
    params.fail("uv", fmt::format("has {} pairs, but there are {} points", uv.size(), p.size()));
  for (const int i : indices)
    if (i < 0 || static_cast<std::size_t>(i) >= p.size())
      params.fail("indices", fmt::format("has the value {}, but there are {} points", i, p.size()));
  TriangleMesh mesh;
  for (std::size_t k = 0; k < indices.size(); k += 4) {
    const auto corner = [&](const auto& values, float u, float v) {
      return glm::mix(glm::mix(values[indices[k]], values[indices[k + 1]], u),
                      glm::mix(values[indices[k + 2]], values[indices[k + 3]], u), v);
    };
    const auto at = [&](float u, float v) {
      const vec3 du = glm::mix(p[indices[k + 1]] - p[indices[k]], p[indices[k + 3]] - p[indices[k + 2]], v);
      const vec3 dv = glm::mix(p[indices[k + 2]] - p[indices[k]], p[indices[k + 3]] - p[indices[k + 1]], u);
      return PatchPoint{corner(p, u, v), n.empty() ? glm::cross(du, dv) : corner(n, u, v)};
    };
    const vec3 e = p[indices[k + 3]] - p[indices[k]], normal = glm::cross(p[indices[k + 1]] - p[indices[k]], e);
    const float off = std::abs(glm::dot(normal, p[indices[k + 2]] - p[indices[k]]));
    const bool flat = off <= 1e-5f * glm::length(normal) * glm::length(e);
    const int cells = flat ? 1 : unless_fuzzed(16, 3);
    TriangleMesh patch = tessellate({at, cells, cells});
    if (!uv.empty())
      for (vec2& place : patch.uvs) place = corner(uv, place.x, place.y);
    append(mesh, patch);
  }
  if (params.has("emissionfilename"))
    params.approximate("emissionfilename", "the radiance of an area light is constant", "the same radiance all over");
  if (mesh.triangles.empty()) return warn(params.where(), params.owner() + ": has no extent and is left out");
  place(std::move(mesh), params, params.owner());
}

// Over the unit square, with heights Pz row by row.
void PbrtReader::height_field(const PbrtParams& params) {
  const int columns = params.integer("nu", 0, 0, 65536), rows = params.integer("nv", 0, 0, 65536);
  const std::vector<float> heights = params.numbers("Pz");
  if (columns < 2 || rows < 2 || heights.size() != static_cast<std::size_t>(columns) * rows)
    params.fail("Pz", fmt::format("has {} heights; expected nu times nv, {} x {}", heights.size(), columns, rows));
  TriangleMesh mesh;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      mesh.uvs.emplace_back(static_cast<float>(i) / static_cast<float>(columns - 1),
                            static_cast<float>(j) / static_cast<float>(rows - 1));
      mesh.positions.emplace_back(mesh.uvs.back(), heights[static_cast<std::size_t>(j) * columns + i]);
    }
  for (int j = 0; j + 1 < rows; ++j)
    for (int i = 0; i + 1 < columns; ++i) {
      const auto a = static_cast<std::uint32_t>(j * columns + i), b = a + static_cast<std::uint32_t>(columns);
      mesh.triangles.emplace_back(a, a + 1, b + 1);
      mesh.triangles.emplace_back(a, b + 1, b);
    }
  place(std::move(mesh), params, params.owner());
}

}  // namespace etendue
