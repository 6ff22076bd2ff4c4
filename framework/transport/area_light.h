// Sampling the surface of one emitting primitive: over its area (for particles) and as seen from a point (for direct light).
#pragma once

#include "framework/scene/scene.h"
#include "framework/scene/triangle_point.h"

namespace etendue {

struct AreaPoint {
  vec3 position;
  vec3 normal;      // of the emitting side
  float clearance;  // metres, as SurfacePoint's
};

struct AreaSample {
  vec3 wi{0};
  float distance = 0;
  float pdf_solid_angle = 0;
  vec3 normal{0};  // at the light's point, as AreaPoint's
  vec3 end{0};     // where a ray towards it must end: off the light by bounds on rounding errors
};

// An area light with what all its samples have in common.
class AreaEmitter {
 public:
  AreaEmitter() = default;  // emits nothing: of lights that have no area
  AreaEmitter(const Scene& scene, const AreaLight& light);

  float area() const { return area_; }  // m^2

  // Uniform over the area.
  AreaPoint sample(const vec2& u) const;
  // A point on the light as seen from `position`. Spheres seen from outside are sampled by the cone they fill ([Shirley1996]),
  // everything else by area. pdf_solid_angle is 0 where the light shows its dark side.
  AreaSample sample_towards(const vec3& position, const vec2& u) const;
  // Density with which sample_towards finds `point`, which lies along unit wi; the same on both sides of a one-sided light.
  float pdf_towards(const vec3& position, const vec3& wi, const SurfacePoint& point) const;

 private:
  const Scene* scene_ = nullptr;
  const Quadric* quadric_ = nullptr;  // else it is a triangle
  const Sphere* sphere_ = nullptr;    // where the quadric is one
  TrianglePlane triangle_;
  std::uint32_t primitive_ = no_id;
  float area_ = 0;
  bool two_sided_ = false, flip_normal_ = false;
  bool has_normals_ = false;  // they tell which side emits
};

}  // namespace etendue
