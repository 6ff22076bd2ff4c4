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

// Boxes about the shapes at which light samples are taken.
std::vector<Bounds> receivers(const Scene& scene) {
  std::vector<Bounds> boxes;
  for (const Instance& instance : scene.instances) {
    const Object& object = scene.objects[instance.object];
    for (const Shape& shape : object.shapes) {
      if (shape.primitive_count == 0 || !takes_light_samples(scene.materials[shape.material])) continue;
      Bounds bounds;
      for (std::uint32_t i = 0; i < shape.primitive_count; ++i)
        bounds.extend(object.geometry.primitive_bounds(shape.first_primitive + i));
      boxes.push_back(instance.to_world.bounds(bounds));
    }
  }
  return boxes;
}

bool receives(const Scene& scene, const InfinitePlane& plane) { return takes_light_samples(scene.materials[plane.material]); }

bool any_surface_is_near(const Scene& scene, const std::vector<NearLight>& lights) {
  for (const InfinitePlane& plane : scene.planes)
    if (receives(scene, plane) && is_near(lights, [&](const Bounds& box) { return gap(plane, box); })) return true;
  return std::ranges::any_of(receivers(scene), [&](const Bounds& surface) {
    return is_near(lights, [&](const Bounds& box) { return gap(surface, box); });
  });
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
// 0 where less than this share of them bring light: a few pairs may agree by chance.
float evenness_of(const RenderContext& context, const PathSettings& settings, bool count_emission, double least_lit) {
  constexpr int side = 8;
  std::vector<PathSample> paths;
  for (int i = 0; i < side * side; ++i) {
    const ivec2 pixel = grid_pixel(context.resolution, side, i);
    for (std::uint32_t s = 0; s < 2; ++s)
      paths.push_back(camera_path(context, pixel, SamplerKind::independent, no_images_path + s));
  }
  trace_paths(context, paths, 0, settings, count_emission);
  double sum = 0, squares = 0, lit = 0;
  for (std::size_t i = 0; i < paths.size(); i += 2) {
    const double a = luminance(paths[i].radiance), b = luminance(paths[i + 1].radiance);
    sum += 0.5 * (a + b);
    squares += 0.5 * square(a - b);
    lit += a > 0 || b > 0;
  }
  if (lit < least_lit * square(side)) return 0;
  constexpr double rounding = 1e-7;
  const double mean = sum / square(side), deviation = std::sqrt(squares / square(side));
  return mean > 0 ? static_cast<float>(mean / std::max(deviation, rounding * mean)) : 0;
}

// Do BSDF samples alone bring the same direct light wherever they go? Asked of one light that has the same radiance everywhere,
// as few paths may all miss another or its brightest part, and where every surface scatters, so that paths ask at what they
// see.
bool bsdf_samples_are_exact(const RenderContext& context) {
  constexpr float exact = 1000;
  const Scene& scene = context.scene;
  const auto* light = scene.lights.size() == 1 ? std::get_if<AreaLight>(&scene.lights[0]) : nullptr;
  if (!light || light->texture != no_id || context.needs.masks) return false;
  return std::ranges::all_of(scene.materials, [](const Material& m) { return has_non_specular(m); }) &&
         evenness_of(context, {.max_depth = 1, .roulette_depth = 2, .mis = MisMode::bsdf}, false, 0.5) > exact;
}

// A pane is one triangle, or two side by side in a plane, of delta lobes alone: shadow rays end there.
struct Pane {
  std::vector<vec3> corners;  // in turn about the normal
  vec3 normal{0};             // unit

  // Gives none where the shape is something else. `flat`: metres off a plane that do not matter.
  static std::optional<Pane> of(const Scene& scene, const Shape& shape, float flat) {
    const Geometry& geometry = scene.objects[0].geometry;
    const std::uint32_t first = shape.first_primitive, count = shape.primitive_count;
    if (count < 1 || count > 2 || !geometry.is_triangle(first + count - 1) || has_non_specular(scene.materials[shape.material]))
      return std::nullopt;
    uvec3 a = geometry.triangles[first];
    const auto corner_of = [](std::uint32_t v, const uvec3& t) { return v == t.x || v == t.y || v == t.z; };
    if (count == 1) return Pane(geometry.positions, {a.x, a.y, a.z});
    const uvec3 b = geometry.triangles[first + 1];
    for (int turn = 0; turn < 2 && corner_of(a.x, b); ++turn) a = {a.y, a.z, a.x};
    const std::uint32_t other = !corner_of(b.x, a) ? b.x : !corner_of(b.y, a) ? b.y : b.z;
    if (corner_of(a.x, b) || !corner_of(a.y, b) || !corner_of(a.z, b)) return std::nullopt;
    Pane pane(geometry.positions, {a.x, a.y, other, a.z});
    const vec3 beyond = pane.corners[2] - pane.corners[1];
    const bool beside = glm::dot(glm::cross(pane.normal, pane.corners[3] - pane.corners[1]), beyond) < 0;
    return beside && std::abs(glm::dot(beyond, pane.normal)) <= flat ? std::optional(pane) : std::nullopt;
  }
  // Is it on every way between points of two convex bodies, given by their corners, at least `margin` (metres) from the ways'
  // ends and within its own border? Where a way meets its plane is a mean of where the ways between corners do, with weights
  // that are not negative: those are tried.
  bool separates(std::span<const vec3> corners_a, std::span<const vec3> corners_b, float margin) const {
    for (const vec3& p : corners_a)
      for (const vec3& q : corners_b) {
        const float from = height(p), to = height(q);
        if (!(std::min(std::abs(from), std::abs(to)) > margin && from * to < 0)) return false;
        if (!holds(p + from / (from - to) * (q - p), margin)) return false;
      }
    return true;
  }

 private:
  Pane(const std::vector<vec3>& positions, std::initializer_list<std::uint32_t> which) {
    for (const std::uint32_t i : which) corners.push_back(positions[i]);
    normal = glm::normalize(glm::cross(corners[1] - corners[0], corners.back() - corners[0]));
  }
  float height(const vec3& p) const { return glm::dot(p - corners[0], normal); }
  bool holds(const vec3& p, float margin) const {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const vec3 edge = corners[(i + 1) % corners.size()] - corners[i];
      if (!(glm::dot(glm::cross(normal, edge), p - corners[i]) > margin * glm::length(edge))) return false;
    }
    return true;
  }
};

std::vector<vec3> corners_of(const Bounds& box) {
  std::vector<vec3> corners;
  for (int i = 0; i < 8; ++i) corners.push_back(glm::mix(box.lower, box.upper, vec3(i & 1, i >> 1 & 1, i >> 2)));
  return corners;
}

std::vector<vec3> corners_of(const Geometry& geometry, const AreaLight& light) {
  if (!geometry.is_triangle(light.primitive)) return corners_of(geometry.primitive_bounds(light.primitive));
  const uvec3 v = geometry.triangles[light.primitive];
  return {geometry.positions[v.x], geometry.positions[v.y], geometry.positions[v.z]};
}

// A sphere without a non-specular lobe, which parts what is within it from what is without.
struct Shell {
  Sphere sphere;

  // Are all boxes on one side of it and the light on the other, at least `margin` (metres) off?
  bool separates(std::span<const Bounds> boxes, const Geometry& geometry, const AreaLight& light, float margin) const {
    const auto least = [&](const Bounds& b) {
      return glm::length(glm::max(glm::max(b.lower - sphere.centre, sphere.centre - b.upper), vec3(0)));
    };
    const auto most = [&](const Bounds& b) {
      return glm::length(glm::max(glm::abs(b.lower - sphere.centre), glm::abs(b.upper - sphere.centre)));
    };
    const Bounds lamp = geometry.primitive_bounds(light.primitive);
    float nearest = least(lamp), farthest = most(lamp);
    if (!geometry.is_triangle(light.primitive))  // the box of a spherical lamp about the shell holds its centre
      if (const auto* ball = std::get_if<Sphere>(&geometry.quadric(light.primitive))) {
        const float apart = glm::length(ball->centre - sphere.centre);
        nearest = std::abs(apart - ball->radius);
        farthest = apart + ball->radius;
      }
    const float inner = sphere.radius - margin, outer = sphere.radius + margin;
    return (nearest > outer && std::ranges::all_of(boxes, [&](const Bounds& b) { return most(b) < inner; })) ||
           (farthest < inner && std::ranges::all_of(boxes, [&](const Bounds& b) { return least(b) > outer; }));
  }
};

std::vector<Shell> shells_of(const Scene& scene) {
  std::vector<Shell> shells;
  const Geometry& geometry = scene.objects[0].geometry;
  for (const Shape& shape : scene.objects[0].shapes)
    for (std::uint32_t id = shape.first_primitive; id < shape.first_primitive + shape.primitive_count; ++id)
      if (!geometry.is_triangle(id) && !has_non_specular(scene.materials[shape.material]))
        if (const auto* sphere = std::get_if<Sphere>(&geometry.quadric(id))) shells.push_back({*sphere});
  return shells;
}

// Does a pane or a shell stand between each light that rays can meet and all that takes light samples? What none is proved to
// hide is sampled: a few rays cannot tell, and a light that they miss would be lost.
bool panes_hide_lights(const RenderContext& context) {
  constexpr std::size_t most_pairs = 100'000;  // of a pane and a light, which take a tenth of a second; more are not tried
  constexpr float least_margin = 1e-4f;        // of the scene's extent: far above what rounding moves rays by
  const Scene& scene = context.scene;
  const float margin = least_margin * glm::length(context.bounds.diagonal());
  std::vector<Pane> panes;
  for (const Shape& shape : scene.objects[0].shapes)
    if (auto pane = Pane::of(scene, shape, 0.01f * margin)) panes.push_back(std::move(*pane));
  const std::vector<Shell> shells = shells_of(scene);
  const bool too_many = (panes.size() + shells.size()) * scene.lights.size() > most_pairs;
  if ((panes.empty() && shells.empty()) || too_many || context.needs.masks ||
      std::ranges::any_of(scene.planes, [&](const InfinitePlane& plane) { return receives(scene, plane); }))
    return false;
  Bounds lit;
  const std::vector<Bounds> boxes = receivers(scene);
  for (const Bounds& box : boxes) lit.extend(box);
  if (lit.empty()) return false;
  const std::vector<vec3> lit_corners = corners_of(lit);
  return std::ranges::all_of(scene.lights, [&](const Light& light) {
    const auto* area = std::get_if<AreaLight>(&light);
    if (!area) return is_delta(light);
    const std::vector<vec3> corners = corners_of(scene.objects[0].geometry, *area);
    return std::ranges::any_of(panes, [&](const Pane& pane) { return pane.separates(lit_corners, corners, margin); }) ||
           std::ranges::any_of(
               shells, [&](const Shell& shell) { return shell.separates(boxes, scene.objects[0].geometry, *area, margin); });
  });
}

// Emission that a BSDF sample meets from the first surface that a camera path gets to by delta lobes, if it is diffuse, coated
// or not.
struct MetEmission {
  float radiance;             // of its brightest channel, as that surface reflects it
  float pdf_bsdf, pdf_light;  // per solid angle, of finding it by either kind of sample
};
std::optional<MetEmission> met_from_surface_seen(const RenderContext& context, PathSample path) {
  constexpr int most_delta_lobes = 8;
  Ray ray = path.ray;
  BsdfSample next;
  for (int i = 0; i < most_delta_lobes && (i == 0 || next.specular); ++i) {
    const Hit hit = trace(context, ray);
    if (!hit) return std::nullopt;
    const SurfacePoint point = context.scene.surface_at(ray, hit);
    const Bsdf bsdf(context.scene, point);
    if (!bsdf.is_diffuse() && !bsdf.has_specular()) return std::nullopt;
    const float u_lobe = path.sampler.get_1d();
    next = bsdf.sample(-ray.direction, u_lobe, path.sampler.get_2d());
    if (!next) return std::nullopt;
    ray = spawn_ray(point, next.wi);
  }
  if (next.specular) return std::nullopt;
  const Hit hit = trace(context, ray);
  const auto met = hit ? std::optional(context.scene.surface_at(ray, hit)) : std::nullopt;
  const Rgb emitted = met ? context.lights.emitted(*met, -ray.direction) : context.lights.environment(ray.direction);
  if (is_black(emitted)) return std::nullopt;
  const float pdf_light =
      met ? context.lights.pdf(ray.origin, ray.direction, *met) : context.lights.environment_pdf(ray.direction);
  return MetEmission{max_component(next.weight * emitted), next.pdf_solid_angle, std::max(pdf_light, 1e-30f)};
}

bool can_be_met(const Light& light) { return !is_delta(light); }

}  // namespace

MisChoice choose_mis(const RenderContext& context) {
  if (context.lights.empty() || std::ranges::none_of(context.scene.lights, can_be_met))
    return {MisMode::power, "no ray can meet a light"};
  if (context.lights.only_even()) return {MisMode::bsdf, "light comes evenly from all directions"};
  if (bsdf_samples_are_exact(context)) return {MisMode::bsdf, "the light looks the same in all directions"};
  if (panes_hide_lights(context)) return {MisMode::bsdf, "specular surfaces hide all lights from light samples"};
  if (light_samples_are_dense(context)) return {MisMode::light, "lights are small from every diffuse surface"};
  return {MisMode::power, "BSDF samples find some lights as well as light samples do"};
}

MisMode choose_direct(const RenderContext& context) {
  constexpr int side = 16, tries = 4;
  constexpr double least_gain = 1.15;  // most scenes have below 1.02, those of close lamps 2 and more
  if (std::ranges::none_of(context.scene.lights, can_be_met)) return MisMode::light;
  std::vector<std::optional<MetEmission>> found(side * side * tries);
  parallel_for(found.size(), 64, [&](std::size_t n) {
    const ivec2 pixel = grid_pixel(context.resolution, side, static_cast<int>(n) / tries);
    const auto index = no_images_path + static_cast<std::uint32_t>(n);
    found[n] = met_from_surface_seen(context, camera_path(context, pixel, SamplerKind::independent, index));
  });
  double by_light = 0, by_both = 0;
  for (const auto& met : found) {
    if (!met) continue;
    const double square_of_met = square(met->radiance), denser = met->pdf_bsdf / met->pdf_light;
    const double weight = mis_weight(MisMode::power, met->pdf_light, met->pdf_bsdf);
    by_light += square_of_met * denser;
    by_both += square_of_met * (square(weight) * denser + square(1 - weight));
  }
  return by_light > least_gain * by_both ? MisMode::power : MisMode::light;
}

float roulette_evenness(const RenderContext& context, const PathSettings& settings) {
  // First by paths that end as usual, which take little time and scatter more.
  if (!(evenness_of(context, settings, true, 0) >= 0.6f * least_evenness)) return 1;
  PathSettings whole = settings;
  whole.roulette_depth = whole.max_depth + 1;
  const float evenness = evenness_of(context, whole, true, 0);
  return evenness >= least_evenness ? evenness : 1;
}

bool is_smooth(const RenderContext& context, double deviation) {
  const auto is_diffuse = [](const Material& m) {
    return std::holds_alternative<Diffuse>(m) || std::holds_alternative<DiffuseTransmission>(m);
  };
  return std::ranges::all_of(context.scene.materials, is_diffuse) && !context.needs.masks &&
         evenness_of(context, {.max_depth = 1}, true, 0) * deviation >= 1;
}

}  // namespace etendue
