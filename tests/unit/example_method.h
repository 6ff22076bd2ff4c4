// Direct light: what the lights send straight to the first surface, and what it reflects of that towards the camera.
//
// Biased: light of more than one scattering event is missing.
#pragma once

#include "framework/core/parallel.h"
#include "framework/integrator.h"
#include "framework/transport/direct_light.h"
#include "integrators/paths/emission.h"

namespace etendue {

struct DirectParams {
  int light_samples = 1;
};

template <class Visitor>
void describe(Visitor& v, DirectParams& p) {
  v.integer("light_samples", p.light_samples, 1, 1024, "per camera ray", "how many light samples its hit gets");
}

class Direct final : public Integrator {
 public:
  explicit Direct(const DirectParams& params) : params_(params) {}

  void prepare(RenderContext&) override {}

  void iteration(RenderContext& context, std::uint32_t index, Film& film) override {
    const auto timed = context.phases.measure("trace");
    parallel_pixels(context.resolution, [&](ivec2 pixel) {
      const auto key = static_cast<std::uint64_t>(pixel.y) * context.resolution.x + pixel.x;
      Sampler sampler(SamplerKind::sobol, context.seed, Stream::camera, key, index);
      film.add(pixel, radiance(context, pixel, sampler), index);
    });
  }

  Expectation expectation() const override { return {Bias::biased, -1, 1, "light of one scattering event alone"}; }

 private:
  Rgb radiance(const RenderContext& context, ivec2 pixel, Sampler& sampler) const {
    const vec2 film = vec2(pixel) + sampler.get_2d();
    const vec2 lens = context.needs.thin_lens ? sampler.get_2d() : vec2(0.5f);
    const Ray ray = context.scene.camera.ray(context.resolution, film, lens);
    const Hit hit = trace(context, ray);
    if (!hit) return emitted_with_mis(context, ray, nullptr, 0);
    const SurfacePoint point = context.scene.surface_at(ray, hit);
    const Bsdf bsdf(context.scene, point);
    Rgb reflected{0};
    for (int i = 0; i < params_.light_samples; ++i)
      reflected += direct_light(context, point, bsdf, -ray.direction, sampler, MisMode::light);
    return emitted_with_mis(context, ray, &point, 0) + reflected / static_cast<float>(params_.light_samples);
  }

  DirectParams params_;
};

inline IntegratorEntry direct_entry() {
  return {"direct", "direct light alone", list_params<DirectParams>(),
          [](const ParamMap& map) { return std::make_unique<Direct>(read_params<DirectParams>(map, "direct")); }};
}

}  // namespace etendue
