// Paths in the lanes of an instruction set: reads and writes what path_event.h computes with.
#pragma once

#include "integrators/lanes/surface_wide.inl"
#include "integrators/paths/path_event.h"

namespace etendue {
namespace {

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

// Writes back what drawing numbers changed, of the first `count`.
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
    std::uint32_t which[width];
    const int count = read_which(events.which, first, which);
    read_paths(which, wo, path);
    point = surface_of(events, which, uses_uvs, -wo);
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

  WideVec3 colour(const TexturedRgb& c, const SurfaceOf<F>& point, WideMask active) const {
    return colour_of(events.scene, c, point, active);
  }
};

struct WriteWide {
  PathEvents& events;

  void operator()(std::size_t first, WideMask gains, const GainLanes<F>& gain, WideMask alive, const PathLanes<F>& path,
                  const RayLanes<F>& onwards) const {
    const int count = static_cast<int>(std::min<std::size_t>(width, events.which.size() - first));
    const std::uint32_t* which = events.which.data() + first;
    write_numbers(path.numbers, count, [&](int row) { return events.states[which[row]].path; });
    Rows<12> rows;
    if (any(gains)) {
      rows.put(0, gain.ray.origin);
      rows.put(3, gain.ray.direction);
      rows.put(6, gain.ray.t_max);
      rows.put(7, gain.radiance);
      rows.put(10, gain.pdf_light);
      rows.put(11, gain.pdf_bsdf);
      for_lanes(gains, [&](int row) {
        if (events.densities)
          events.densities[events.gained] = {events.states[which[row]].path, rows.get(10, row), rows.get(11, row)};
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

struct ReadQueries {
  const BsdfEvents& events;

  WideMask operator()(std::size_t first, bool uses_uvs, SurfaceOf<F>& point, WideVec3& wo, WideVec3& other) const {
    std::uint32_t which[width];
    const int count = read_which(events.which, first, which);
    Rows<17> rows{};
    for (int row = 0; row < width; ++row) {
      const BsdfQuery& query = events.queries[which[row]];
      const SurfacePoint& p = *query.point;
      rows.put(0, row, p.normal);
      rows.put(3, row, p.shading_normal);
      rows.put(6, row, query.wo);
      rows.put(9, row, query.other);
      if (!uses_uvs) continue;
      rows.put(12, row, p.uv.x);
      rows.put(13, row, p.uv.y);
      rows.put(14, row, p.tangent);
    }
    point.normal = rows.vec(0);
    point.shading_normal = rows.vec(3);
    wo = rows.vec(6);
    other = rows.vec(9);
    point.uv = {rows.floats(12), rows.floats(13)};
    point.tangent = rows.vec(14);
    return WideMask::first(count);
  }
  WideVec3 colour(const TexturedRgb& c, const SurfaceOf<F>& point, WideMask active) const {
    return colour_of(events.scene, c, point, active);
  }
};

struct WriteAnswers {
  const BsdfEvents& events;

  template <class Write>
  void each(std::size_t first, const Write& write) const {
    const int count = static_cast<int>(std::min<std::size_t>(width, events.which.size() - first));
    for (int row = 0; row < count; ++row) write(row, events.which[first + static_cast<std::size_t>(row)]);
  }
  void operator()(std::size_t first, const BsdfPairOf<F>& pair) const {
    Rows<5> rows;
    rows.put(0, pair.value);
    rows.put(3, pair.pdf);
    rows.put(4, pair.pdf_reverse);
    each(first, [&](int row, std::uint32_t i) {
      events.pairs[i] = {rows.get_vec(0, row), rows.get(3, row), rows.get(4, row)};
    });
  }
  void operator()(std::size_t first, const ReversibleSampleOf<F>& next) const {
    Rows<9> rows;
    rows.put(0, next.wi);
    rows.put(3, next.weight);
    rows.put(6, next.pdf_solid_angle);
    rows.put(7, next.eta);
    rows.put(8, next.pdf_reverse);
    const unsigned specular = next.specular.lanes(), transmitted = next.transmitted.lanes();
    each(first, [&](int row, std::uint32_t i) {
      events.samples[i] = {{rows.get_vec(0, row), rows.get_vec(3, row), rows.get(6, row), (specular >> row & 1) != 0,
                            (transmitted >> row & 1) != 0, rows.get(7, row)},
                           rows.get(8, row)};
    });
  }
};

template <class M>
void ask(const BsdfEvents& events) {
  ask_material<F, M>(events, ReadQueries{events}, WriteAnswers{events});
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

void start_hemisphere(const HemispherePaths& paths) {
  for (std::size_t first = 0; first < paths.paths.size(); first += width) {
    const int count = static_cast<int>(std::min<std::size_t>(width, paths.paths.size() - first));
    const auto path = [&](int row) { return &paths.paths[first + static_cast<std::size_t>(row < count ? row : 0)]; };
    Rows<3> rows;
    for (int row = 0; row < width; ++row) {
      const int stratum = paths.first + static_cast<int>(first) + row;
      rows.put(0, row, static_cast<float>(stratum / paths.strata.phi));
      rows.put(1, row, static_cast<float>(stratum % paths.strata.phi));
    }
    SamplerOf<F> numbers = read_numbers(path);
    const WideVec3 direction = hemisphere_direction<F>(paths, rows.floats(0), rows.floats(1), numbers);
    write_numbers(numbers, count, path);
    rows.put(0, direction);
    for (int row = 0; row < count; ++row) path(row)->ray = {.origin = paths.origin, .direction = rows.get_vec(0, row)};
  }
}

void place(const TriangleHits& hits) {
  const Object& world = hits.scene.objects[0];
  for (std::size_t first = 0; first < hits.which.size(); first += width) {
    std::uint32_t which[width];
    const int count = read_which(hits.which, first, which);
    Rows<18> rows;
    for (int row = 0; row < width; ++row) rows.put(0, row, hits.rays[which[row]].direction);
    const SurfaceOf<F> s = surface_of_triangles(hits.scene, hits.hits, which, rows.vec(0));
    rows.put(0, s.position);
    rows.put(3, s.normal);
    rows.put(6, s.shading_normal);
    rows.put(9, s.tangent);
    rows.put(12, s.retreat);
    rows.put(15, s.uv.x);
    rows.put(16, s.uv.y);
    rows.put(17, s.clearance);
    for (int row = 0; row < count; ++row) {
      const std::uint32_t primitive = hits.hits[which[row]].primitive;
      const Shape& shape = world.shape(primitive);
      const bool emits = shape.first_light != no_id;
      hits.points[which[row]] = {.position = rows.get_vec(0, row),
                                 .normal = rows.get_vec(3, row),
                                 .shading_normal = rows.get_vec(6, row),
                                 .tangent = rows.get_vec(9, row),
                                 .uv = {rows.get(15, row), rows.get(16, row)},
                                 .material = shape.material,
                                 .light = emits ? shape.first_light + (primitive - shape.first_primitive) : no_id,
                                 .clearance = rows.get(17, row),
                                 .retreat = rows.get_vec(12, row),
                                 .layer = shape.mask == no_id ? Layer{0} : hits.scene.layer_at(hits.hits[which[row]])};
    }
  }
}

template <class... M>
constexpr PathKernels path_kernels_of(const std::variant<M...>*) {
  return {start, start_hemisphere, place, {meet<M>...}, {ask<M>...}};
}

}  // namespace
}  // namespace etendue
