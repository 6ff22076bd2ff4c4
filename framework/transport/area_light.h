// Sampling the surface of one emitting primitive: over its area (for particles) and as seen from a point (for direct light).
#pragma once

#include "framework/scene/scene.h"
#include "framework/scene/triangle_point.h"

#include <optional>

namespace etendue {

struct AreaPoint {
  vec3 position;
  vec3 normal;      // of the emitting side
  float clearance;  // metres, as SurfacePoint's
};

template <class F>
struct AreaSampleOf {
  Vec3<F> wi{0.0f};
  F distance{0.0f};
  F pdf_solid_angle{0.0f};
  Vec3<F> normal{0.0f};  // at the light's point, as AreaPoint's
  Vec3<F> end{0.0f};     // where a ray towards it must end: off the light by bounds on rounding errors
};
using AreaSample = AreaSampleOf<float>;

// A point of a light, found uniformly over its area, as it is seen from `position`. The density is 0 where the light shows its
// dark side.
template <class F>
AreaSampleOf<F> seen_from(const Vec3<F>& position, const Vec3<F>& point, const Vec3<F>& normal, F clearance, F area,
                          Mask<F> two_sided) {
  const Vec3<F> towards = point - position;
  const F distance2 = length_squared(towards);
  const F distance = sqrt(distance2);
  AreaSampleOf<F> s;
  s.wi = towards / distance;
  const F cosine = -dot(s.wi, normal);
  const Mask<F> seen = (distance2 > 0) & (area > 0) & ((cosine > 0) | ((cosine < 0) & two_sided));
  s.distance = distance;
  s.normal = normal;
  s.pdf_solid_angle = select(seen, distance2 / (abs(cosine) * area), F(0.0f));
  s.end = point + copysign(clearance + clearance_from_afar(distance), cosine) * normal;
  return s;
}

// An area light with what all its samples have in common.
class AreaEmitter {
 public:
  AreaEmitter() = default;  // emits nothing: of lights that have no area
  AreaEmitter(const Scene& scene, const AreaLight& light);

  float area() const { return area_; }  // m^2
  bool two_sided() const { return two_sided_; }
  // The plane of a triangle whose winding tells which side emits, all of it alike; else null, and samples are taken one by one.
  const TrianglePlane* flat_triangle() const {
    return quadric_ || has_normals_ || texture_ != no_id || !scene_ ? nullptr : &triangle_;
  }

  // The normal of the side that emits, where it is the same at each point: a triangle's or a disc's.
  std::optional<vec3> normal() const;

  // Uniform over the area.
  AreaPoint sample(const vec2& u) const;
  // The factor by which an image on it multiplies its radiance, where `sample` and `sample_towards` are for u; 1 without one.
  Rgb image_at(const vec2& u) const;
  Rgb mean_of_image() const;
  // A point on the light as seen from `position`. Spheres seen from outside are sampled by the cone they fill ([Shirley1996]),
  // everything else by area. pdf_solid_angle is 0 where the light shows its dark side.
  AreaSample sample_towards(const vec3& position, const vec2& u) const;
  // Density with which sample_towards finds `point`, which lies along unit wi; the same on both sides of a one-sided light.
  float pdf_towards(const vec3& position, const vec3& wi, const SurfacePoint& point) const;

 private:
  void settle_side(const Object& world, const uvec3& corners);

  const Scene* scene_ = nullptr;
  const Quadric* quadric_ = nullptr;  // else it is a triangle
  const Sphere* sphere_ = nullptr;    // where the quadric is one
  TrianglePlane triangle_;
  std::uint32_t primitive_ = no_id, texture_ = no_id;
  float area_ = 0;
  bool two_sided_ = false, flip_normal_ = false;
  bool has_normals_ = false;  // they tell at each point which side emits
};

}  // namespace etendue
