#include "framework/scene/camera.h"

#include "framework/core/elementary.h"
#include "framework/core/sampling.h"

namespace etendue {

vec2 Camera::half_extent(ivec2 resolution) const {
  const float shorter = is_parallel() ? half_width : math::tan(0.5f * fov);
  const vec2 size(resolution);
  return shorter * size / std::min(size.x, size.y);
}

Ray Camera::ray(ivec2 resolution, const vec2& film, const vec2& lens) const {
  const CameraRayOf<float> ray(*this, resolution, half_extent(resolution), film, lens);
  return {.origin = ray.origin, .direction = ray.direction};
}

float Camera::pdf(ivec2 resolution, const vec3& direction) const {
  const vec2 pixel = 2.0f * half_extent(resolution) / vec2(resolution);
  if (is_parallel()) return 1 / (pixel.x * pixel.y);
  const vec3 local = to_world.inverse().vector(direction);
  if (distorts) return 1 / (pixel.x * pixel.y * to_world.volume_scale() * local.z * local.z * local.z);
  const float cosine = glm::normalize(local).z;
  return 1 / (pixel.x * pixel.y * cosine * cosine * cosine);
}

std::optional<Camera::Connection> Camera::connect(ivec2 resolution, const vec3& position, const vec2& lens,
                                                  const vec2& beyond) const {
  const vec3 local = to_world.inverse().point(position);
  const vec3 origin = is_parallel()     ? vec3(vec2(local), 0)
                      : lens_radius > 0 ? vec3(lens_radius * sample_unit_disk(lens), 0)
                                        : vec3(0);
  const vec3 towards = local - origin;
  if (!(towards.z > 0)) return std::nullopt;
  // The point where the line meets the plane in focus is brought to distance 1.
  const float focus = lens_radius > 0 ? focal_distance : 1;
  const vec2 on_plane = is_parallel() ? vec2(local) : (vec2(origin) + vec2(towards) * (focus / towards.z)) / focus;
  const vec2 extent = half_extent(resolution);
  const vec2 film = 0.5f * (vec2(on_plane.x, -on_plane.y) / extent + 1.0f) * vec2(resolution);
  const vec2 end = vec2(resolution) + beyond;
  if (!(film.x >= -beyond.x && film.y >= -beyond.y && film.x < end.x && film.y < end.y)) return std::nullopt;
  const vec2 pixel = 2.0f * extent / vec2(resolution);
  if (is_parallel()) return Connection{to_world.point(origin), film, 1 / (pixel.x * pixel.y)};
  if (distorts) {
    const float volume = pixel.x * pixel.y * to_world.volume_scale() * towards.z * towards.z * towards.z;
    return Connection{to_world.point(origin), film, glm::length(to_world.vector(towards)) / volume};
  }
  const float distance_squared = length_squared(towards), cosine = towards.z / std::sqrt(distance_squared);
  return Connection{to_world.point(origin), film, 1.0f / (pixel.x * pixel.y * cosine * cosine * cosine * distance_squared)};
}

}  // namespace etendue
