// Emission that a path meets by BSDF sampling, MIS-weighted with light sampling at the vertex before.
#pragma once

#include "framework/transport/direct_light.h"
#include "framework/transport/ray_tools.h"

namespace etendue {

// Radiance along `ray` from its hit `point`, or from infinity where that is null, times the path's throughput. `pdf_bsdf` is
// the density the ray was sampled with at its origin; 0 for the camera and for delta lobes, which light sampling cannot find.
inline Rgb met_with_mis(const RenderContext& context, const Ray& ray, const SurfacePoint* point, float pdf_bsdf,
                        const Rgb& throughput, MisMode mis) {
  const Rgb emitted = point ? context.lights.emitted(*point, -ray.direction) : context.lights.environment(ray.direction);
  if (is_black(emitted)) return Rgb(0);
  if (pdf_bsdf == 0) return throughput * emitted;
  const float pdf_light =
      point ? context.lights.pdf(ray.origin, ray.direction, *point) : context.lights.environment_pdf(ray.direction);
  return throughput * emitted * emission_weight(mis, pdf_bsdf, pdf_light);
}

// Gives the same from the lights that the ray passes within `distance`.
inline Rgb passed_with_mis(const RenderContext& context, const Ray& ray, float distance, float pdf_bsdf, const Rgb& throughput,
                           MisMode mis) {
  Rgb sum(0);
  for_passed_lights(context, ray, distance,
                    [&](const SurfacePoint& light) { sum += met_with_mis(context, ray, &light, pdf_bsdf, throughput, mis); });
  return sum;
}

// Sums both up.
inline Rgb emitted_with_mis(const RenderContext& context, const Ray& ray, const SurfacePoint* point, float pdf_bsdf,
                            const Rgb& throughput = Rgb(1), MisMode mis = MisMode::power) {
  const Rgb met = met_with_mis(context, ray, point, pdf_bsdf, throughput, mis);
  if (!context.needs.passed_lights) return met;
  const float distance = point ? glm::length(point->position - ray.origin) : infinity;
  return met + passed_with_mis(context, ray, distance, pdf_bsdf, throughput, mis);
}

// Emission that a BSDF sample of its own meets, MIS-weighted with a light sample, at a vertex where no path goes on.
inline Rgb met_by_bsdf(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo,
                       Sampler& sampler) {
  const float u_lobe = sampler.get_1d();
  const BsdfSample next = bsdf.sample(wo, u_lobe, sampler.get_2d());
  if (!next || next.specular) return Rgb(0);
  Ray ray = spawn_ray(point, next.wi);
  const Hit hit = trace(context, ray);
  if (!hit) return emitted_with_mis(context, ray, nullptr, next.pdf_solid_angle, next.weight);
  const SurfacePoint met = context.scene.surface_at(ray, hit);
  return emitted_with_mis(context, ray, &met, next.pdf_solid_angle, next.weight);
}

// All direct light at a vertex where no path goes on, as choose_direct (integrators/paths/path_choices.h) would have it found.
inline Rgb all_direct_light(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo,
                            Sampler& sampler, MisMode mode) {
  const Rgb sampled = direct_light(context, point, bsdf, wo, sampler, mode);
  return mode == MisMode::power ? sampled + met_by_bsdf(context, point, bsdf, wo, sampler) : sampled;
}

}  // namespace etendue
