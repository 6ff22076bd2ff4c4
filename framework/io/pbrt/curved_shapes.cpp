// Shapes that become meshes: subdivision surfaces, curves, bilinear patches and height fields.

#include "framework/core/fuzzing.h"
#include "framework/io/mesh/loop_subdivision.h"
#include "framework/io/pbrt/reader.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

namespace {

using glm::dvec4;

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

// One direction of a NURBS surface.
struct KnotVector {
  int degree = 1;
  std::vector<float> knots;
  float from = 0, to = 1;

  struct Value {
    dvec4 point, slope;
  };
  // De Boor's algorithm; `control(i)` is homogeneous, and so is the value.
  template <class Control>
  Value at(float share, const Control& control) const {
    const double t = glm::mix(static_cast<double>(from), static_cast<double>(to), static_cast<double>(share));
    const int last = static_cast<int>(knots.size()) - degree - 2;  // control point
    const auto above = std::upper_bound(knots.begin() + degree + 1, knots.begin() + last + 1, t);
    const int span = static_cast<int>(above - knots.begin()) - 1;
    std::vector<dvec4> d;
    for (int i = 0; i <= degree; ++i) d.push_back(control(span - degree + i));
    dvec4 slope(0);
    for (int round = 1; round <= degree; ++round)
      for (int i = degree; i >= round; --i) {
        const double low = knots[static_cast<std::size_t>(span - degree + i)],
                     width = knots[static_cast<std::size_t>(span + 1 + i - round)] - low;
        const auto at = static_cast<std::size_t>(i);
        if (round == degree && width > 0) slope = (d[at] - d[at - 1]) * (degree / width);
        d[at] = width > 0 ? glm::mix(d[at - 1], d[at], (t - low) / width) : d[at];
      }
    return {d[static_cast<std::size_t>(degree)], slope};
  }
};

KnotVector read_knots(const PbrtParams& params, const std::string& letter, int points) {
  const int order = params.integer(letter + "order", 0, 0, 32);
  if (order < 2 || order > points)
    params.fail(letter + "order", fmt::format("is {}; expected 2 to the number of points, {}", order, points));
  KnotVector v{.degree = order - 1, .knots = params.numbers(letter + "knots")};
  const auto wanted = static_cast<std::size_t>(points + order);
  if (v.knots.size() != wanted || !std::is_sorted(v.knots.begin(), v.knots.end()))
    params.fail(letter + "knots",
                fmt::format("has {} numbers; expected {}, none below the one before", v.knots.size(), wanted));
  const float first = v.knots[static_cast<std::size_t>(order) - 1], last = v.knots[static_cast<std::size_t>(points)];
  v.from = params.number(letter + "0", first, first, last);
  v.to = params.number(letter + "1", last, first, last);
  if (!(v.from < v.to)) params.fail(letter + "1", "leaves nothing of the surface");
  return v;
}

}  // namespace

// Control points row by row, `P`, or with their weights, `Pw`.
void PbrtReader::nurbs(const PbrtParams& params) {
  const int columns = params.integer("nu", 0, 0, 65536), rows = params.integer("nv", 0, 0, 65536);
  const KnotVector u = read_knots(params, "u", columns), v = read_knots(params, "v", rows);
  const auto count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  std::vector<dvec4> points;
  for (const vec3& p : params.points3("P")) points.emplace_back(p, 1);
  const std::vector<float> weighted = params.numbers("Pw");
  for (std::size_t i = 0; i + 3 < weighted.size(); i += 4)
    points.emplace_back(weighted[i], weighted[i + 1], weighted[i + 2], weighted[i + 3]);
  if (points.size() != count)
    params.fail("P", fmt::format("has {} points; expected nu times nv, {} x {}, or as many of four numbers as 'Pw'",
                                 points.size(), columns, rows));
  if (!std::all_of(points.begin(), points.end(), [](const dvec4& p) { return p.w > 0; }))
    params.fail("Pw", "has a weight that is not above 0");
  const auto at = [&](float x, float y) {
    const auto along_u = [&](int j) {
      return u.at(x, [&](int i) { return points[static_cast<std::size_t>(j) * columns + static_cast<std::size_t>(i)]; });
    };
    const auto over = v.at(y, [&](int j) { return along_u(j).point; });
    const dvec4 slope_u = v.at(y, [&](int j) { return along_u(j).slope; }).point;
    const dvec3 position = dvec3(over.point) / over.point.w;
    const auto tangent = [&](const dvec4& slope) { return (dvec3(slope) - slope.w * position) / over.point.w; };
    return PatchPoint{vec3(position), vec3(glm::cross(tangent(slope_u), tangent(over.slope)))};
  };
  const int cells = unless_fuzzed(64, 3);
  TriangleMesh mesh = tessellate({at, cells, cells});
  for (vec2& uv : mesh.uvs) uv = glm::mix(vec2(u.from, v.from), vec2(u.to, v.to), uv);
  if (mesh.triangles.empty()) return warn(params.where(), params.owner() + ": has no extent and is left out");
  place(std::move(mesh), params, params.owner());
}

void PbrtReader::subdivided_mesh(const PbrtParams& params) {
  const int levels = params.integer("levels", params.integer("nlevels", 3, 0, 12), 0, 12);
  params.ignore({"scheme"});
  try {
    place(subdivide(triangle_mesh(params), levels), params, params.owner());
  } catch (const Error& e) {
    throw has_place(e, params) ? e : Error(params.where(), fmt::format("{}: {}", params.owner(), e.what()));
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

// Patches over four corners: two triangles where these are all that a flat patch shows, else 16 x 16 cells.
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
    // Two triangles of a parallelogram interpolate alike what has the same mean at the ends of either diagonal.
    const auto bends = [&](const auto& values) {
      const auto twist = values[indices[k]] + values[indices[k + 3]] - values[indices[k + 1]] - values[indices[k + 2]];
      return glm::length(twist) > 1e-5f * glm::length(values[indices[k + 3]] - values[indices[k]]);
    };
    const auto varies = [&](int i) { return n[indices[k + i]] != n[indices[k]]; };
    const bool stretched = bends(p), turns = !n.empty() && (varies(1) || varies(2) || varies(3)) && (stretched || bends(n)),
               maps = needs_uvs(params) && (stretched || (!uv.empty() && bends(uv)));
    const int cells = flat && !turns && !maps ? 1 : unless_fuzzed(16, 3);
    TriangleMesh patch = tessellate({at, cells, cells});
    if (!uv.empty())
      for (vec2& place : patch.uvs) place = corner(uv, place.x, place.y);
    append(mesh, patch);
  }
  if (params.has("emissionfilename"))
    params.approximate("emissionfilename", "the radiance of an area light is constant", "the same radiance all over");
  if (mesh.triangles.empty()) return warn(params.where(), params.owner() + ": has no extent and is left out");
  place(std::move(mesh), params, params.owner(), indices.size() / 4);
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
