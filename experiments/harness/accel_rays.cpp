#include "experiments/harness/accel_rays.h"

#include "framework/core/sampler.h"
#include "framework/transport/light_sampling.h"
#include "framework/transport/ray_tools.h"
#include "framework/transport/sampling.h"

namespace etendue {

namespace {

struct Target {
  vec3 direction;  // unit
  float distance;
};

// Where shadow rays of a scene go.
class ShadowTargets {
 public:
  explicit ShadowTargets(const Scene& scene) : lights_(scene), bounds_(scene.bounds()) {}

  std::optional<Target> sample(const vec3& from, Sampler& sampler) const {
    const float u = sampler.get_1d();
    const vec2 v = sampler.get_2d();
    if (!lights_.empty()) {
      const auto light = lights_.sample(from, u, v);
      if (!light) return std::nullopt;
      return Target{light->wi, light->distance};
    }
    const vec3 centre = bounds_.empty() ? vec3(0) : bounds_.centre();
    const float radius = bounds_.empty() ? 1 : 0.5f * glm::length(bounds_.diagonal());
    const vec3 towards = centre + radius * sample_unit_sphere(v) - from;
    const float distance = glm::length(towards);
    if (!(distance > 0)) return std::nullopt;
    return Target{towards / distance, distance};
  }

 private:
  LightSampler lights_;
  Bounds bounds_;
};

}  // namespace

const char* ray_kind_name(RayKind kind) {
  static constexpr const char* names[] = {"primary", "diffuse", "shadow"};
  return names[static_cast<std::size_t>(kind)];
}

RaysByKind record_rays(const Scene& scene, const RayQuery& tracer, int resolution) {
  const ShadowTargets targets(scene);
  RaysByKind rays;
  auto& [primary, diffuse, shadow] = rays;
  for (int y = 0; y < resolution; ++y)
    for (int x = 0; x < resolution; ++x) {
      const auto pixel = static_cast<std::uint64_t>(y) * resolution + x;
      Sampler sampler(SamplerKind::independent, 0, Stream::test, pixel, 0);
      const vec2 film = vec2(x, y) + sampler.get_2d();
      const Ray ray = scene.camera.ray(ivec2(resolution), film, sampler.get_2d());
      primary.push_back(ray);
      const Hit hit = tracer.closest(ray);
      if (!hit) continue;
      const SurfacePoint point = scene.surface_at(ray, hit);
      const vec3 normal = glm::dot(ray.direction, point.normal) > 0 ? -point.normal : point.normal;
      diffuse.push_back(spawn_ray(point, Frame::from_normal(normal).to_world(sample_cosine_hemisphere(sampler.get_2d()))));
      if (const auto target = targets.sample(point.position, sampler))
        shadow.push_back(
            spawn_ray(point, target->direction, std::isinf(target->distance) ? infinity : target->distance * (1 - 1e-4f)));
    }
  return rays;
}

}  // namespace etendue
