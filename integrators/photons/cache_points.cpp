#include "integrators/photons/cache_points.h"

#include "framework/materials/fresnel.h"
#include "framework/transport/ray_tools.h"

namespace etendue {

CachePoint cache_point(const RenderContext& context, const SurfacePoint& point, const vec3& wo, float distance, int depth) {
  const Camera& camera = context.scene.camera;
  const float pixel_width = 2 * camera.half_extent(context.resolution).x / static_cast<float>(context.resolution.x);
  return {.position = point.position,
          .normal = towards(point.shading_normal, point.normal, wo),
          .geometric = towards(point.normal, point.normal, wo),
          .origin = ray_origin(point, wo),
          .pixel_width = camera.spread(distance) * pixel_width,
          .depth = depth};
}

CachePoint follow_pixel(const RenderContext& context, ivec2 pixel, int deepest, SamplerKind kind,
                        const std::function<Follow(const SurfacePoint&, const Bsdf&)>& judge) {
  const auto key = pixel_index(pixel, context.resolution);
  Sampler sampler(kind, context.seed, Stream::initial_pass, key, 0);
  const vec2 lens = context.needs.thin_lens ? sampler.get_2d() : vec2(0.5f);
  Ray ray = context.scene.camera.ray(context.resolution, vec2(pixel) + 0.5f, lens);
  float distance = 0;
  for (int depth = 0; depth < deepest; ++depth) {
    const Hit hit = trace(context, ray);
    if (!hit) break;
    const SurfacePoint point = context.scene.surface_at(ray, hit);
    const vec3 wo = -ray.direction;
    distance += glm::length(point.position - ray.origin);
    const Bsdf bsdf(context.scene, point);
    const Follow verdict = judge(point, bsdf);
    if (verdict == Follow::arrives && takes_records(point, wo)) return cache_point(context, point, wo, distance, depth);
    if (verdict != Follow::goes_on) break;
    const float u_lobe = sampler.get_1d();
    const BsdfSample scattered = bsdf.sample(wo, u_lobe, sampler.get_2d());
    if (!scattered || is_black(scattered.weight) || (is_cached(bsdf) && !scattered.specular)) break;
    ray = spawn_ray(point, scattered.wi);
  }
  return {};
}

CachePoint find_cache_point(const RenderContext& context, ivec2 pixel, int deepest, SamplerKind kind,
                            const RoughMaterials* rough_materials) {
  return follow_pixel(context, pixel, deepest, kind, [rough_materials](const SurfacePoint& point, const Bsdf& bsdf) {
    if (is_cached(bsdf)) return Follow::arrives;
    return rough_materials && (*rough_materials)(point.material) ? Follow::ends : Follow::goes_on;
  });
}

CachePoint find_rough_point(const RenderContext& context, ivec2 pixel, int deepest, SamplerKind kind,
                            const RoughMaterials& rough_materials) {
  return follow_pixel(context, pixel, deepest, kind, [&rough_materials](const SurfacePoint& point, const Bsdf& bsdf) {
    if (!rough_materials(point.material)) return Follow::goes_on;
    return bsdf.is_diffuse() && !is_cached(bsdf) ? Follow::ends : Follow::arrives;
  });
}

Rgb base_reflectance(const Scene& scene, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo) {
  if (bsdf.is_diffuse()) return bsdf.diffuse_albedo();
  const Coat& coat = std::get<Plastic>(scene.materials[point.material]).coat;
  const vec3 normal = towards(point.shading_normal, point.normal, wo);
  if (!(coat.passing(1.0f) > 0)) return Rgb(0);
  return pi * bsdf.evaluate(wo, normal) * (coat.entering() / ((1 - fresnel_dielectric(1.0f, coat.eta())) * coat.passing(1.0f)));
}

}  // namespace etendue
