#include "integrators/light_trace.h"

#include "framework/core/parallel.h"
#include "framework/core/sampler.h"
#include "framework/transport/bsdf.h"
#include "framework/transport/ray_tools.h"
#include "integrators/path.h"

namespace etendue {

namespace {

struct Splat {
  std::uint32_t pixel;
  Rgb value;
};

class LightTrace final : public Integrator {
 public:
  explicit LightTrace(const LightTraceParams& params) : params_(params) {}

  void prepare(RenderContext& context) override {
    max_depth_ = context.max_depth(params_.max_depth);
    const auto& materials = context.scene.materials;
    sees_all_ = std::none_of(materials.begin(), materials.end(), [](const Material& m) { return has_specular(m); });
    const auto pixels = static_cast<std::uint32_t>(context.resolution.x * context.resolution.y);
    paths_ = params_.paths > 0 ? static_cast<std::uint32_t>(params_.paths) : pixels;
  }

  void iteration(RenderContext& context, std::uint32_t index, Film& film) override {
    // Fixed chunks of paths, each with its own list, added up in order: the sum does not depend on the threads.
    constexpr std::uint32_t chunk_size = 1024;
    const std::uint32_t chunks = (paths_ + chunk_size - 1) / chunk_size;
    std::vector<std::vector<Splat>> splats(chunks);
    {
      const auto timed = context.phases.measure("emit");
      parallel_for(chunks, 1, [&](std::size_t chunk) {
        const std::uint32_t end = std::min(paths_, (static_cast<std::uint32_t>(chunk) + 1) * chunk_size);
        for (std::uint32_t path = static_cast<std::uint32_t>(chunk) * chunk_size; path < end; ++path)
          trace_particle(context, path, index, splats[chunk]);
      });
    }
    std::vector<dvec3> sums(static_cast<std::size_t>(context.resolution.x) * context.resolution.y, dvec3(0));
    for (const auto& list : splats)
      for (const Splat& splat : list) sums[splat.pixel] += dvec3(splat.value);
    const auto timed = context.phases.measure("trace");
    parallel_pixels(context.resolution, [&](ivec2 pixel) {
      const auto key = static_cast<std::uint64_t>(pixel.y) * context.resolution.x + pixel.x;
      film.add(pixel, Rgb(sums[key] / static_cast<double>(paths_)) + emission_seen(context, pixel, key, index), index);
    });
  }

  Expectation expectation() const override {
    if (sees_all_) return {Bias::unbiased, -1, 0, ""};
    return {Bias::biased, -1, 1,
            "specular surfaces are black: the method cannot sample paths that end on one before the camera"};
  }

 private:
  // Light the camera sees with nothing between: sampled from the camera, as a path tracer would.
  static Rgb emission_seen(const RenderContext& context, ivec2 pixel, std::uint64_t key, std::uint32_t index) {
    Sampler sampler(SamplerKind::sobol, context.seed, Stream::camera, key, index);
    const Ray ray = sample_camera_ray(context, pixel, sampler);
    const Hit hit = trace(context, ray);
    return hit ? context.lights.emitted(context.scene.surface_at(ray, hit), -ray.direction)
               : context.lights.environment(ray.direction);
  }

  void trace_particle(const RenderContext& context, std::uint32_t path, std::uint32_t index, std::vector<Splat>& splats) const {
    const std::uint64_t particle = static_cast<std::uint64_t>(index) * paths_ + path;
    Sampler sampler(SamplerKind::independent, context.seed, Stream::light_path, particle, 0);
    const float u_light = context.needs.light_choice ? sampler.get_1d() : 0;
    const vec2 u_position = sampler.get_2d();
    const auto emitted = context.lights.emit(u_light, u_position, sampler.get_2d());
    if (!emitted) return;
    count(Counter::photons_emitted);
    Ray ray = emitted->ray;
    Rgb power = emitted->power;
    float eta_scale = 1;
    const float initial = max_component(power);
    for (int depth = 1; depth <= max_depth_ && initial > 0; ++depth) {
      const Hit hit = trace(context, ray);
      if (!hit) return;
      const SurfacePoint point = context.scene.surface_at(ray, hit);
      const Bsdf bsdf(context.scene, point);
      const vec3 wo = -ray.direction;
      if (bsdf.has_non_specular()) connect(context, point, bsdf, wo, power, sampler, splats);
      const float u_lobe = sampler.get_1d();
      const BsdfSample scattered = bsdf.sample(wo, u_lobe, sampler.get_2d(), TransportMode::importance);
      if (!scattered) return;
      power *= scattered.weight;
      if (scattered.transmitted) eta_scale /= scattered.eta * scattered.eta;
      if (depth >= params_.roulette_depth) {
        const float survival = std::min(0.95f, max_component(power) * eta_scale / initial);
        if (!(sampler.get_1d() < survival)) return;
        power /= survival;
      }
      ray = spawn_ray(point, scattered.wi);
    }
  }

  static void connect(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo,
                      const Rgb& power, Sampler& sampler, std::vector<Splat>& splats) {
    const vec2 lens = context.needs.thin_lens ? sampler.get_2d() : vec2(0.5f);
    const auto connection = context.scene.camera.connect(context.resolution, point.position, lens);
    if (!connection) return;
    const Rgb scattered = bsdf.evaluate(wo, glm::normalize(connection->lens_point - point.position), TransportMode::importance);
    if (is_black(scattered) || !visible(context, point, connection->lens_point)) return;
    const ivec2 pixel(connection->film);
    const auto key = static_cast<std::uint32_t>(pixel.y * context.resolution.x + pixel.x);
    splats.push_back({key, power * scattered * connection->importance});
  }

  LightTraceParams params_;
  int max_depth_ = 64;
  bool sees_all_ = true;  // no surface whose light no connection to the camera can carry
  std::uint32_t paths_ = 1;
};

}  // namespace

IntegratorEntry light_trace_entry() {
  return {"light-trace", "particles from the lights joined to the camera", list_params<LightTraceParams>(),
          [](const ParamMap& map) { return std::make_unique<LightTrace>(read_params<LightTraceParams>(map, "light-trace")); }};
}

}  // namespace etendue
