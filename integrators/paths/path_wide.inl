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

struct ReadWide {
  const PathEvents& events;

  WideMask operator()(std::size_t first, bool uses_uvs, EventPoint<F>& point, WideVec3& wo, PathLanes<F>& path) const {
    const int count = static_cast<int>(std::min<std::size_t>(width, events.which.size() - first));
    Rows<26> rows;
    alignas(64) std::uint32_t index[width], dimension[width];
    alignas(64) std::uint64_t key[width], pcg_state[width], increment[width];
    for (int row = 0; row < width; ++row) {
      const std::uint32_t i = events.which[first + static_cast<std::size_t>(row < count ? row : 0)];
      const SurfacePoint& p = events.points[i];
      const PathState& state = events.states[i];
      rows.put(0, row, p.position);
      rows.put(3, row, p.normal);
      rows.put(6, row, p.shading_normal);
      rows.put(9, row, p.retreat);
      rows.put(12, row, p.clearance);
      rows.put(13, row, events.rays[i].direction);
      rows.put(16, row, state.throughput);
      rows.put(19, row, state.eta_scale);
      rows.put(20, row, state.pdf_bsdf);
      if (uses_uvs) {
        rows.put(21, row, p.uv.x);
        rows.put(22, row, p.uv.y);
        rows.put(23, row, p.tangent);
      }
      const Sampler& sampler = state.path->sampler;
      index[row] = sampler.index;
      dimension[row] = sampler.dimension;
      key[row] = sampler.key;
      pcg_state[row] = sampler.pcg.state;
      increment[row] = sampler.pcg.increment;
    }
    point.position = rows.vec(0);
    point.normal = rows.vec(3);
    point.shading_normal = rows.vec(6);
    point.retreat = rows.vec(9);
    point.clearance = rows.floats(12);
    wo = -rows.vec(13);
    path.throughput = rows.vec(16);
    path.eta_scale = rows.floats(19);
    path.pdf_bsdf = rows.floats(20);
    if (uses_uvs) {
      point.uv = {rows.floats(21), rows.floats(22)};
      point.tangent = rows.vec(23);
    } else {
      point.uv = {0.0f, 0.0f};
      point.tangent = WideVec3(0.0f);
    }
    path.numbers = {events.states[events.which[first]].path->sampler.kind,
                    WideBits::load(index),
                    WideBits::load(dimension),
                    WideLongBits::load(key),
                    {WideLongBits::load(pcg_state), WideLongBits::load(increment)}};
    return WideMask::first(count);
  }
  WideVec3 colour(const TexturedRgb& c, const EventPoint<F>& point, WideMask active) const {
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
    const bool sobol = path.numbers.kind == SamplerKind::sobol;
    alignas(64) std::uint32_t dimension[width];
    path.numbers.dimension.store(dimension);
    for (int row = 0; row < count; ++row) events.states[which[row]].path->sampler.dimension = dimension[row];
    if (!sobol) {
      alignas(64) std::uint64_t pcg_state[width];
      path.numbers.pcg.state.store(pcg_state);
      for (int row = 0; row < count; ++row) events.states[which[row]].path->sampler.pcg.state = pcg_state[row];
    }
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

template <class... M>
constexpr PathKernels kernels_of(const std::variant<M...>*) {
  return {width, {meet<M>...}};
}

}  // namespace
}  // namespace etendue
