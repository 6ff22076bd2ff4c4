// Emission that a path hits by BSDF sampling, weighted against light sampling at the vertex before.
#pragma once

#include "framework/transport/direct_light.h"

namespace etendue {

// Radiance along `ray` from its hit `point`, or from infinity where that is null, times what the path carries. `pdf_bsdf` is
// the density the ray was sampled with at its origin; 0 for the camera and for delta lobes, which light sampling cannot find.
inline Rgb emitted_with_mis(const RenderContext& context, const Ray& ray, const SurfacePoint* point, float pdf_bsdf,
                            const Rgb& throughput = Rgb(1), MisMode mis = MisMode::power) {
  const Rgb emitted = point ? context.lights.emitted(*point, -ray.direction) : context.lights.environment(ray.direction);
  if (is_black(emitted)) return Rgb(0);
  if (pdf_bsdf == 0) return throughput * emitted;
  const float pdf_light =
      point ? context.lights.pdf(ray.origin, ray.direction, *point) : context.lights.environment_pdf(ray.direction);
  return throughput * emitted * emission_weight(mis, pdf_bsdf, pdf_light);
}

}  // namespace etendue
