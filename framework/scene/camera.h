// Perspective cameras, a pinhole or a thin lens where the aperture is open, and parallel (orthographic) views.
#pragma once

#include "framework/core/sampling.h"
#include "framework/query.h"
#include "framework/scene/transform.h"

#include <optional>

namespace etendue {

struct Camera {
  Transform to_world;        // camera space looks along +z, +y up, +x to the right of the image
  float fov = 0.785398f;     // radians, across the shorter side of the image
  float lens_radius = 0;     // metres; 0: pinhole
  float focal_distance = 1;  // metres, to the plane in focus
  float half_width = 0;      // metres, of the shorter side of a parallel view, which has no lens; 0: perspective
  bool distorts = false;     // to_world stretches angles, of a perspective

  bool is_parallel() const { return half_width > 0; }

  // The ray through a point of the film in pixels ((0,0) is the top-left corner); `lens` in [0,1)^2. Its direction is unit.
  Ray ray(ivec2 resolution, const vec2& film, const vec2& lens) const;

  // A point seen from the lens, for light tracing: where it falls on the film and what a unit of radiance leaving it towards
  // the lens, over its area, adds to that pixel's mean. Empty when it is behind the camera or outside the film, by more than
  // `beyond` pixels.
  struct Connection {
    vec3 lens_point;   // world
    vec2 film;         // pixels
    float importance;  // 1 / (pixel area at distance 1 * cos^3 * distance^2), or 1 / pixel area: multiplies f cos(at the point)
  };
  std::optional<Connection> connect(ivec2 resolution, const vec3& position, const vec2& lens,
                                    const vec2& beyond = vec2(0)) const;

  // Density over solid angle with which `ray` samples a unit direction through one point of the lens, when `film` is uniform
  // over the pixel that the direction falls on: 1 / (pixel area at distance 1 * cos^3). Of a parallel view it is the density
  // over the area across its rays: 1 / pixel area. Divided by spread(distance)^2 both are the density over that area.
  float pdf(ivec2 resolution, const vec3& direction) const;

  // Half the image plane's extent at distance 1, as (x, y); that of a parallel view is the same at all distances.
  vec2 half_extent(ivec2 resolution) const;
  // The factor by which half_extent grows up to a distance.
  float spread(float distance) const { return is_parallel() ? 1 : distance; }
};

// The ray of Camera::ray, or one in each lane (lanes.h); `extent`: Camera::half_extent.
template <class F>
struct CameraRayOf {
  Vec3<F> origin{0.0f}, direction;

  CameraRayOf(const Camera& camera, ivec2 resolution, const vec2& extent, const Vec2<F>& film, const Vec2<F>& lens) {
    const vec2 size(resolution);
    const F x = 2.0f * film.x / size.x - 1.0f, y = 2.0f * film.y / size.y - 1.0f;
    direction = {x * extent.x, -y * extent.y, 1.0f};
    if (camera.is_parallel()) {
      origin = {direction.x, direction.y, 0.0f};
      direction = {0.0f, 0.0f, 1.0f};
    } else if (camera.lens_radius > 0) {
      const Vec2<F> on_disk = sample_unit_disk(lens);
      origin = {camera.lens_radius * on_disk.x, camera.lens_radius * on_disk.y, 0.0f};
      direction = camera.focal_distance * direction - origin;
    }
    origin = camera.to_world.point(origin);
    direction = normalize(camera.to_world.vector(direction));
  }
};

}  // namespace etendue
