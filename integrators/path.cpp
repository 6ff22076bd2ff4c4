#include "integrators/path.h"

#include "framework/core/parallel.h"
#include "framework/transport/ray_tools.h"

#include <utility>

namespace etendue {

SamplerKind parse_sampler(const std::string& name) { return name == "sobol" ? SamplerKind::sobol : SamplerKind::independent; }

Ray sample_camera_ray(const RenderContext& context, ivec2 pixel, Sampler& sampler) {
  const vec2 film = vec2(pixel) + sampler.get_2d();
  const vec2 lens = context.needs.thin_lens ? sampler.get_2d() : vec2(0.5f);
  return context.scene.camera.ray(context.resolution, film, lens);
}

Rgb path_radiance(const RenderContext& context, Ray ray, int depth, const PathSettings& settings, bool count_emission,
                  Sampler& sampler, float* first_distance) {
  Rgb radiance(0), throughput(1);
  float eta_scale = 1;  // undoes the eta^2 of refractions, which roulette must not take for absorption
  float pdf_bsdf = 0;   // of the direction the ray was sampled with; 0: delta lobe or camera
  for (;; ++depth) {
    const Hit hit = trace(context, ray);
    if (first_distance) *std::exchange(first_distance, nullptr) = hit ? hit.t : infinity;
    if (!hit) {
      if (count_emission && context.lights.has_environment()) {
        const float weight =
            pdf_bsdf == 0 ? 1 : emission_weight(settings.mis, pdf_bsdf, context.lights.environment_pdf(ray.direction));
        radiance += throughput * context.lights.environment(ray.direction) * weight;
      }
      break;
    }
    const SurfacePoint point = context.scene.surface_at(ray, hit);
    const vec3 wo = -ray.direction;
    if (count_emission && point.light != no_id) {
      const Rgb emitted = context.lights.emitted(point, wo);
      if (!is_black(emitted)) {
        const float weight =
            pdf_bsdf == 0 ? 1 : emission_weight(settings.mis, pdf_bsdf, context.lights.pdf(ray.origin, ray.direction, point));
        radiance += throughput * emitted * weight;
      }
    }
    count_emission = true;
    if (depth >= settings.max_depth) break;

    const Bsdf bsdf(context.scene, point);
    radiance += throughput * direct_light(context, point, bsdf, wo, sampler, settings.mis);

    const float u_lobe = sampler.get_1d();
    const BsdfSample scattered = bsdf.sample(wo, u_lobe, sampler.get_2d());
    if (!scattered) break;
    throughput *= scattered.weight;
    if (scattered.transmitted) eta_scale *= scattered.eta * scattered.eta;
    pdf_bsdf = scattered.pdf_solid_angle;
    ray = spawn_ray(point, scattered.wi);

    if (depth + 1 >= settings.roulette_depth) {
      const float survival = std::min(0.95f, max_component(throughput) * eta_scale);
      if (!(sampler.get_1d() < survival)) break;
      throughput /= survival;
    }
  }
  return radiance;
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
    parallel_pixels(context.resolution, [&](ivec2 pixel) {
      const auto key = static_cast<std::uint64_t>(pixel.y) * context.resolution.x + pixel.x;
      Sampler sampler(sampler_, context.seed, Stream::camera, key, index);
      const Ray ray = sample_camera_ray(context, pixel, sampler);
      film.add(pixel, path_radiance(context, ray, 0, settings_, true, sampler), index);
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
