// Exact scenes of light that reaches a diffuse floor by way of a specular surface, which the camera may look through as well.
#include "framework/core/elementary.h"
#include "framework/scenes/builtin_scenes.h"
#include "framework/scenes/exact.h"
#include "framework/scenes/exact_stage.h"

namespace etendue {

namespace {

double point_irradiance(const dvec3& to_light, const dvec3& normal) {
  const double distance = glm::length(to_light);
  return glm::dot(to_light, normal) / (distance * distance * distance);
}

// Unpolarised Fresnel transmission in double precision; 0 at total internal reflection.
double transmission(double cos_in, double eta) {
  const double sin2 = (1 - cos_in * cos_in) / (eta * eta);
  if (sin2 >= 1) return 0;
  const double cos_t = std::sqrt(1 - sin2);
  const double parallel = (eta * cos_in - cos_t) / (eta * cos_in + cos_t);
  const double perpendicular = (cos_in - eta * cos_t) / (cos_in + eta * cos_t);
  return 1 - 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

// The water and its light.
constexpr double water_eta = 1.33f, water_depth = 1, light_height = 0.8, light_watts_per_sr = 8, pool_albedo = 0.7, extent = 4;

dvec3 floor_radiance(const dvec3& origin, const dvec3& direction) {
  if (direction.y >= 0) return dvec3(0);
  const dvec3 p = origin - (origin.y + water_depth) / direction.y * direction;
  if (std::max(std::abs(p.x), std::abs(p.z)) > extent) return dvec3(0);
  const double irradiance =
      light_watts_per_sr * refracted_irradiance(math::hypot(p.x, p.z), light_height, water_depth, water_eta);
  return pool_albedo / pi_d * irradiance * dvec3(0.75, 0.95, 1);
}

dvec3 radiance_above(const Ray& ray) {
  const dvec3 o(ray.origin), d = glm::normalize(dvec3(ray.direction));
  if (d.y >= 0) return dvec3(0);
  const dvec3 surface = o - o.y / d.y * d;
  if (std::max(std::abs(surface.x), std::abs(surface.z)) > extent) return dvec3(0);
  dvec3 inside = d / water_eta;
  inside.y = -std::sqrt(1 - inside.x * inside.x - inside.z * inside.z);
  return transmission(-d.y, water_eta) / (water_eta * water_eta) * floor_radiance(surface, inside);
}

// Looking up, the camera sees the floor mirrored in the surface, and nothing through it.
dvec3 radiance_below(const Ray& ray) {
  const dvec3 o(ray.origin), d = glm::normalize(dvec3(ray.direction));
  if (d.y <= 0) return floor_radiance(o, d);
  const dvec3 surface = o - o.y / d.y * d;
  if (std::max(std::abs(surface.x), std::abs(surface.z)) > extent) return dvec3(0);
  return (1 - transmission(d.y, 1 / water_eta)) * floor_radiance(surface, {d.x, -d.y, d.z});
}

}  // namespace

double refracted_irradiance(double x, double height, double depth, double eta) {
  // x = h tan(theta) + d tan(theta_t), monotonous in the angle of incidence: bisection, in the tangent.
  const auto reach = [&](double tangent) {
    const double sine_t = tangent / std::sqrt(1 + tangent * tangent) / eta;
    return height * tangent + depth * sine_t / std::sqrt(1 - sine_t * sine_t);
  };
  double low = 0, high = x / height;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (reach(middle) < x ? low : high) = middle;
  }
  const double tangent = 0.5 * (low + high), cosine = 1 / std::sqrt(1 + tangent * tangent);
  const double cosine_t = std::sqrt(1 - (1 - cosine * cosine) / (eta * eta));
  const double slope = height / (cosine * cosine) + depth * cosine / (eta * cosine_t * cosine_t * cosine_t);
  // The flux of a ring of directions falls on a ring of the floor: E = I T sin(theta) dtheta / (x dx).
  const double x_over_sine = height / cosine + depth / (eta * cosine_t);
  return transmission(cosine, eta) / (x_over_sine * slope);
}

namespace {

struct MirrorParams {
  std::string view = "floor";
};

template <class Visitor>
void describe(Visitor& v, MirrorParams& p) {
  v.choice("view", p.view, {"floor", "mirror", "both"}, "what fills the image: mirror, the floor seen in the mirror alone");
}

// A point light before a vertical mirror on a diffuse floor. No light comes back to the floor: what it reflects goes up, and a
// vertical mirror sends it up.
Scene make_mirror(const MirrorParams& params) {
  constexpr double rho = 0.6, watts_per_sr = 2;
  constexpr float reflectance = 0.9f, mirror_z = -1.2f;
  const vec3 light(0.45f, 0.7f, -0.35f), image(light.x, light.y, 2 * mirror_z - light.z);
  const auto floor_radiance = [=](const dvec3& p) {
    const dvec3 up(0, 1, 0);
    const double irradiance = point_irradiance(dvec3(light) - p, up) + reflectance * point_irradiance(dvec3(image) - p, up);
    return rho / pi_d * watts_per_sr * irradiance * dvec3(1, 0.9, 0.75);
  };
  ExactStage s("builtin:mirror");
  const auto albedo = Rgb(static_cast<float>(rho)) * Rgb(1, 0.9f, 0.75f);
  s.reflector(quad({-3, 0, 3}, {3, 0, 3}, {3, 0, mirror_z}, {-3, 0, mirror_z}), s.builder.material(Diffuse{albedo}),
              floor_radiance);
  s.mirror(quad({-3, 0, mirror_z}, {3, 0, mirror_z}, {3, 2, mirror_z}, {-3, 2, mirror_z}), reflectance);
  s.builder.light(PointLight{light, Rgb(static_cast<float>(watts_per_sr))});
  if (params.view == "mirror")
    s.builder.camera({-0.3f, 1.5f, 0.3f}, {0.1f, 0.85f, mirror_z}, 28, exact_resolution);
  else if (params.view == "both")
    s.builder.camera({-1.1f, 1.1f, 2.4f}, {0, 0.15f, -0.6f}, 42, exact_resolution);
  else
    s.builder.camera({-0.3f, 1.9f, 1.3f}, {0.25f, 0, 0.2f}, 34, exact_resolution);
  return s.finish("flat mirror: E = I cos/d^2 + R I cos'/d'^2 from the image of the light");
}

struct WaterParams {
  std::string camera = "below";
};

template <class Visitor>
void describe(Visitor& v, WaterParams& p) {
  v.choice("camera", p.camera, {"below", "above"}, "of the surface; above, each path to the floor is refracted twice");
}

// A point light above a flat water surface and a diffuse floor below it. Paths end at three events, before the floor lights
// itself by way of the surface.
Scene make_water(const WaterParams& params) {
  SceneBuilder b("builtin:water");
  const auto e = static_cast<float>(extent), floor = -static_cast<float>(water_depth);
  b.mesh(quad({-e, floor, e}, {e, floor, e}, {e, floor, -e}, {-e, floor, -e}),
         b.material(Diffuse{Rgb(0.75f, 0.95f, 1) * static_cast<float>(pool_albedo)}));
  b.mesh(quad({-e, 0, e}, {e, 0, e}, {e, 0, -e}, {-e, 0, -e}), b.material(Dielectric{.eta = static_cast<float>(water_eta)}));
  b.light(PointLight{{0, static_cast<float>(light_height), 0}, Rgb(static_cast<float>(light_watts_per_sr))});
  b.max_depth(3);
  const bool above = params.camera == "above";
  if (above)
    b.camera({0.3f, 1.3f, 2.2f}, {0, -0.6f, -0.1f}, 50, exact_resolution);
  else
    b.camera({0.2f, -0.2f, 1.7f}, {0, -1, 0.5f}, 44, exact_resolution);
  b.closed_form("water surface: E = I T sin(theta) / (x dx/dtheta)", above ? radiance_above : radiance_below);
  return b.finish();
}

}  // namespace

std::vector<BuiltinScene> specular_scenes() {
  return {with_params<make_mirror>("mirror", "exact: point light, mirror and diffuse floor"),
          with_params<make_water>("water", "exact: point light above water, diffuse floor below")};
}

}  // namespace etendue
