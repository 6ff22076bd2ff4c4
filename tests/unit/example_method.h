// Path tracing, one path at a time, with light samples and multiple importance sampling ([Kajiya1986], [Veach1995]).
//
// Unbiased up to the depth limit.
#pragma once

#include "framework/core/parallel.h"
#include "framework/integrator.h"
#include "framework/transport/direct_light.h"
#include "framework/transport/roulette.h"
#include "integrators/paths/emission.h"
#include "integrators/paths/path.h"

namespace etendue {

struct PlainPathParams {
  int max_depth = 0;
  int roulette_depth = 5;
};

template <class Visitor>
void describe(Visitor& v, PlainPathParams& p) {
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.integer("roulette_depth", p.roulette_depth, 0, 65536, "scattering events", "where Russian roulette begins");
}

class PlainPath final : public Integrator {
 public:
  explicit PlainPath(const PlainPathParams& params) : params_(params) {}

  void prepare(RenderContext& context) override {
    context.choose_lights_by(LightChoice::by_need, DirectSamples::of_both);
    params_.max_depth = context.max_depth(params_.max_depth);
  }

  void iteration(RenderContext& context, std::uint32_t index, Film& film) override {
    const auto timed = context.phases.measure("trace");
    parallel_pixels(context.resolution, [&](ivec2 pixel) {
      PathSample path = camera_path(context, pixel, SamplerKind::sobol, index);
      film.add(pixel, radiance(context, path.ray, path.sampler), index, sample_weight(context, pixel, index));
    });
  }

  Expectation expectation() const override { return {Bias::unbiased, -1, 0, ""}; }

 private:
  Rgb radiance(const RenderContext& context, Ray ray, Sampler& sampler) const {
    Rgb sum(0), throughput(1);
    float pdf = 0;        // of the ray's direction, over solid angle; 0: no light sample could have found it
    float eta_scale = 1;  // undoes the eta^2 of refractions, which roulette must not take for absorption
    for (int depth = 0;; ++depth) {
      const Hit hit = trace(context, ray);
      if (!hit) return sum + emitted_with_mis(context, ray, nullptr, pdf, throughput);
      const SurfacePoint point = context.scene.surface_at(ray, hit);
      sum += emitted_with_mis(context, ray, &point, pdf, throughput);
      if (depth == params_.max_depth) return sum;

      const vec3 wo = -ray.direction;
      const Bsdf bsdf(context.scene, point);
      sum += throughput * direct_light(context, point, bsdf, wo, sampler, MisMode::power);

      const float u_lobe = sampler.get_1d();
      const BsdfSample next = bsdf.sample(wo, u_lobe, sampler.get_2d());
      if (is_black(next.weight)) return sum;
      throughput *= next.weight;
      if (next.transmitted) eta_scale *= next.eta * next.eta;
      if (depth + 1 >= params_.roulette_depth && !survives_roulette(throughput, survival_of(throughput, eta_scale), sampler))
        return sum;
      ray = spawn_ray(point, next.wi);
      pdf = next.specular ? 0 : next.pdf_solid_angle;
    }
  }

  PlainPathParams params_;
};

inline IntegratorEntry plain_path_entry() {
  return {"plain-path", "path tracing, one path at a time", list_params<PlainPathParams>(),
          [](const ParamMap& map) { return std::make_unique<PlainPath>(read_params<PlainPathParams>(map, "plain-path")); }};
}

}  // namespace etendue
