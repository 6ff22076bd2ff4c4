#include "integrators/warnings/seldom_lights.h"

#include "framework/core/units.h"
#include "framework/transport/direct_light.h"
#include "integrators/warnings/seen_pixels.h"

#include <algorithm>
#include <array>

namespace etendue {

namespace {

// Light samples, of which one finds the light there is: as many leave nothing of it in a calm image.
constexpr double too_many_samples = 1 << 14;
constexpr std::size_t most_asked = 64;  // lights of a point; of more, as many evenly

bool may_be_seldom(const LightSampler& lights, std::size_t count) {
  if (count < 2 || lights.empty() || lights.choice() == LightChoice::uniform) return false;
  if (lights.choice() == LightChoice::tree) return true;
  for (std::uint32_t i = 0; i < count; ++i)
    if (const float p = lights.choice_probability(vec3(0), i); p < 1 / too_many_samples) return true;
  return false;
}

// Holds what one sample of direct light at a point would find, by all lights.
struct SampledLight {
  double mean = 0, square = 0;

  void add(double contribution, double chance) {
    mean += contribution;
    square += contribution * contribution / std::max(chance, 1e-30);
  }
  // A single sample has this variance: so many make the error as large as the mean.
  double relative_variance() const { return mean > 0 ? square / (mean * mean) : 0; }
};

// `all` samples every light alike. `by_both`: samples of the BSDF find lights as well.
SampledLight sampled_light(const RenderContext& context, const LightSampler& all, const SurfacePoint& point, const vec3& wo,
                           bool by_both, std::uint64_t key) {
  const Bsdf bsdf(context.scene, point);
  const vec3 from = ray_origin(point, wo);
  const std::size_t count = std::min(most_asked, context.scene.lights.size());
  SampledLight found;
  for (std::size_t i = 0; i < count; ++i) {
    Pcg32 random(hash_keys(key, i), 1);
    const float u_light = (static_cast<float>(i) + 0.5f) / static_cast<float>(count);
    const vec2 u(random.next_float(), random.next_float());
    const auto light = all.sample(from, u_light, u);
    if (!light) continue;
    const Rgb scattered = bsdf.evaluate(wo, light->wi);
    if (is_black(scattered) || !unoccluded(context, shadow_ray(point, *light))) continue;
    // The light stands for a group, and this is the chance of all of it.
    const double group = all.choice_probability(from, light->light) * static_cast<double>(count);
    double chance = context.lights.choice_probability(from, light->light) / group;
    if (by_both && !light->delta) chance += bsdf.pdf(wo, light->wi) * group / (light->pdf_solid_angle * count);
    found.add(luminance(scattered * light->radiance) / (light->pdf_solid_angle * static_cast<double>(count)), chance);
  }
  return found;
}

}  // namespace

std::string lights_seldom_chosen(const RenderContext& context, const std::string& method) {
  constexpr std::array by_both{"path", "guided", "bdpt", "vcm"};
  if (method == "light-trace" || !may_be_seldom(context.lights, context.scene.lights.size())) return "";
  LightSampler all(context.scene);
  all.choose_by(LightChoice::uniform);
  const bool finds_both = std::ranges::find(by_both, method) != by_both.end();
  const double share = share_of_pixels(context, [&](const Ray& ray, std::size_t pixel) {
    const Hit seen = trace(context, ray);
    if (!seen) return false;
    const SurfacePoint point = context.scene.surface_at(ray, seen);
    if (!has_non_specular(context.scene.materials[point.material])) return false;
    return sampled_light(context, all, point, -ray.direction, finds_both, pixel).relative_variance() > too_many_samples;
  });
  if (share < fewest_pixels) return "";
  return fmt::format(
      "direct light on {} of what is seen comes from lights that less than one light sample in {:.0f} chooses, since others "
      "have so much more power: {} leaves it noisy, or out; lights = \"uniform\" brings it",
      format_percent(share), too_many_samples, method);
}

}  // namespace etendue
