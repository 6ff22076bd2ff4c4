#include "integrators/paths/path.h"
#include "framework/transport/roulette.h"

#include "integrators/paths/emission.h"
#include "integrators/paths/wavefront.h"

#include <vector>

namespace etendue {

SamplerKind parse_sampler(const std::string& name) { return name == "sobol" ? SamplerKind::sobol : SamplerKind::independent; }

Ray sample_camera_ray(const RenderContext& context, ivec2 pixel, Sampler& sampler) {
  const vec2 film = vec2(pixel) + sampler.get_2d();
  const vec2 lens = context.needs.thin_lens ? sampler.get_2d() : vec2(0.5f);
  return context.scene.camera.ray(context.resolution, film, lens);
}

PathSample camera_path(const RenderContext& context, ivec2 pixel, SamplerKind kind, std::uint32_t index) {
  const auto key = pixel_index(pixel, context.resolution);
  Sampler sampler(kind, context.seed, Stream::camera, key, index);
  const Ray ray = sample_camera_ray(context, pixel, sampler);
  return {ray, sampler};
}

namespace {

constexpr int tile_side = 16;

ivec2 path_tiles(ivec2 resolution) { return (resolution + tile_side - 1) / tile_side; }

}  // namespace

std::size_t path_tile_count(ivec2 resolution) {
  const ivec2 tiles = path_tiles(resolution);
  return static_cast<std::size_t>(tiles.x) * tiles.y;
}

Tile path_tile(ivec2 resolution, std::size_t number) {
  const int across = path_tiles(resolution).x;
  const ivec2 begin = tile_side * ivec2(static_cast<int>(number) % across, static_cast<int>(number) / across);
  return {begin, glm::min(begin + tile_side, resolution)};
}

namespace {

// A path under way: what it carries to its next hit.
struct PathState {
  PathSample* path;
  Rgb throughput{1};
  float eta_scale = 1;  // undoes the eta^2 of refractions, which roulette must not take for absorption
  float pdf_bsdf = 0;   // of the direction the ray was sampled with; 0: delta lobe or camera
};

// Samples the direction in which a path goes on from a point with `depth` events before it; false where it ends.
bool scatter(PathState& state, Ray& ray, const SurfacePoint& point, const Bsdf& bsdf, int depth, int roulette_depth) {
  Sampler& sampler = state.path->sampler;
  const float u_lobe = sampler.get_1d();
  const BsdfSample scattered = bsdf.sample(-ray.direction, u_lobe, sampler.get_2d());
  if (!scattered) return false;
  state.throughput *= scattered.weight;
  if (scattered.transmitted) state.eta_scale *= scattered.eta * scattered.eta;
  state.pdf_bsdf = scattered.pdf_solid_angle;
  ray = spawn_ray(point, scattered.wi);
  if (depth + 1 < roulette_depth) return true;
  return survives_roulette(state.throughput, survival_of(state.throughput, state.eta_scale), sampler);
}

}  // namespace

void trace_paths(const RenderContext& context, std::span<PathSample> paths, int depth, const PathSettings& settings,
                 bool count_emission, const PathEnd* end) {
  static thread_local Wavefront<PathState> wave;  // for its memory
  wave.clear();
  for (PathSample& path : paths) wave.start({&path}, path.ray);
  const int first = depth;
  wave.run(context, depth, [&](PathState& state, Ray& ray, const Hit& hit, int depth) {
    PathSample& path = *state.path;
    if (depth == first) path.first_distance = hit ? hit.t : infinity;
    const bool counts = count_emission || depth > first;
    if (!hit) {
      if (counts) path.radiance += emitted_with_mis(context, ray, nullptr, state.pdf_bsdf, state.throughput, settings.mis);
      return false;
    }
    const SurfacePoint point = context.scene.surface_at(ray, hit);
    if (depth == first) path.first_normal = point.normal;
    if (counts) path.radiance += emitted_with_mis(context, ray, &point, state.pdf_bsdf, state.throughput, settings.mis);
    if (depth >= settings.max_depth) return false;
    const Bsdf bsdf(context.scene, point);
    const std::optional<Rgb> ended = end ? end->reflected(point, bsdf, -ray.direction, depth) : std::nullopt;
    const MisMode mis = ended ? end->direct : settings.mis;
    if (const auto light = sample_direct_light(context, point, bsdf, -ray.direction, path.sampler, mis))
      wave.gain({&path.radiance, state.throughput * light->radiance}, light->shadow_ray);
    if (ended) path.radiance += state.throughput * *ended;
    return !ended && scatter(state, ray, point, bsdf, depth, settings.roulette_depth);
  });
}

namespace {

class Path final : public Integrator {
 public:
  explicit Path(const PathParams& params) : params_(params), sampler_(parse_sampler(params.sampler)) {}

  void prepare(RenderContext& context) override {
    settings_ = {context.max_depth(params_.max_depth), params_.roulette_depth, parse_mis(params_.mis)};
  }

  void iteration(RenderContext& context, std::uint32_t index, Film& film) override {
    const auto timed = context.phases.measure("trace");
    parallel_for(path_tile_count(context.resolution), 1, [&](std::size_t number) {
      const Tile tile = path_tile(context.resolution, number);
      static thread_local std::vector<PathSample> paths;
      paths.clear();
      for_pixels(tile, [&](ivec2 pixel) { paths.push_back(camera_path(context, pixel, sampler_, index)); });
      trace_paths(context, paths, 0, settings_, true);
      auto path = paths.begin();
      for_pixels(tile, [&](ivec2 pixel) { film.add(pixel, (path++)->radiance, index); });
    });
  }

  Expectation expectation() const override {
    return {Bias::unbiased, -1, 0, params_.sampler == "sobol" ? "scrambled Sobol points may converge faster than N^-1" : ""};
  }

 private:
  PathParams params_;
  SamplerKind sampler_;
  PathSettings settings_;
};

}  // namespace

IntegratorEntry path_entry() {
  return {"path", "path tracing with multiple importance sampling", list_params<PathParams>(),
          [](const ParamMap& map) { return std::make_unique<Path>(read_params<PathParams>(map, "path")); }};
}

}  // namespace etendue
