#include "framework/transport/light_sampling.h"

#include "framework/core/arc.h"
#include "framework/core/elementary.h"
#include "framework/core/sampling.h"

namespace etendue {

namespace {

vec3 to_light_space(const EnvironmentLight& light, const vec3& direction) {
  return glm::normalize(light.light_to_world.inverse().vector(direction));
}

// The arc cosine of z would be 0 or pi within 2e-4 of a pole.
vec2 equirectangular(const vec3& d) { return {turn_of(d.x, d.y), 2 * turn_of(d.z, std::sqrt(d.x * d.x + d.y * d.y))}; }

}  // namespace

float spot_falloff(const SpotLight& light, const vec3& from_light) {
  const float cosine = glm::dot(from_light, light.direction);
  if (cosine <= light.cos_outer) return 0;
  if (cosine >= light.cos_inner) return 1;
  if (light.fade == SpotFade::linear) {
    const float outer = math::acos(light.cos_outer);
    return (outer - math::acos(cosine)) / (outer - math::acos(light.cos_inner));
  }
  const float x = (cosine - light.cos_outer) / (light.cos_inner - light.cos_outer);
  return light.fade == SpotFade::quartic ? square(x * x) : x * x * (3 - 2 * x);
}

const ImageDistribution* LightSampler::distribution(std::size_t light) const {
  for (std::size_t i = 0; i < environments_.size(); ++i)
    if (environments_[i] == light) return distributions_[i].empty() ? nullptr : &distributions_[i];
  return nullptr;
}

vec3 LightSampler::sample_environment(const EnvironmentLight& light, std::size_t index, const vec2& u) const {
  const ImageDistribution* image = distribution(index);
  if (!image) return sample_unit_sphere(u);
  const vec2 uv = image->sample(u);
  const float theta = pi * uv.y, phi = 2 * pi * uv.x;
  const vec3 local(math::sin(theta) * math::cos(phi), math::sin(theta) * math::sin(phi), math::cos(theta));
  return glm::normalize(light.light_to_world.vector(local));
}

std::optional<LightSample> LightSampler::sample(const vec3& position, float u_light, const vec2& u) const {
  if (empty()) return std::nullopt;
  vec2 choosing(u_light, u.y);
  return sample_light(choose_for(position, choosing), position, u);
}

std::optional<LightSample> LightSampler::sample(const vec3& position, vec2 u) const {
  if (empty()) return std::nullopt;
  const Chosen chosen = choose_for(position, u);
  return sample_light(chosen, position, u);
}

std::optional<LightSample> LightSampler::sample_light(const Chosen& choice, const vec3& position, const vec2& u) const {
  const auto [i, chosen] = choice;
  if (!(chosen > 0)) return std::nullopt;
  const Light& light = scene_.lights[i];
  const auto id = static_cast<std::uint32_t>(i);

  if (const auto* l = std::get_if<AreaLight>(&light)) {
    const AreaSample s = emitters_[i].sample_towards(position, u);
    if (!(s.pdf_solid_angle > 0)) return std::nullopt;
    const Rgb radiance = l->texture == no_id ? l->radiance : l->radiance * emitters_[i].image_at(u);
    return LightSample{s.wi, s.distance, radiance, chosen * s.pdf_solid_angle, false, id, s.normal, s.end};
  }
  if (const auto* l = std::get_if<EnvironmentLight>(&light)) {
    const vec3 wi = sample_environment(*l, i, u);
    const float density = environment_pdf(wi);
    if (!(density > 0)) return std::nullopt;
    return LightSample{wi, infinity, environment(wi), density, false, id, -wi, vec3(0)};
  }
  if (const auto* l = std::get_if<DirectionalLight>(&light))
    return LightSample{-l->direction, infinity, l->irradiance, chosen, true, id, l->direction, vec3(0)};

  const auto* point = std::get_if<PointLight>(&light);
  const auto* spot = std::get_if<SpotLight>(&light);
  const vec3 end = point ? point->position : spot->position, towards = end - position;
  const float distance2 = length_squared(towards);
  if (!(distance2 > 0)) return std::nullopt;
  const float distance = std::sqrt(distance2);
  const vec3 wi = towards / distance;
  const Rgb intensity = point ? point->intensity : spot->intensity * spot_falloff(*spot, -wi);
  return LightSample{wi, distance, intensity / distance2, chosen, true, id, -wi, end};
}

float LightSampler::pdf(const vec3& position, const vec3& wi, const SurfacePoint& point) const {
  if (empty() || point.light == no_id) return 0;
  return choice_probability(position, point.light) * emitters_[point.light].pdf_towards(position, wi, point);
}

// All environments together: their radiances add, and so do the densities that find a direction.
float LightSampler::environment_pdf(const vec3& wi, const Table& choice) const {
  float density = 0;
  for (std::size_t i = 0; i < environments_.size(); ++i) {
    const auto& light = std::get<EnvironmentLight>(scene_.lights[environments_[i]]);
    const ImageDistribution& d = distributions_[i];
    density +=
        choice.probability[environments_[i]] * (d.empty() ? 0.25f * inv_pi : d.pdf(equirectangular(to_light_space(light, wi))));
  }
  return density;
}

Rgb LightSampler::environment(const vec3& direction) const {
  Rgb sum(0);
  for (const std::uint32_t i : environments_) {
    const auto& light = std::get<EnvironmentLight>(scene_.lights[i]);
    if (light.texels.empty()) {
      sum += light.scale;
    } else {
      const ivec2 t = texel_at(light.size, equirectangular(to_light_space(light, direction)));
      sum += light.scale * light.texels[static_cast<std::size_t>(t.y) * light.size.x + t.x];
    }
  }
  return sum;
}

Rgb LightSampler::emitted(const SurfacePoint& point, const vec3& wo) const {
  if (point.light == no_id) return Rgb(0);
  const auto& light = std::get<AreaLight>(scene_.lights[point.light]);
  if (!light.two_sided && !(glm::dot(wo, point.normal) > 0)) return Rgb(0);
  return light.texture == no_id ? light.radiance : light.radiance * evaluate(scene_.textures[light.texture], point.uv);
}

}  // namespace etendue
