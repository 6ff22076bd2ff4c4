#include "integrators/paths/path.h"

#include "framework/core/isa.h"
#include "integrators/paths/emission.h"
#include "integrators/paths/path_event.h"
#include "integrators/paths/runs.h"

#include <variant>
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
constexpr int wave_side = 32;  // paths enough that each material fills lanes

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

const PathKernels& path_kernels() {
#if defined(__x86_64__)
  return kernels_of_isa(path_kernels_one, path_kernels_sse, path_kernels_avx2, path_kernels_avx512);
#else
  return path_kernels_one();
#endif
}

// What a wave holds, kept between waves for its memory.
struct Wave {
  std::vector<PathState> states, next_states;
  std::vector<Ray> rays, next_rays, shadow_rays;
  std::vector<Hit> hits;
  std::vector<SurfacePoint> points;
  std::vector<PathGain> gains;
  Runs runs;
};

}  // namespace

void trace_paths(const RenderContext& context, std::span<PathSample> paths, int depth, const PathSettings& settings,
                 bool count_emission, const PathEnd* end) {
  static thread_local Wave wave;
  static constexpr std::size_t prefetched = 4;  // hits ahead: as long as memory takes
  const Scene& scene = context.scene;
  const Object& world = scene.objects[0];
  const PathKernels& kernels = path_kernels();
  wave.states.clear();
  wave.rays.clear();
  for (PathSample& path : paths) {
    wave.states.push_back({&path});
    wave.rays.push_back(path.ray);
  }
  for (const int first = depth; !wave.states.empty(); ++depth) {
    const std::size_t count = wave.states.size();
    wave.hits.resize(count);
    wave.points.resize(count);
    trace(context, wave.rays, wave.hits);
    wave.runs.reset(4 * scene.materials.size());
    for (std::size_t i = 0; i < count; ++i) {
      if (i + prefetched < count && wave.hits[i + prefetched]) scene.prefetch_surface(wave.hits[i + prefetched]);
      const PathState& state = wave.states[i];
      const Ray& ray = wave.rays[i];
      const Hit& hit = wave.hits[i];
      PathSample& path = *state.path;
      if (depth == first) path.first_distance = hit ? hit.t : infinity;
      const bool counts = count_emission || depth > first;
      if (!hit) {
        if (counts) path.radiance += emitted_with_mis(context, ray, nullptr, state.pdf_bsdf, state.throughput, settings.mis);
        continue;
      }
      // What neither emits nor ends paths has its surface worked out in lanes, where it is a triangle of the world.
      const bool on_triangle = hit.instance == 0 && world.geometry.is_triangle(hit.primitive);
      if (on_triangle && !end && depth < settings.max_depth) {
        const Shape& shape = world.shape(hit.primitive);
        if (!counts || shape.first_light == no_id) {
          wave.runs.add(4 * shape.material, static_cast<std::uint32_t>(i));
          continue;
        }
      }
      SurfacePoint& point = wave.points[i];
      point = scene.surface_at(ray, hit);
      if (depth == first) path.first_normal = point.normal;
      if (counts && point.light != no_id)
        path.radiance += emitted_with_mis(context, ray, &point, state.pdf_bsdf, state.throughput, settings.mis);
      if (depth >= settings.max_depth) continue;
      const std::optional<Rgb> ended = end ? end->reflected(point, Bsdf(scene, point), -ray.direction, depth) : std::nullopt;
      if (ended) path.radiance += state.throughput * *ended;
      wave.runs.add(4 * point.material + (ended ? 2 : 1), static_cast<std::uint32_t>(i));
    }
    for (auto* grown : {&wave.next_rays, &wave.shadow_rays}) grown->resize(count);
    wave.next_states.resize(count);
    wave.gains.resize(count);
    PathEvents events{.scene = scene,
                      .lights = context.lights,
                      .material = nullptr,
                      .mis = settings.mis,
                      .scatters = true,
                      .roulette = depth + 1 >= settings.roulette_depth,
                      .first = depth == first,
                      .on_triangles = false,
                      .which = {},
                      .states = wave.states.data(),
                      .rays = wave.rays.data(),
                      .hits = wave.hits.data(),
                      .points = wave.points.data(),
                      .gains = wave.gains.data(),
                      .shadow_rays = wave.shadow_rays.data(),
                      .next_states = wave.next_states.data(),
                      .next_rays = wave.next_rays.data()};
    wave.runs.each([&](std::size_t kind, std::span<const std::uint32_t> which) {
      const Material& material = scene.materials[kind / 4];
      events.material = contents_of(material);
      events.on_triangles = kind % 4 == 0;
      events.scatters = kind % 4 != 2;
      events.mis = events.scatters ? settings.mis : end->direct;
      events.which = which;
      kernels.meet[material.index()](events);
    });
    wave.states.swap(wave.next_states);
    wave.rays.swap(wave.next_rays);
    wave.states.resize(events.going_on);
    wave.rays.resize(events.going_on);
    for_unoccluded(context, std::span(wave.shadow_rays).first(events.gained),
                   [&](std::size_t i) { wave.gains[i].arrive(wave.shadow_rays[i]); });
  }
}

void camera_paths(const RenderContext& context, const Tile& tile, SamplerKind kind, std::uint32_t index,
                  std::vector<PathSample>& paths) {
  static thread_local std::vector<ivec2> pixels;
  pixels.clear();
  paths.clear();
  for_pixels(tile, [&](ivec2 pixel) {
    const auto key = pixel_index(pixel, context.resolution);
    paths.push_back({{}, Sampler(kind, context.seed, Stream::camera, key, index)});
    pixels.push_back(pixel);
  });
  const Camera& camera = context.scene.camera;
  path_kernels().start({.camera = camera,
                        .resolution = context.resolution,
                        .extent = camera.half_extent(context.resolution),
                        .thin_lens = context.needs.thin_lens,
                        .pixels = pixels,
                        .paths = paths.data()});
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
    parallel_tiles(context.resolution, wave_side, [&](const Tile& tile) {
      static thread_local std::vector<PathSample> paths;
      camera_paths(context, tile, sampler_, index, paths);
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
