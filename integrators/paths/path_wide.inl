// Paths in the lanes of an instruction set: reads and writes what path_event.h computes with.
#pragma once

#include "framework/core/lanes_wide.inl"
#include "integrators/paths/path_event.h"

namespace etendue {
namespace {

using F = WideFloats;
constexpr int width = widest_lanes;

// Values of paths, a row a path, turned into lanes, and back.
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

// The samplers of `width` paths; `path(row)` is one of them.
template <class Paths>
SamplerOf<F> read_numbers(const Paths& path) {
  alignas(64) std::uint32_t index[width], dimension[width];
  alignas(64) std::uint64_t key[width], pcg_state[width], increment[width];
  for (int row = 0; row < width; ++row) {
    const Sampler& sampler = path(row)->sampler;
    index[row] = sampler.index;
    dimension[row] = sampler.dimension;
    key[row] = sampler.key;
    pcg_state[row] = sampler.pcg.state;
    increment[row] = sampler.pcg.increment;
  }
  return {path(0)->sampler.kind,
          WideBits::load(index),
          WideBits::load(dimension),
          WideLongBits::load(key),
          {WideLongBits::load(pcg_state), WideLongBits::load(increment)}};
}

// What drawing numbers changed, of the first `count`.
template <class Paths>
void write_numbers(const SamplerOf<F>& numbers, int count, const Paths& path) {
  if (numbers.kind == SamplerKind::sobol) {
    alignas(64) std::uint32_t dimension[width];
    numbers.dimension.store(dimension);
    for (int row = 0; row < count; ++row) path(row)->sampler.dimension = dimension[row];
  } else {
    alignas(64) std::uint64_t pcg_state[width];
    numbers.pcg.state.store(pcg_state);
    for (int row = 0; row < count; ++row) path(row)->sampler.pcg.state = pcg_state[row];
  }
}

struct ReadWide {
  const PathEvents& events;

  WideMask operator()(std::size_t first, bool uses_uvs, SurfaceOf<F>& point, WideVec3& wo, PathLanes<F>& path) const {
    const int count = static_cast<int>(std::min<std::size_t>(width, events.which.size() - first));
    std::uint32_t which[width];  // the lanes beyond the last path repeat one
    for (int row = 0; row < width; ++row) which[row] = events.which[first + static_cast<std::size_t>(row < count ? row : 0)];
    read_paths(which, wo, path);
    point = events.on_triangles ? surface_of_triangles(which, -wo) : surface_of_points(which, uses_uvs);
    if (events.first)
      for (int row = 0; row < count; ++row) events.states[which[row]].path->first_normal = lane(point.normal, row);
    return WideMask::first(count);
  }

  void read_paths(const std::uint32_t* which, WideVec3& wo, PathLanes<F>& path) const {
    Rows<8> rows;
    for (int row = 0; row < width; ++row) {
      const PathState& state = events.states[which[row]];
      rows.put(0, row, events.rays[which[row]].direction);
      rows.put(3, row, state.throughput);
      rows.put(6, row, state.eta_scale);
      rows.put(7, row, state.pdf_bsdf);
    }
    wo = -rows.vec(0);
    path.throughput = rows.vec(3);
    path.eta_scale = rows.floats(6);
    path.pdf_bsdf = rows.floats(7);
    path.numbers = read_numbers([&](int row) { return events.states[which[row]].path; });
  }

  SurfaceOf<F> surface_of_triangles(const std::uint32_t* which, const WideVec3& direction) const {
    const Object& world = events.scene.objects[0];
    Rows<13> rows;
    bool has_values = false;
    for (int row = 0; row < width; ++row) {
      const Hit& hit = events.hits[which[row]];
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
    const CornerValues<F> corners = corner_values(which);
    return triangle_surface<F>(hit, &corners);
  }

  CornerValues<F> corner_values(const std::uint32_t* which) const {
    const Object& world = events.scene.objects[0];
    Rows<17> rows{};
    for (int row = 0; row < width; ++row) {
      const std::uint32_t primitive = events.hits[which[row]].primitive;
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

  SurfaceOf<F> surface_of_points(const std::uint32_t* which, bool uses_uvs) const {
    Rows<18> rows{};
    for (int row = 0; row < width; ++row) {
      const SurfacePoint& p = events.points[which[row]];
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

  WideVec3 colour(const TexturedRgb& c, const SurfaceOf<F>& point, WideMask active) const {
    if (c.is_constant()) return c.constant;
    WideVec3 out(0.0f);
    for_lanes(active, [&](int i) {
      set_lane(out, i, evaluate(events.scene.textures[c.texture], vec2(lane(point.uv.x, i), lane(point.uv.y, i))));
    });
    return out;
  }
};

struct WriteWide {
  PathEvents& events;

  void operator()(std::size_t first, WideMask gains, const WideVec3& gain, const RayLanes<F>& to_light, WideMask alive,
                  const PathLanes<F>& path, const RayLanes<F>& onwards) const {
    const int count = static_cast<int>(std::min<std::size_t>(width, events.which.size() - first));
    const std::uint32_t* which = events.which.data() + first;
    write_numbers(path.numbers, count, [&](int row) { return events.states[which[row]].path; });
    Rows<11> rows;
    if (any(gains)) {
      rows.put(0, to_light.origin);
      rows.put(3, to_light.direction);
      rows.put(6, to_light.t_max);
      rows.put(7, gain);
      for_lanes(gains, [&](int row) {
        events.gains[events.gained] = {&events.states[which[row]].path->radiance, rows.get_vec(7, row)};
        events.shadow_rays[events.gained++] = {
            .origin = rows.get_vec(0, row), .direction = rows.get_vec(3, row), .t_max = rows.get(6, row)};
      });
    }
    if (!any(alive)) return;
    rows.put(0, onwards.origin);
    rows.put(3, onwards.direction);
    rows.put(6, path.throughput);
    rows.put(9, path.eta_scale);
    rows.put(10, path.pdf_bsdf);
    for_lanes(alive, [&](int row) {
      events.next_states[events.going_on] = {events.states[which[row]].path, rows.get_vec(6, row), rows.get(9, row),
                                             rows.get(10, row)};
      events.next_rays[events.going_on++] = {.origin = rows.get_vec(0, row), .direction = rows.get_vec(3, row)};
    });
  }
};

template <class M>
void meet(PathEvents& events) {
  meet_material<F, M>(events, ReadWide{events}, WriteWide{events});
}

void start(const CameraPaths& paths) {
  for (std::size_t first = 0; first < paths.pixels.size(); first += width) {
    const int count = static_cast<int>(std::min<std::size_t>(width, paths.pixels.size() - first));
    const auto path = [&](int row) { return &paths.paths[first + static_cast<std::size_t>(row < count ? row : 0)]; };
    Rows<6> rows;
    for (int row = 0; row < width; ++row) {
      const ivec2 pixel = paths.pixels[first + static_cast<std::size_t>(row < count ? row : 0)];
      rows.put(0, row, static_cast<float>(pixel.x));
      rows.put(1, row, static_cast<float>(pixel.y));
    }
    SamplerOf<F> numbers = read_numbers(path);
    const RayLanes<F> ray = sample_camera_rays<F>(paths, {rows.floats(0), rows.floats(1)}, numbers);
    write_numbers(numbers, count, path);
    rows.put(0, ray.origin);
    rows.put(3, ray.direction);
    for (int row = 0; row < count; ++row) path(row)->ray = {.origin = rows.get_vec(0, row), .direction = rows.get_vec(3, row)};
  }
}

template <class... M>
constexpr PathKernels kernels_of(const std::variant<M...>*) {
  return {start, {meet<M>...}};
}

}  // namespace
}  // namespace etendue
