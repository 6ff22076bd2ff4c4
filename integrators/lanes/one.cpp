// One path, or photon, after the other: what machines without the other instruction sets run.
#include "integrators/paths/path_event.h"
#include "integrators/photons/photon_event.h"

namespace etendue {

namespace {

SurfaceOf<float> surface_of(const SurfacePoint& p) {
  return {p.position, p.normal, p.shading_normal, p.tangent, p.retreat, p.uv, p.clearance};
}

template <class Events>
SurfaceOf<float> surface_of(const Events& events, std::uint32_t i) {
  return surface_of(events.on_triangles ? events.scene.surface_at(events.rays[i], events.hits[i]) : events.points[i]);
}

struct ReadOne {
  const PathEvents& events;

  bool operator()(std::size_t at, bool, SurfaceOf<float>& point, vec3& wo, PathLanes<float>& path) const {
    const std::uint32_t i = events.which[at];
    const PathState& state = events.states[i];
    point = surface_of(events, i);
    if (events.first) state.path->first_normal = point.normal;
    wo = -events.rays[i].direction;
    path = {state.throughput, state.eta_scale, state.pdf_bsdf, state.path->sampler};
    return true;
  }
  Rgb colour(const TexturedRgb& c, const SurfaceOf<float>& point, bool) const {
    return evaluate(c, events.scene.textures, point.uv);
  }
};

struct WriteOne {
  PathEvents& events;

  void operator()(std::size_t at, bool gains, const GainLanes<float>& gain, bool alive, const PathLanes<float>& path,
                  const RayLanes<float>& onwards) const {
    PathSample* sample = events.states[events.which[at]].path;
    static_cast<SamplerOf<float>&>(sample->sampler) = path.numbers;
    if (gains) {
      events.gains[events.gained] = {&sample->radiance, gain.radiance};
      if (events.densities) events.densities[events.gained] = {sample, gain.pdf_light, gain.pdf_bsdf};
      events.shadow_rays[events.gained++] = {
          .origin = gain.ray.origin, .direction = gain.ray.direction, .t_max = gain.ray.t_max};
    }
    if (!alive) return;
    events.next_states[events.going_on] = {sample, path.throughput, path.eta_scale, path.pdf_bsdf};
    events.next_rays[events.going_on++] = {.origin = onwards.origin, .direction = onwards.direction};
  }
};

template <class M>
void meet(PathEvents& events) {
  meet_material<float, M>(events, ReadOne{events}, WriteOne{events});
}

struct ReadQuery {
  const BsdfEvents& events;

  bool operator()(std::size_t at, bool, SurfaceOf<float>& point, vec3& wo, vec3& other) const {
    const BsdfQuery& query = events.queries[events.which[at]];
    point = surface_of(*query.point);
    wo = query.wo;
    other = query.other;
    return true;
  }
  Rgb colour(const TexturedRgb& c, const SurfaceOf<float>& point, bool) const {
    return evaluate(c, events.scene.textures, point.uv);
  }
};

struct WriteAnswer {
  const BsdfEvents& events;

  void operator()(std::size_t at, const BsdfPair& pair) const { events.pairs[events.which[at]] = pair; }
  void operator()(std::size_t at, const ReversibleSample& next) const { events.samples[events.which[at]] = next; }
};

template <class M>
void ask(const BsdfEvents& events) {
  ask_material<float, M>(events, ReadQuery{events}, WriteAnswer{events});
}

void start(const CameraPaths& paths) {
  for (std::size_t i = 0; i < paths.pixels.size(); ++i) {
    PathSample& path = paths.paths[i];
    const RayLanes<float> ray = sample_camera_rays<float>(paths, vec2(paths.pixels[i]), path.sampler);
    path.ray = {.origin = ray.origin, .direction = ray.direction};
  }
}

void start_hemisphere(const HemispherePaths& paths) {
  for (std::size_t i = 0; i < paths.paths.size(); ++i) {
    const int stratum = paths.first + static_cast<int>(i), phi = paths.strata.phi;
    PathSample& path = paths.paths[i];
    path.ray = {.origin = paths.origin,
                .direction = hemisphere_direction<float>(paths, static_cast<float>(stratum / phi),
                                                         static_cast<float>(stratum % phi), path.sampler)};
  }
}

void place(const TriangleHits& hits) {
  for (const std::uint32_t i : hits.which) hits.points[i] = hits.scene.surface_at(hits.rays[i], hits.hits[i]);
}

void draw(PhotonStarts& starts) {
  std::uint32_t i = starts.first;
  for (PhotonStart& start : starts.starts) start.numbers = starts.numbers.emission(i++);
}

void emit(PhotonStarts& starts) {
  std::uint32_t i = starts.first;
  for (const auto& [u, share] : starts.starts) {
    const EmittedOf<float> emitted = emit_particles<float>(starts.lights, u[0], {u[1], u[2]}, {u[3], u[4]}, true);
    if (!is_black(emitted.power)) {
      starts.states[starts.count] = {i, photon_direct, emitted.power * share, starts.numbers.scattering<float>(i)};
      starts.rays[starts.count++] = {.origin = emitted.origin, .t_min = emitted.t_min, .direction = emitted.direction};
    }
    ++i;
  }
}

struct ReadPhoton {
  const PhotonEvents& events;

  bool operator()(std::size_t at, bool, SurfaceOf<float>& point, vec3& from, PhotonLanes<float>& photon) const {
    const std::uint32_t i = events.which[at];
    const PhotonState& state = events.states[i];
    point = surface_of(events, i);
    from = -events.rays[i].direction;
    photon = {state.power, state.history, {state.random}};
    return true;
  }
  Rgb colour(const TexturedRgb& c, const SurfaceOf<float>& point, bool) const {
    return evaluate(c, events.scene.textures, point.uv);
  }
};

struct WritePhoton {
  PhotonEvents& events;

  void store(std::size_t at, bool stored, const vec3& position, const Rgb& power, const vec3& from, const vec3& normal,
             std::uint32_t history) const {
    const std::uint32_t i = events.which[at];
    if (stored)
      events.stored[events.stored_count++] = {
          events.states[i].path, position, power, from, events.hits[i].t, normal, static_cast<PhotonHistory>(history)};
  }
  void go_on(std::size_t at, bool alive, const PhotonLanes<float>& photon, const RayLanes<float>& ray) const {
    if (!alive) return;
    events.next_states[events.going_on] = {events.states[events.which[at]].path, static_cast<PhotonHistory>(photon.history),
                                           photon.power, photon.numbers.random};
    events.next_rays[events.going_on++] = {.origin = ray.origin, .direction = ray.direction};
  }
};

template <class M>
void meet_photon(PhotonEvents& events) {
  meet_photons<float, M>(events, ReadPhoton{events}, WritePhoton{events});
}

template <class... M>
constexpr PathKernels path_kernels_of(const std::variant<M...>*) {
  return {start, start_hemisphere, place, {meet<M>...}, {ask<M>...}};
}
template <class... M>
constexpr PhotonKernels photon_kernels_of(const std::variant<M...>*) {
  return {draw, emit, {meet_photon<M>...}};
}

}  // namespace

const PhotonKernels& photon_kernels_one() {
  static constexpr PhotonKernels kernels = photon_kernels_of(static_cast<const Material*>(nullptr));
  return kernels;
}

const PathKernels& path_kernels_one() {
  static constexpr PathKernels kernels = path_kernels_of(static_cast<const Material*>(nullptr));
  return kernels;
}

}  // namespace etendue
