#include "integrators/paths/path_choices.h"

#include "framework/transport/ray_tools.h"

#include <algorithm>

namespace etendue {

namespace {

constexpr float much_denser = 4;  // than the densest BSDF sample, 1/pi

// Is there something that light samples can find there?
bool takes_light_samples(const Material& material) {
  const auto* diffuse = std::get_if<Diffuse>(&material);
  if (diffuse) return !diffuse->reflectance.is_constant() || !is_black(diffuse->reflectance.constant);
  return has_non_specular(material);
}

float gap(const Bounds& a, const Bounds& b) {
  return glm::length(glm::max(glm::max(a.lower - b.upper, b.lower - a.upper), vec3(0)));
}

// Between a plane and a box; 0 where they meet.
float gap(const InfinitePlane& plane, const Bounds& box) {
  const float centre = glm::dot(box.centre() - plane.point, plane.normal);
  return std::max(0.0f, std::abs(centre) - 0.5f * glm::dot(box.diagonal(), glm::abs(plane.normal)));
}

// A light that rays can meet, and how far diffuse surfaces must be for its samples to be much denser than theirs.
struct NearLight {
  Bounds bounds;
  float reach;  // m
};

// Is a surface, of which `gap_to(bounds)` is the distance, within reach of a light?
template <class Gap>
bool is_near(const std::vector<NearLight>& lights, const Gap& gap_to) {
  return std::ranges::any_of(lights, [&](const NearLight& light) { return !(gap_to(light.bounds) >= light.reach); });
}

bool any_surface_is_near(const Scene& scene, const std::vector<NearLight>& lights) {
  for (const InfinitePlane& plane : scene.planes)
    if (takes_light_samples(scene.materials[plane.material]) &&
        is_near(lights, [&](const Bounds& box) { return gap(plane, box); }))
      return true;
  for (const Instance& instance : scene.instances) {
    const Object& object = scene.objects[instance.object];
    for (const Shape& shape : object.shapes) {
      if (shape.primitive_count == 0 || !takes_light_samples(scene.materials[shape.material])) continue;
      Bounds bounds;
      for (std::uint32_t i = 0; i < shape.primitive_count; ++i)
        bounds.extend(object.geometry.primitive_bounds(shape.first_primitive + i));
      const Bounds in_world = instance.to_world.bounds(bounds);
      if (is_near(lights, [&](const Bounds& box) { return gap(in_world, box); })) return true;
    }
  }
  return false;
}

// Are light samples everywhere much denser than those of diffuse surfaces? A light's density over solid angle is at least its
// chance over area / distance^2.
bool light_samples_are_dense(const RenderContext& context) {
  const Scene& scene = context.scene;
  if (context.needs.glossy || context.needs.environment || context.lights.choice() != LightChoice::power) return false;
  std::vector<NearLight> lights;
  for (std::uint32_t i = 0; i < scene.lights.size(); ++i) {
    const auto* light = std::get_if<AreaLight>(&scene.lights[i]);
    const float chance = context.lights.choice_probability(vec3(0), i);
    if (light && chance > 0)
      lights.push_back({scene.objects[0].geometry.primitive_bounds(light->primitive),
                        std::sqrt(much_denser * inv_pi * AreaEmitter(scene, *light).area() / chance)});
  }
  return !any_surface_is_near(scene, lights);
}

// Mean luminance of pixels over the standard deviation of a path within them, from pairs of paths in pixels all over the image;
// 0 where they bring no light.
float evenness_of(const RenderContext& context, const PathSettings& settings, bool count_emission) {
  constexpr int side = 8;
  constexpr std::uint32_t first_index = 1u << 30;  // numbers of no image's paths
  std::vector<PathSample> paths;
  for (int i = 0; i < side * side; ++i) {
    const ivec2 pixel = (2 * ivec2(i % side, i / side) + 1) * context.resolution / (2 * side);
    for (std::uint32_t s = 0; s < 2; ++s)
      paths.push_back(camera_path(context, pixel, SamplerKind::independent, first_index + s));
  }
  trace_paths(context, paths, 0, settings, count_emission);
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < paths.size(); i += 2) {
    const double a = luminance(paths[i].radiance), b = luminance(paths[i + 1].radiance);
    sum += 0.5 * (a + b);
    squares += 0.5 * square(a - b);
  }
  constexpr double rounding = 1e-7;
  const double mean = sum / square(side), deviation = std::sqrt(squares / square(side));
  return mean > 0 ? static_cast<float>(mean / std::max(deviation, rounding * mean)) : 0;
}

// Do BSDF samples alone bring the same direct light wherever they go? Asked of one light that has the same radiance everywhere,
// as few paths may all miss another or its brightest part, and where every surface scatters, so that paths ask at what they see.
bool bsdf_samples_are_exact(const RenderContext& context) {
  constexpr float exact = 1000;
  const Scene& scene = context.scene;
  const auto* light = scene.lights.size() == 1 ? std::get_if<AreaLight>(&scene.lights[0]) : nullptr;
  if (!light || light->texture != no_id || context.needs.masks) return false;
  return std::ranges::all_of(scene.materials, [](const Material& m) { return has_non_specular(m); }) &&
         evenness_of(context, {.max_depth = 1, .roulette_depth = 2, .mis = MisMode::bsdf}, false) > exact;
}

}  // namespace

MisChoice choose_mis(const RenderContext& context) {
  const auto can_be_met = [](const Light& light) { return !is_delta(light); };
  if (context.lights.empty() || std::ranges::none_of(context.scene.lights, can_be_met))
    return {MisMode::power, "no ray can meet a light"};
  if (context.lights.only_even()) return {MisMode::bsdf, "light comes evenly from all directions"};
  if (bsdf_samples_are_exact(context)) return {MisMode::bsdf, "the light looks the same in all directions"};
  if (light_samples_are_dense(context)) return {MisMode::light, "lights are small from every diffuse surface"};
  return {MisMode::power, "BSDF samples find some lights as well as light samples do"};
}

float roulette_evenness(const RenderContext& context, const PathSettings& settings) {
  // First by paths that end as usual, which take little time and scatter more.
  if (!(evenness_of(context, settings, true) >= 0.6f * least_evenness)) return 1;
  PathSettings whole = settings;
  whole.roulette_depth = whole.max_depth + 1;
  const float evenness = evenness_of(context, whole, true);
  return evenness >= least_evenness ? evenness : 1;
}

}  // namespace etendue
