#include "framework/transport/light_sampling.h"

#include "framework/core/sampling.h"

namespace etendue {

namespace {

// Distance from the scene's centre to the disk through which light from infinity enters, in radii of the scene.
constexpr float disk_distance = 1.01f;

vec3 to_light_space(const EnvironmentLight& light, const vec3& direction) {
  return glm::normalize(light.light_to_world.inverse().vector(direction));
}

vec2 equirectangular(const vec3& d) {
  const float phi = std::atan2(d.y, d.x);
  return {(phi < 0 ? phi + 2 * pi : phi) * (0.5f * inv_pi), std::acos(std::clamp(d.z, -1.0f, 1.0f)) * inv_pi};
}

ivec2 texel_at(const EnvironmentLight& light, const vec2& uv) {
  return glm::clamp(ivec2(uv * vec2(light.size)), ivec2(0), light.size - 1);
}

float spot_falloff(const SpotLight& light, const vec3& from_light) {
  const float cosine = glm::dot(from_light, light.direction);
  if (cosine <= light.cos_outer) return 0;
  if (cosine >= light.cos_inner) return 1;
  if (light.is_linear) {
    const float outer = std::acos(light.cos_outer);
    return (outer - std::acos(cosine)) / (outer - std::acos(light.cos_inner));
  }
  const float x = (cosine - light.cos_outer) / (light.cos_inner - light.cos_outer);
  return x * x * (3 - 2 * x);
}

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

struct LuminousPower {
  float area;    // of an area light, m^2
  float radius;  // of the scene, m

  float operator()(const AreaLight& l) const { return luminance(l.radiance) * pi * area * (l.two_sided ? 2 : 1); }
  float operator()(const PointLight& l) const { return luminance(l.intensity) * 4 * pi; }
  float operator()(const SpotLight& l) const {
    return luminance(l.intensity) * 2 * pi * (1 - 0.5f * (l.cos_inner + l.cos_outer));
  }
  float operator()(const DirectionalLight& l) const { return luminance(l.irradiance) * pi * radius * radius; }
  float operator()(const EnvironmentLight& l) const {
    if (l.texels.empty()) return luminance(l.scale) * 4 * pi * pi * radius * radius;
    double sum = 0, weight = 0;
    for (int y = 0; y < l.size.y; ++y) {
      const double sine = std::sin(pi * (static_cast<float>(y) + 0.5f) / static_cast<float>(l.size.y));
      for (int x = 0; x < l.size.x; ++x)
        sum += sine * luminance(l.texels[static_cast<std::size_t>(y) * l.size.x + x] * l.scale);
      weight += sine * l.size.x;
    }
    return static_cast<float>(sum / weight) * 4 * pi * pi * radius * radius;
  }
};

// By which an image on a light changes how often the light is chosen: never to nothing, for the image's mean is an estimate.
double image_share(const Rgb& mean) { return 0.01 + luminance(mean); }

// Index of the first entry above u in a cumulative table that ends at 1; u is rescaled to [0, 1) within the entry. Bisection
// without a branch, which would be mispredicted every other time.
std::size_t pick(const float* cumulative, std::size_t count, float& u) {
  std::size_t i = 0;
  for (std::size_t left = count; left > 1;) {
    const std::size_t half = left / 2;
    i += half * static_cast<std::size_t>(cumulative[i + half - 1] <= u);
    left -= half;
  }
  const auto is_inner = static_cast<std::size_t>(i > 0);
  const float before = cumulative[i - is_inner] * static_cast<float>(is_inner), width = cumulative[i] - before;
  u = width > 0 ? std::min(std::max(0.0f, (u - before) / width), 0x1.fffffep-1f) : 0;
  return i;
}

}  // namespace

// Chooses a row (its texels weighted by sin theta), then a texel within the row.
struct LightSampler::ImageDistribution {
  ivec2 size{0};
  std::vector<float> rows;     // cumulative
  std::vector<float> columns;  // cumulative within each row
  std::vector<float> density;  // per texel, over the unit square of uv

  explicit ImageDistribution(const EnvironmentLight& light) : size(light.size) {
    const std::size_t count = light.texels.size();
    rows.resize(size.y);
    columns.resize(count);
    density.resize(count);
    double total = 0;
    for (int y = 0; y < size.y; ++y) {
      const float sine = std::sin(pi * (static_cast<float>(y) + 0.5f) / static_cast<float>(size.y));
      double row = 0;
      for (int x = 0; x < size.x; ++x) {
        const std::size_t i = static_cast<std::size_t>(y) * size.x + x;
        density[i] = luminance(light.texels[i]) * sine;
        row += density[i];
        columns[i] = static_cast<float>(row);
      }
      for (int x = 0; x < size.x; ++x) {
        float& c = columns[static_cast<std::size_t>(y) * size.x + x];
        c = row > 0 ? static_cast<float>(c / row) : static_cast<float>(x + 1) / static_cast<float>(size.x);
      }
      total += row;
      rows[y] = static_cast<float>(total);
    }
    for (float& r : rows) r = static_cast<float>(r / total);
    for (float& d : density) d = static_cast<float>(d * static_cast<double>(count) / total);
  }

  vec2 sample(vec2 u) const {
    const auto y = static_cast<int>(pick(rows.data(), rows.size(), u.y));
    const auto x = static_cast<int>(pick(columns.data() + static_cast<std::size_t>(y) * size.x, size.x, u.x));
    return (vec2(x, y) + u) / vec2(size);
  }
  // Density over solid angle.
  float pdf(const EnvironmentLight& light, const vec2& uv) const {
    const ivec2 t = texel_at(light, uv);
    const float sine = std::sin(pi * uv.y);
    return sine > 0 ? density[pixel_index(t, size)] / (2 * pi * pi * sine) : 0;
  }
};

LightSampler::~LightSampler() = default;

LightSampler::LightSampler(const Scene& scene) : scene_(scene) {
  const Bounds bounds = scene.bounds();
  if (!bounds.empty()) {
    scene_centre_ = bounds.centre();
    scene_radius_ = std::max(0.5f * glm::length(bounds.diagonal()), std::numeric_limits<float>::min());
  }
  std::vector<double> power;
  for (const Light& light : scene.lights) {
    const auto* area_light = std::get_if<AreaLight>(&light);
    emitters_.push_back(area_light ? AreaEmitter(scene, *area_light) : AreaEmitter());
    power.push_back(std::visit(LuminousPower{emitters_.back().area(), scene_radius_}, light));
    if (area_light && area_light->texture != no_id) power.back() *= image_share(emitters_.back().mean_of_image());
  }
  double total = 0;
  for (const double p : power) total += p;
  if (!(total > 0)) return;  // no light has power: as if there were none
  double sum = 0;
  for (const double p : power) {
    const double share = p / total;
    sum += share;
    probability_.push_back(static_cast<float>(share));
    cumulative_.push_back(static_cast<float>(sum));
  }
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const auto* light = std::get_if<AreaLight>(&scene.lights[i]);
    const TrianglePlane* plane = light ? emitters_[i].flat_triangle() : nullptr;
    if (!plane) {
      flat_.clear();
      break;
    }
    flat_.push_back({*plane, light->radiance, emitters_[i].area(), probability_[i], light->two_sided ? 1.0f : 0.0f});
  }
  for (std::uint32_t i = 0; i < scene.lights.size(); ++i) {
    const auto* environment = std::get_if<EnvironmentLight>(&scene.lights[i]);
    if (!environment) continue;
    environments_.push_back(i);
    const bool black = !(power[i] > 0);
    distributions_.push_back(ImageDistribution(environment->texels.empty() || black ? EnvironmentLight{} : *environment));
  }
}

std::size_t LightSampler::choose(float& u) const {
  return probability_.size() == 1 ? 0 : pick(cumulative_.data(), cumulative_.size(), u);
}

const LightSampler::ImageDistribution* LightSampler::distribution(std::size_t light) const {
  for (std::size_t i = 0; i < environments_.size(); ++i)
    if (environments_[i] == light) return distributions_[i].density.empty() ? nullptr : &distributions_[i];
  return nullptr;
}

vec3 LightSampler::sample_environment(const EnvironmentLight& light, std::size_t index, const vec2& u) const {
  const ImageDistribution* image = distribution(index);
  if (!image) return sample_unit_sphere(u);
  const vec2 uv = image->sample(u);
  const float theta = pi * uv.y, phi = 2 * pi * uv.x;
  const vec3 local(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
  return glm::normalize(light.light_to_world.vector(local));
}

std::optional<LightSample> LightSampler::sample(const vec3& position, float u_light, const vec2& u) const {
  if (empty()) return std::nullopt;
  return sample_light(choose(u_light), position, u);
}

std::optional<LightSample> LightSampler::sample(const vec3& position, vec2 u) const {
  if (empty()) return std::nullopt;
  const std::size_t i = choose(u.x);
  return sample_light(i, position, u);
}

std::optional<LightSample> LightSampler::sample_light(std::size_t i, const vec3& position, const vec2& u) const {
  const float chosen = probability_[i];
  const Light& light = scene_.lights[i];
  const auto id = static_cast<std::uint32_t>(i);
  if (!(chosen > 0)) return std::nullopt;

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
  return probability_[point.light] * emitters_[point.light].pdf_towards(position, wi, point);
}

// All environments together: their radiances add, and so do the densities that find a direction.
float LightSampler::environment_pdf(const vec3& wi) const {
  float density = 0;
  for (std::size_t i = 0; i < environments_.size(); ++i) {
    const auto& light = std::get<EnvironmentLight>(scene_.lights[environments_[i]]);
    const ImageDistribution& d = distributions_[i];
    density += probability_[environments_[i]] *
               (d.density.empty() ? 0.25f * inv_pi : d.pdf(light, equirectangular(to_light_space(light, wi))));
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
      const ivec2 t = texel_at(light, equirectangular(to_light_space(light, direction)));
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

std::optional<LightRay> LightSampler::emit(float u_light, const vec2& u_position, const vec2& u_direction) const {
  if (empty()) return std::nullopt;
  const std::size_t i = choose(u_light);
  const float chosen = probability_[i];
  if (!(chosen > 0)) return std::nullopt;
  const Light& light = scene_.lights[i];
  const auto id = static_cast<std::uint32_t>(i);

  if (const auto* l = std::get_if<AreaLight>(&light))
    return emit_from_area(emitters_[i], *l, chosen, id, u_position, u_direction);
  if (const auto* l = std::get_if<PointLight>(&light)) {
    const Ray ray{.origin = l->position, .direction = sample_unit_sphere(u_direction)};
    return LightRay{ray,  ray.direction, l->intensity * (4 * pi / chosen), emission_pdf(id, {}, ray.direction, {}), id,
                    true, false};
  }
  if (const auto* l = std::get_if<SpotLight>(&light)) {
    const vec3 direction = Frame::from_normal(l->direction).to_world(sample_cone(u_direction, l->cos_outer));
    const float density = chosen / (2 * pi * (1 - l->cos_outer));
    return LightRay{{.origin = l->position, .direction = direction},
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
  const float density = (directional ? probability_[light] : environment_pdf(-direction)) / area;
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
  return emission_pdf_of(*area_light, probability_[light], emitters_[light].area(), glm::dot(normal, direction));
}

float LightSampler::emission_pdf_over_cosine(std::uint32_t light, const vec3& direction, const vec3& to) const {
  const float chosen = probability_[light];
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
  return (directional ? chosen : environment_pdf(-direction)) / (pi * square(scene_radius_));
}

float LightSampler::direct_pdf(const LightRay& ray, const vec3& to) const {
  if (std::holds_alternative<EnvironmentLight>(scene_.lights[ray.light])) return environment_pdf(-ray.ray.direction);
  if (!std::holds_alternative<AreaLight>(scene_.lights[ray.light])) return probability_[ray.light];
  SurfacePoint point{};
  point.position = ray.ray.origin;
  point.normal = ray.normal;
  point.light = ray.light;
  return pdf(to, -ray.ray.direction, point);
}

}  // namespace etendue
