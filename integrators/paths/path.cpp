#include "integrators/paths/path.h"

#include "framework/core/isa.h"
#include "integrators/paths/emission.h"
#include "integrators/paths/path_choices.h"
#include "integrators/paths/path_event.h"
#include "integrators/paths/runs.h"

#include <variant>
#include <vector>

namespace etendue {

SamplerKind parse_sampler(const std::string& name) { return name == "sobol" ? SamplerKind::sobol : SamplerKind::independent; }

Ray sample_camera_ray(const RenderContext& context, ivec2 pixel, Sampler& sampler) {
  vec2 jitter = sampler.get_2d();
  if (const auto& filter = context.scene.filter)
    jitter = filter->place(jitter, pixel_index(pixel, context.resolution), sampler.index);
  const vec2 film = vec2(pixel) + jitter;
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

const PathKernels& path_kernels() {
#if defined(__x86_64__)
  return kernels_of_isa(path_kernels_one, path_kernels_sse, path_kernels_avx2, path_kernels_avx512);
#else
  return path_kernels_one();
#endif
}

namespace {

// Paths under way together. What it holds is kept between waves for its memory, and grows only.
class PathWave {
 public:
  void trace(const RenderContext& context, std::span<PathSample> paths, int depth, const PathSettings& settings,
             bool count_emission, const PathEnd* end, const PathCaustics* caustics);

 private:
  // One step of the paths after `depth` events. `first`: before their first hits; `counts`: emission counts.
  struct Event {
    const RenderContext& context;
    const PathSettings& settings;
    const PathEnd* end;
    const PathCaustics* caustics;
    int depth;
    bool first, counts;

    bool gathers_at(std::uint32_t material) const { return caustics != nullptr && caustics->gathers_at(material); }
    // A path meets something: does emission count there?
    bool counts_for(const PathState& state) const {
      if (caustics == nullptr || first) return counts;
      PathSample& path = *state.path;
      if (state.pdf_bsdf > 0) path.in_core = path.gathered != no_id && caustics->leaves(path.gathered, state.pdf_bsdf);
      return state.pdf_bsdf > 0 || path.in_core;
    }
  };
  // Runs of a wave: surfaces that are worked out in lanes as they are met, others, and those where paths end.
  enum Kind : std::uint32_t { in_lanes, placed, ended, kinds };

  void sort(const Event& event);
  void arrive(const Event& event, std::uint32_t i);
  void meet(const Event& event);

  template <class... Vectors>
  void grow(Vectors&... vectors) {
    ((vectors.size() < count_ ? vectors.resize(count_) : void()), ...);
  }

  std::size_t count_ = 0;  // of paths under way
  std::vector<PathState> states_, next_states_;
  std::vector<Ray> rays_, next_rays_, shadow_rays_;
  std::vector<Hit> hits_;
  std::vector<SurfacePoint> points_;
  std::vector<PathGain> gains_;
  std::vector<std::uint32_t> to_place_;
  Runs runs_;
};

void PathWave::trace(const RenderContext& context, std::span<PathSample> paths, int depth, const PathSettings& settings,
                     bool count_emission, const PathEnd* end, const PathCaustics* caustics) {
  count_ = paths.size();
  grow(states_, rays_);
  for (std::size_t i = 0; i < count_; ++i) {
    states_[i] = {&paths[i]};
    rays_[i] = paths[i].ray;
  }
  for (const int first = depth; count_ > 0; ++depth) {
    const Event event{context, settings, end, caustics, depth, depth == first, count_emission || depth > first};
    grow(next_states_, next_rays_, shadow_rays_, hits_, points_, gains_);
    etendue::trace(context, std::span(rays_).first(count_), std::span(hits_).first(count_));
    sort(event);
    meet(event);
  }
}

// Into runs of one material. Surfaces that nothing but the run asks about are worked out there.
void PathWave::sort(const Event& event) {
  const auto& [context, settings, end, caustics, depth, first, counts] = event;
  const Scene& scene = context.scene;
  const Object& world = scene.objects[0];
  const bool far = scene.outgrows_caches();
  runs_.reset(kinds * scene.materials.size());
  to_place_.clear();
  for (std::size_t i = 0; i < count_; ++i) {
    if (far) scene.prefetch_surfaces(std::span(hits_).first(count_), i);
    const PathState& state = states_[i];
    const Hit& hit = hits_[i];
    PathSample& path = *state.path;
    const bool counted = event.counts_for(state);
    if (first) path.first_distance = hit ? hit.t : infinity;
    if (counted && context.needs.passed_lights)
      path.radiance += passed_with_mis(context, rays_[i], hit.t, state.pdf_bsdf, state.throughput, settings.mis);
    if (!hit) {
      if (counted) path.radiance += met_with_mis(context, rays_[i], nullptr, state.pdf_bsdf, state.throughput, settings.mis);
    } else if (hit.instance == 0 && world.geometry.is_triangle(hit.primitive)) {
      const Shape& shape = world.shape(hit.primitive);
      const bool asked = depth >= settings.max_depth || (counts && shape.first_light != no_id) ||
                         (end && std::holds_alternative<Diffuse>(scene.materials[shape.material])) ||
                         event.gathers_at(shape.material);
      if (asked)
        to_place_.push_back(static_cast<std::uint32_t>(i));
      else
        runs_.add(kinds * shape.material + in_lanes, static_cast<std::uint32_t>(i));
    } else {
      points_[i] = scene.surface_at(rays_[i], hit);
      arrive(event, static_cast<std::uint32_t>(i));
    }
  }
  path_kernels().place({scene, to_place_, rays_.data(), hits_.data(), points_.data()});
  for (const std::uint32_t i : to_place_) arrive(event, i);
}

// A path at a surface that is worked out.
void PathWave::arrive(const Event& event, std::uint32_t i) {
  const auto& [context, settings, end, caustics, depth, first, counts] = event;
  const PathState& state = states_[i];
  const SurfacePoint& point = points_[i];
  PathSample& path = *state.path;
  if (first) path.first_normal = point.normal;
  if (point.light != no_id && event.counts_for(state))
    path.radiance += met_with_mis(context, rays_[i], &point, state.pdf_bsdf, state.throughput, settings.mis);
  if (depth >= settings.max_depth) return;
  if (event.gathers_at(point.material)) {
    path.gathered = point.material;
    const Bsdf bsdf(context.scene, point);
    path.radiance += state.throughput * caustics->reflected(context, point, bsdf, -rays_[i].direction, depth);
  }
  std::optional<Rgb> reflected;
  if (const auto* diffuse = std::get_if<Diffuse>(&context.scene.materials[point.material]); diffuse && end)
    reflected = end->reflected(point, *diffuse, -rays_[i].direction, depth);
  if (reflected) path.radiance += state.throughput * *reflected;
  runs_.add(kinds * point.material + (reflected ? ended : placed), i);
}

void PathWave::meet(const Event& event) {
  const auto& [context, settings, end, caustics, depth, first, counts] = event;
  PathEvents events{.scene = context.scene,
                    .lights = context.lights,
                    .material = nullptr,
                    .mis = settings.mis,
                    .scatters = true,
                    .roulette = depth + 1 >= settings.roulette_depth,
                    .evenness = settings.evenness,
                    .first = first,
                    .on_triangles = false,
                    .which = {},
                    .states = states_.data(),
                    .rays = rays_.data(),
                    .hits = hits_.data(),
                    .points = points_.data(),
                    .gains = gains_.data(),
                    .shadow_rays = shadow_rays_.data(),
                    .next_states = next_states_.data(),
                    .next_rays = next_rays_.data()};
  runs_.each([&](std::size_t run, std::span<const std::uint32_t> which) {
    const Material& material = events.scene.materials[run / kinds];
    events.material = contents_of(material);
    events.on_triangles = run % kinds == in_lanes;
    events.scatters = run % kinds != ended;
    events.mis = events.scatters ? event.settings.mis : event.end->direct;
    events.which = which;
    path_kernels().meet[material.index()](events);
  });
  states_.swap(next_states_);
  rays_.swap(next_rays_);
  count_ = events.going_on;
  for_unoccluded(context, std::span(shadow_rays_).first(events.gained),
                 [&](std::size_t i) { gains_[i].arrive(shadow_rays_[i]); });
}

}  // namespace

void trace_paths(const RenderContext& context, std::span<PathSample> paths, int depth, const PathSettings& settings,
                 bool count_emission, const PathEnd* end, const PathCaustics* caustics) {
  static thread_local PathWave wave;
  wave.trace(context, paths, depth, settings, count_emission, end, caustics);
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
                        .filter = context.scene.filter.get(),
                        .index = index,
                        .pixels = pixels,
                        .paths = paths.data()});
}

namespace {

class Path final : public Integrator {
 public:
  explicit Path(const PathParams& params) : params_(params), sampler_(parse_sampler(params.sampler)) {}

  void prepare(RenderContext& context) override {
    context.choose_lights_by(params_.lights, params_.mis == "light" ? DirectSamples::of_lights : DirectSamples::of_both);
    const MisMode mis = params_.mis == "auto" ? choose_mis(context).mode : parse_mis(params_.mis);
    settings_ = {context.max_depth(params_.max_depth), params_.roulette_depth, mis};
    if (settings_.roulette_depth < settings_.max_depth) settings_.evenness = roulette_evenness(context, settings_);
  }

  void iteration(RenderContext& context, std::uint32_t index, Film& film) override {
    const auto timed = context.phases.measure("trace");
    parallel_tiles(context.resolution, wave_side, [&](const Tile& whole) {
      const Tile tile = context.seen(whole);
      static thread_local std::vector<PathSample> paths;
      camera_paths(context, tile, sampler_, index, paths);
      trace_paths(context, paths, 0, settings_, true);
      auto path = paths.begin();
      for_pixels(tile, [&](ivec2 pixel) { film.add(pixel, (path++)->radiance, index, sample_weight(context, pixel, index)); });
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
