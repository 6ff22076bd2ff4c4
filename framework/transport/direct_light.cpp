#include "framework/transport/direct_light.h"

#include "framework/transport/ray_tools.h"

namespace etendue {

std::optional<DirectLight> sample_direct_light(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf,
                                               const vec3& wo, Sampler& sampler, MisMode mode, float followed_above,
                                               float followed) {
  const vec2 u = sampler.get_2d();
  if (!bsdf.has_non_specular()) return std::nullopt;
  // The light is sampled from where the shadow ray will start: seen from the surface itself, the rim of a sphere light would
  // shadow its own last directions (0.06 % of the light on builtin:sphere-light).
  const auto light = context.lights.sample(ray_origin(point, wo), u);
  if (!light || (mode == MisMode::bsdf && !light->delta)) return std::nullopt;
  const Rgb scattered = bsdf.evaluate(wo, light->wi);
  if (is_black(scattered) || is_black(light->radiance)) return std::nullopt;
  float weight = 1;
  if (!light->delta && mode != MisMode::light) {
    const float pdf_bsdf = bsdf.pdf(wo, light->wi);
    if (pdf_bsdf >= followed_above) weight = mis_weight(mode, light->pdf_solid_angle, followed * pdf_bsdf);
  }
  return DirectLight{scattered * light->radiance * (weight / light->pdf_solid_angle), shadow_ray(point, *light)};
}

Rgb direct_light(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, Sampler& sampler,
                 MisMode mode, float followed_above) {
  const auto light = sample_direct_light(context, point, bsdf, wo, sampler, mode, followed_above);
  return light && unoccluded(context, light->shadow_ray) ? light->radiance : Rgb(0);
}

}  // namespace etendue
