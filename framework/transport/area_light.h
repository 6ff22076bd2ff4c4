// Sampling the surface of one emitting primitive: over its area (for particles) and as seen from a point (for direct light).
#pragma once

#include "framework/scene/scene.h"

namespace etendue {

float primitive_area(const Geometry& geometry, std::uint32_t primitive);

struct AreaPoint {
  vec3 position;
  vec3 normal;      // of the emitting side
  float clearance;  // metres, as SurfacePoint's
  float area;       // of the primitive: points are uniform over it
};
AreaPoint sample_area(const Scene& scene, const AreaLight& light, const vec2& u);

// A point on the light as seen from `position`. Spheres seen from outside are sampled by the cone they fill ([Shirley1996]),
// everything else by area. pdf_solid_angle is 0 where the light shows its dark side.
struct AreaSample {
  vec3 wi{0};
  float distance = 0;
  float pdf_solid_angle = 0;
  vec3 normal{0};  // at the light's point, as AreaPoint's
  vec3 end{0};     // where a ray towards it must end: off the light by bounds on rounding errors
};
AreaSample sample_area_towards(const Scene& scene, const AreaLight& light, const vec3& position, const vec2& u);

// Density with which sample_area_towards finds `point`, which lies along unit wi; the same on both sides of a one-sided light.
float area_pdf_towards(const Scene& scene, const AreaLight& light, const vec3& position, const vec3& wi,
                       const SurfacePoint& point);

}  // namespace etendue
