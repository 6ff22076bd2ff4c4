// Particles that leave lights, and the densities with which they do.
#include "framework/core/sampling.h"
#include "framework/transport/light_sampling.h"

namespace etendue {

namespace {

// Distance from the scene's centre to the disk through which light from infinity enters, in radii of the scene.
constexpr float disk_distance = 1.01f;

// The distance at which rays leave a light that is a point: beyond walls that it lies in, as far as rounding tells, lest half
// of its light be lost there. Shadow rays end before it, too. It is less than the distance behind a wall at which a lamp is
// hidden.
float least_distance(const vec3& position) { return 4 * rounding_at(position); }

float emission_pdf_of(const AreaLight& light, float chosen, float area, float cosine) {
  if (light.two_sided) return chosen * std::abs(cosine) * 0.5f * inv_pi / area;
  return chosen * std::max(cosine, 0.0f) * inv_pi / area;
}

// Emits from a light that was chosen with probability `chosen`. The ray is constructed in the return value: copying it right
// after it was written would cost more than computing it.
std::optional<LightRay> emit_from_area(const AreaEmitter& emitter, const AreaLight& light, float chosen, std::uint32_t id,
                                       const vec2& u_position, vec2 u_direction) {
  std::optional<LightRay> emitted;
  const float area = emitter.area();
  if (area > 0) {
    const AreaPoint p = emitter.sample(u_position);
    LightRay& ray = emitted.emplace();
    // `choose` has used the light's number up; a two-sided light splits the direction's first number to pick its side.
    const bool back = light.two_sided && u_direction.x < 0.5f;
    if (light.two_sided) u_direction.x = back ? 2 * u_direction.x : 2 * u_direction.x - 1;
    ray.normal = back ? -p.normal : p.normal;
    ray.ray.origin = p.position + p.clearance * ray.normal;
    ray.ray.direction = Frame::from_normal(ray.normal).to_world(sample_cosine_hemisphere(u_direction));
    ray.power = light.radiance * (pi * area * (light.two_sided ? 2 : 1) / chosen);
    if (light.texture != no_id) ray.power *= emitter.image_at(u_position);
    ray.pdf = emission_pdf_of(light, chosen, area, glm::dot(ray.normal, ray.ray.direction));
    ray.light = id;
  }
  return emitted;
}

}  // namespace

std::optional<LightRay> LightSampler::emit(float u_light, const vec2& u_position, const vec2& u_direction) const {
  if (empty()) return std::nullopt;
  const std::size_t i = power_.choose(u_light, u_position.x);
  const float chosen = power_.probability[i];
  if (!(chosen > 0)) return std::nullopt;
  const Light& light = scene_.lights[i];
  const auto id = static_cast<std::uint32_t>(i);

  if (const auto* l = std::get_if<AreaLight>(&light))
    return emit_from_area(emitters_[i], *l, chosen, id, u_position, u_direction);
  if (const auto* l = std::get_if<PointLight>(&light)) {
    const Ray ray{.origin = l->position, .t_min = least_distance(l->position), .direction = sample_unit_sphere(u_direction)};
    return LightRay{ray,  ray.direction, l->intensity * (4 * pi / chosen), emission_pdf(id, {}, ray.direction, {}), id,
                    true, false};
  }
  if (const auto* l = std::get_if<SpotLight>(&light)) {
    const vec3 direction = Frame::from_normal(l->direction).to_world(sample_cone(u_direction, 1 - l->cos_outer));
    const float density = chosen / (2 * pi * (1 - l->cos_outer));
    return LightRay{{.origin = l->position, .t_min = least_distance(l->position), .direction = direction},
                    direction,
                    l->intensity * (spot_falloff(*l, direction) / density),
                    density,
                    id,
                    true,
                    false};
  }
  return emit_from_infinity(id, u_position, u_direction);
}

// Emits through a disk as wide as the scene, perpendicular to the direction, in front of everything.
std::optional<LightRay> LightSampler::emit_from_infinity(std::uint32_t light, const vec2& u_position,
                                                         const vec2& u_direction) const {
  const auto* directional = std::get_if<DirectionalLight>(&scene_.lights[light]);
  const vec3 direction = directional
                             ? directional->direction
                             : -sample_environment(std::get<EnvironmentLight>(scene_.lights[light]), light, u_direction);
  const float area = pi * square(scene_radius_);
  const float density = (directional ? power_.probability[light] : environment_pdf(-direction, power_)) / area;
  if (!(density > 0)) return std::nullopt;
  const vec2 disk = scene_radius_ * sample_unit_disk(u_position);
  const Frame frame = Frame::from_normal(direction);
  const vec3 origin =
      scene_centre_ + disk.x * frame.tangent + disk.y * frame.bitangent - disk_distance * scene_radius_ * direction;
  for (const InfinitePlane& plane : scene_.planes) {
    const float along = -glm::dot(direction, plane.normal), height = glm::dot(plane.point - origin, plane.normal);
    if (along * height > 0) return std::nullopt;
  }
  const Rgb emitted = directional ? directional->irradiance : environment(-direction);
  return LightRay{
      {.origin = origin, .direction = direction}, direction, emitted / density, density, light, false, directional != nullptr};
}

float LightSampler::emission_pdf(std::uint32_t light, const vec3& normal, const vec3& direction, const vec3& to) const {
  const auto* area_light = std::get_if<AreaLight>(&scene_.lights[light]);
  if (!area_light) return emission_pdf_over_cosine(light, direction, to);
  return emission_pdf_of(*area_light, power_.probability[light], emitters_[light].area(), glm::dot(normal, direction));
}

float LightSampler::emission_pdf_over_cosine(std::uint32_t light, const vec3& direction, const vec3& to) const {
  const float chosen = power_.probability[light];
  if (const auto* l = std::get_if<AreaLight>(&scene_.lights[light]))
    return emission_pdf_of(*l, chosen, emitters_[light].area(), 1);
  if (std::holds_alternative<PointLight>(scene_.lights[light])) return chosen * 0.25f * inv_pi;
  if (const auto* l = std::get_if<SpotLight>(&scene_.lights[light]))
    return glm::dot(direction, l->direction) < l->cos_outer ? 0 : chosen / (2 * pi * (1 - l->cos_outer));
  if (!scene_.planes.empty()) {  // all else lies before the disk, and within its edge
    const vec3 from_centre = to - scene_centre_;
    const float along = glm::dot(from_centre, direction);
    if (along < -disk_distance * scene_radius_ || length_squared(from_centre - along * direction) > square(scene_radius_))
      return 0;
  }
  const bool directional = std::holds_alternative<DirectionalLight>(scene_.lights[light]);
  return (directional ? chosen : environment_pdf(-direction, power_)) / (pi * square(scene_radius_));
}

float LightSampler::direct_pdf(const LightRay& ray, const vec3& to) const {
  if (std::holds_alternative<EnvironmentLight>(scene_.lights[ray.light])) return environment_pdf(-ray.ray.direction);
  if (!std::holds_alternative<AreaLight>(scene_.lights[ray.light])) return choice_probability(to, ray.light);
  SurfacePoint point{};
  point.position = ray.ray.origin;
  point.normal = ray.normal;
  point.light = ray.light;
  return pdf(to, -ray.ray.direction, point);
}

}  // namespace etendue
