#include "integrators/irradiance_cache.h"

#include "framework/core/parallel.h"
#include "framework/transport/ray_tools.h"
#include "integrators/cache_fill.h"
#include "integrators/emission.h"

namespace etendue {

namespace {

constexpr int roulette_depth = 5, shared_above = 16;

class IrradianceCache final : public Integrator {
 public:
  explicit IrradianceCache(const IrradianceCacheParams& params) : params_(params), sampler_(parse_sampler(params.sampler)) {}

  void prepare(RenderContext& context) override;
  void iteration(RenderContext& context, std::uint32_t index, Film& film) override;
  Expectation expectation() const override;

 private:
  Rgb camera_radiance(const RenderContext& context, Ray ray, Sampler& sampler) const;

  IrradianceCacheParams params_;
  SamplerKind sampler_;
  int max_depth_ = 0;
  int cached_below_ = 0;  // events before a point at which light is cached
  std::unique_ptr<CacheLevels> cache_;
};

Gradients parse_gradients(const std::string& name) {
  return name == "none"       ? Gradients::none
         : name == "rotation" ? Gradients::rotation
         : name == "mesh"     ? Gradients::mesh
                              : Gradients::both;
}

void IrradianceCache::prepare(RenderContext& context) {
  const auto timed = context.phases.measure("prefill");
  max_depth_ = context.max_depth(params_.max_depth);
  // Direct light takes one scattering event, indirect light two at least.
  cached_below_ = max_depth_ - (params_.cache_direct ? 0 : 1);
  const CacheSettings settings{.metric = cache_metric(params_.metric),
                               .gradients = parse_gradients(params_.gradients),
                               .clamping = params_.neighbour_clamping,
                               .accuracy = params_.accuracy,
                               .min_spacing = params_.min_spacing,
                               .max_spacing = params_.max_spacing,
                               .strata = HemisphereStrata::of(params_.samples),
                               .sampler = sampler_,
                               .structure = params_.structure};
  const ivec2 size = context.resolution;
  std::vector<CachePoint> seen(static_cast<std::size_t>(size.x) * size.y);
  parallel_pixels(size, [&](ivec2 pixel) {
    seen[static_cast<std::size_t>(pixel.y) * size.x + pixel.x] = find_cache_point(context, pixel, cached_below_, sampler_);
  });
  cache_ = std::make_unique<CacheLevels>(context, settings, std::move(seen), max_depth_ > shared_above);
  const PathSettings tracing{max_depth_, roulette_depth, MisMode::power};
  const HemisphereRadiance radiance = [&](std::span<PathSample> paths, int depth) {
    trace_paths(context, paths, depth, tracing, params_.cache_direct);
  };
  if (params_.records > 0)
    cache_->fill_to(context, radiance, static_cast<std::size_t>(params_.records));
  else
    cache_->fill(context, radiance);
}

void IrradianceCache::iteration(RenderContext& context, std::uint32_t index, Film& film) {
  const auto timed = context.phases.measure("gather");
  parallel_pixels(context.resolution, [&](ivec2 pixel) {
    const auto key = static_cast<std::uint64_t>(pixel.y) * context.resolution.x + pixel.x;
    Sampler sampler(sampler_, context.seed, Stream::camera, key, index);
    const Ray ray = sample_camera_ray(context, pixel, sampler);
    film.add(pixel, camera_radiance(context, ray, sampler), index);
  });
}

Rgb IrradianceCache::camera_radiance(const RenderContext& context, Ray ray, Sampler& sampler) const {
  // Light samples at a cached surface: all of its direct light, or only that of lights no ray can find.
  const MisMode cached_mode = params_.cache_direct ? MisMode::bsdf : MisMode::light;
  Rgb radiance(0), throughput(1);
  float eta_scale = 1, pdf_bsdf = 0;
  bool count_emission = true;
  for (int depth = 0;; ++depth) {
    const Hit hit = trace(context, ray);
    if (!hit) {
      if (count_emission) radiance += throughput * met_emission(context, ray, nullptr, pdf_bsdf);
      return radiance;
    }
    const SurfacePoint point = context.scene.surface_at(ray, hit);
    if (count_emission) radiance += throughput * met_emission(context, ray, &point, pdf_bsdf);
    if (depth >= max_depth_) return radiance;

    const vec3 wo = -ray.direction;
    const Bsdf bsdf(context.scene, point);
    const bool cached = is_cached(bsdf);
    radiance += throughput * direct_light(context, point, bsdf, wo, sampler, cached ? cached_mode : MisMode::power);
    bool found = false;
    if (cached && depth < cached_below_) {
      if (const auto irradiance = cache_->interpolate(depth, point.position, towards(point.shading_normal, point.normal, wo))) {
        radiance += throughput * base_reflectance(context.scene, point, bsdf, wo) * *irradiance * inv_pi;
        found = true;
      }
    }
    if (found && !bsdf.has_specular()) return radiance;

    const float u_lobe = sampler.get_1d();
    const BsdfSample scattered = bsdf.sample(wo, u_lobe, sampler.get_2d());
    if (!scattered || (found && !scattered.specular)) return radiance;
    // A cached surface has had all of its direct light from the light sample, or none.
    count_emission = !cached || scattered.specular || params_.cache_direct;
    throughput *= scattered.weight;
    if (scattered.transmitted) eta_scale *= scattered.eta * scattered.eta;
    pdf_bsdf = cached ? 0 : scattered.pdf_solid_angle;
    ray = spawn_ray(point, scattered.wi);
    if (depth + 1 >= roulette_depth) {
      const float survival = std::min(0.95f, max_component(throughput) * eta_scale);
      if (!(sampler.get_1d() < survival)) return radiance;
      throughput /= survival;
    }
  }
}

Expectation IrradianceCache::expectation() const {
  return {Bias::biased, -1, 0.05, "interpolation within the accuracy a, and the records' own noise [Ward1988]"};
}

}  // namespace

IntegratorEntry irradiance_cache_entry() {
  return {"irradiance-cache", "irradiance caching with rotation and translation gradients",
          list_params<IrradianceCacheParams>(), [](const ParamMap& map) {
            return std::make_unique<IrradianceCache>(read_params<IrradianceCacheParams>(map, "irradiance-cache"));
          }};
}

}  // namespace etendue
