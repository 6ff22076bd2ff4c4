// Surfaces of a wave in the lanes of an instruction set.
#pragma once

#include "framework/core/lanes_wide.inl"
#include "framework/scene/triangle_surface.h"

namespace etendue {
namespace {

using F = WideFloats;
constexpr int width = widest_lanes;

// Values of a wave, a row each, turned into lanes, and back.
template <int columns>
struct Rows {
  alignas(64) float values[columns][width];

  void put(int column, int row, float value) { values[column][row] = value; }
  void put(int column, int row, const vec3& v) {
    put(column, row, v.x);
    put(column + 1, row, v.y);
    put(column + 2, row, v.z);
  }
  F floats(int column) const { return F::load(values[column]); }
  WideVec3 vec(int column) const { return {floats(column), floats(column + 1), floats(column + 2)}; }
  void put(int column, F value) { value.store(values[column]); }
  void put(int column, const WideVec3& v) {
    put(column, v.x);
    put(column + 1, v.y);
    put(column + 2, v.z);
  }
  float get(int column, int row) const { return values[column][row]; }
  vec3 get_vec(int column, int row) const { return {get(column, row), get(column + 1, row), get(column + 2, row)}; }
};

// Loads what the file gives at the corners.
inline CornerValues<F> corner_values(const Object& world, const Hit* hits, const std::uint32_t* which) {
  Rows<17> rows{};
  for (int row = 0; row < width; ++row) {
    const std::uint32_t primitive = hits[which[row]].primitive;
    const uvec3 v = world.geometry.triangles[primitive];
    const Shape& shape = world.shape(primitive);
    if (shape.has_normals) {
      rows.put(0, row, world.normals[v.x]);
      rows.put(3, row, world.normals[v.y]);
      rows.put(6, row, world.normals[v.z]);
      rows.put(15, row, 1.0f);
    }
    if (!shape.uses_uvs) continue;
    for (int corner = 0; corner < 3; ++corner) {
      const vec2 uv = world.uvs[(&v.x)[corner]];
      rows.put(9 + 2 * corner, row, uv.x);
      rows.put(10 + 2 * corner, row, uv.y);
    }
    rows.put(16, row, 1.0f);
  }
  const auto uv = [&rows](int column) { return WideVec2(rows.floats(column), rows.floats(column + 1)); };
  return {rows.floats(15) != 0, rows.floats(16) != 0, rows.vec(0), rows.vec(3), rows.vec(6), uv(9), uv(11), uv(13)};
}

// Shading normals with the relief of shapes that have one, lane by lane.
inline void add_reliefs(const Scene& scene, const Hit* hits, const std::uint32_t* which, SurfaceOf<F>& point) {
  if (scene.reliefs.empty()) return;
  for (int row = 0; row < width; ++row) {
    const Hit& hit = hits[which[row]];
    if (scene.objects[0].shape(hit.primitive).relief == no_id) continue;
    const vec2 uv(lane(point.uv.x, row), lane(point.uv.y, row));
    set_lane(point.shading_normal, row,
             scene.normal_of_relief(hit, lane(point.normal, row), lane(point.shading_normal, row), uv));
  }
}

// Gives the surfaces of the world's triangles that `which` hits met.
inline SurfaceOf<F> surface_of_triangles(const Scene& scene, const Hit* hits, const std::uint32_t* which,
                                         const WideVec3& direction) {
  const Object& world = scene.objects[0];
  Rows<13> rows;
  bool has_values = false;
  for (int row = 0; row < width; ++row) {
    const Hit& hit = hits[which[row]];
    const uvec3 v = world.geometry.triangles[hit.primitive];
    rows.put(0, row, world.geometry.positions[v.x]);
    rows.put(3, row, world.geometry.positions[v.y]);
    rows.put(6, row, world.geometry.positions[v.z]);
    rows.put(9, row, hit.uv.x);
    rows.put(10, row, hit.uv.y);
    rows.put(11, row, hit.t);
    const Shape& shape = world.shape(hit.primitive);
    rows.put(12, row, shape.flip_normal ? 1.0f : 0.0f);
    has_values |= shape.has_normals || shape.uses_uvs;
  }
  const TriangleHit<F> hit{rows.vec(0),     rows.vec(3), rows.vec(6),         {rows.floats(9), rows.floats(10)},
                           rows.floats(11), direction,   rows.floats(12) != 0};
  if (!has_values) return triangle_surface<F>(hit);
  const CornerValues<F> corners = corner_values(world, hits, which);
  SurfaceOf<F> point = triangle_surface<F>(hit, &corners);
  add_reliefs(scene, hits, which, point);
  return point;
}

// Gathers surfaces that are worked out already.
inline SurfaceOf<F> surface_of_points(const SurfacePoint* points, const std::uint32_t* which, bool uses_uvs) {
  Rows<18> rows{};
  for (int row = 0; row < width; ++row) {
    const SurfacePoint& p = points[which[row]];
    rows.put(0, row, p.position);
    rows.put(3, row, p.normal);
    rows.put(6, row, p.shading_normal);
    rows.put(9, row, p.retreat);
    rows.put(12, row, p.clearance);
    if (!uses_uvs) continue;
    rows.put(13, row, p.uv.x);
    rows.put(14, row, p.uv.y);
    rows.put(15, row, p.tangent);
  }
  return {rows.vec(0),    rows.vec(3), rows.vec(6), rows.vec(15), rows.vec(9), {rows.floats(13), rows.floats(14)},
          rows.floats(12)};
}

// Numbers of the lanes from `first` on, the last one repeated beyond the end; answers how many there are.
inline int read_which(std::span<const std::uint32_t> all, std::size_t first, std::uint32_t* which) {
  const int count = static_cast<int>(std::min<std::size_t>(width, all.size() - first));
  for (int row = 0; row < width; ++row) which[row] = all[first + static_cast<std::size_t>(row < count ? row : count - 1)];
  return count;
}

template <class Events>
SurfaceOf<F> surface_of(const Events& events, const std::uint32_t* which, bool uses_uvs, const WideVec3& direction) {
  return events.on_triangles ? surface_of_triangles(events.scene, events.hits, which, direction)
                             : surface_of_points(events.points, which, uses_uvs);
}

inline WideVec3 colour_of(const Scene& scene, const TexturedRgb& c, const SurfaceOf<F>& point, WideMask active) {
  if (c.is_constant()) return c.constant;
  Rows<2> uv;
  uv.put(0, point.uv.x);
  uv.put(1, point.uv.y);
  vec2 uvs[width];
  Rgb colours[width];
  std::size_t count = 0;
  for_lanes(active, [&](int i) { uvs[count++] = {uv.get(0, i), uv.get(1, i)}; });
  evaluate(scene.textures[c.texture], std::span(uvs, count), colours);
  Rows<3> out{};
  count = 0;
  for_lanes(active, [&](int i) { out.put(0, i, colours[count++]); });
  return out.vec(0);
}

}  // namespace
}  // namespace etendue
