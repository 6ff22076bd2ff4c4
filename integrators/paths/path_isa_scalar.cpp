// One path after the other.
#include "integrators/paths/path_event.h"

namespace etendue {

namespace {

struct ReadOne {
  const PathEvents& events;

  bool operator()(std::size_t at, bool, SurfaceOf<float>& point, vec3& wo, PathLanes<float>& path) const {
    const std::uint32_t i = events.which[at];
    const PathState& state = events.states[i];
    const SurfacePoint p = events.on_triangles ? events.scene.surface_at(events.rays[i], events.hits[i]) : events.points[i];
    if (events.first) state.path->first_normal = p.normal;
    point = {p.position, p.normal, p.shading_normal, p.tangent, p.retreat, p.uv, p.clearance};
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

  void operator()(std::size_t at, bool gains, const Rgb& gain, const RayLanes<float>& to_light, bool alive,
                  const PathLanes<float>& path, const RayLanes<float>& onwards) const {
    PathSample* sample = events.states[events.which[at]].path;
    static_cast<SamplerOf<float>&>(sample->sampler) = path.numbers;
    if (gains) {
      events.gains[events.gained] = {&sample->radiance, gain};
      events.shadow_rays[events.gained++] = {
          .origin = to_light.origin, .direction = to_light.direction, .t_max = to_light.t_max};
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

void start(const CameraPaths& paths) {
  for (std::size_t i = 0; i < paths.pixels.size(); ++i) {
    PathSample& path = paths.paths[i];
    const RayLanes<float> ray = sample_camera_rays<float>(paths, vec2(paths.pixels[i]), path.sampler);
    path.ray = {.origin = ray.origin, .direction = ray.direction};
  }
}

template <class... M>
constexpr PathKernels kernels_of(const std::variant<M...>*) {
  return {start, {meet<M>...}};
}

}  // namespace

const PathKernels& path_kernels_scalar() {
  static constexpr PathKernels kernels = kernels_of(static_cast<const Material*>(nullptr));
  return kernels;
}

}  // namespace etendue
