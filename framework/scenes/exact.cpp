#include "framework/scenes/exact.h"

#include "framework/core/elementary.h"
#include "framework/scenes/builtin_scenes.h"
#include "framework/scenes/exact_stage.h"

namespace etendue {

namespace {

// A diffuse sphere of radius 1 around a point light of 1 W/sr: whatever is not absorbed comes back evenly, because a sphere's
// form factor between any two of its elements is the same ([Cohen1993] 2.10; the integrating sphere).
Scene lambert_sphere(const std::string& name, const dvec3& light, float albedo) {
  const double rho = albedo;
  SceneBuilder b(name);
  b.quadric(Sphere{vec3(0), 1}, b.material(Diffuse{Rgb(albedo)}), std::nullopt, true);
  b.light(PointLight{vec3(light), Rgb(1)});
  b.camera({0.35f, 0.2f, -0.5f}, {-0.3f, -0.1f, 1}, 70, exact_resolution);
  b.closed_form("integrating sphere: L = rho/pi (I cos/d^2 + rho I / (R^2 (1 - rho)))", [light, rho](const Ray& ray) {
    const dvec3 o(ray.origin), d = glm::normalize(dvec3(ray.direction));
    const double along = -glm::dot(o, d);
    const dvec3 point = o + (along + std::sqrt(along * along - glm::dot(o, o) + 1)) * d;
    const dvec3 to_light = light - point;
    const double distance = glm::length(to_light);
    const double direct = glm::dot(-point, to_light) / (distance * distance * distance);
    return dvec3(rho / pi_d * (direct + rho / (1 - rho)));
  });
  return b.finish();
}

// A plane lit by one light that reflects nothing, seen from above: all light on it is direct.
struct DirectSetting {
  SceneBuilder builder;
  std::uint32_t dark;

  explicit DirectSetting(const char* name) : builder(name), dark(builder.material(Diffuse{Rgb(0)})) {
    builder.plane({vec3(0), {0, 1, 0}, builder.material(Diffuse{Rgb(static_cast<float>(rho))})});
    builder.camera({0, 1.2f, 3.2f}, {0, -0.35f, 0}, 38, exact_resolution);
  }

  static constexpr double rho = 0.6;

  Scene finish(const char* source, const std::function<double(const dvec3&)>& irradiance) {
    builder.closed_form(source, [irradiance](const Ray& ray) {
      const dvec3 o(ray.origin), d(ray.direction);
      return dvec3(rho / pi_d * irradiance(o - o.y / d.y * d));
    });
    return builder.finish();
  }
};

}  // namespace

double polygon_irradiance(const dvec3& point, const dvec3& normal, std::span<const dvec3> corners) {
  // [Lambert1760] in the form of [Baum1989] eq. 2: half the sum over edges of angle times the edge plane's normal.
  dvec3 sum(0);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const dvec3 a = glm::normalize(corners[i] - point), b = glm::normalize(corners[(i + 1) % corners.size()] - point);
    const dvec3 cross = glm::cross(a, b);
    const double sine = glm::length(cross);
    if (sine > 0) sum += math::atan2(sine, glm::dot(a, b)) / sine * cross;
  }
  return 0.5 * std::abs(glm::dot(sum, normal));
}

double sphere_irradiance(const dvec3& point, const dvec3& normal, const dvec3& centre, double radius) {
  const dvec3 towards = centre - point;
  const double distance = glm::length(towards);
  return pi_d * radius * radius * glm::dot(towards, normal) / (distance * distance * distance);
}

double disc_irradiance(double distance, double offset, double radius) {
  const double s2 = offset * offset, d2 = distance * distance, a2 = radius * radius;
  const double sum = s2 + d2 + a2;
  return 0.5 * pi_d * (1 - (s2 + d2 - a2) / std::sqrt(sum * sum - 4 * a2 * s2));
}

namespace {

struct ReflectedParams {
  float albedo = 0.5f;
};

template <class Visitor>
void describe(Visitor& v, ReflectedParams& p) {
  v.number("albedo", p.albedo, 0, 0.9999, "1", "of the sphere: light is reflected 1 / (1 - albedo) times on the mean");
}

Scene make_lambert_sphere(const ReflectedParams& params) {  // diffuse sphere, point light at its centre
  return lambert_sphere("builtin:lambert-sphere", dvec3(0), params.albedo);
}

Scene make_lambert_sphere_off_centre() {  // the same, the light off the centre
  return lambert_sphere("builtin:lambert-sphere-off-centre", dvec3(0.2, 0.3, 0.25), 0.5f);
}

Scene make_furnace(const ReflectedParams& params) {  // closed sphere, constant emission and albedo
  constexpr float emitted = 1;
  const float rho = params.albedo;
  SceneBuilder b("builtin:furnace");
  b.quadric(Sphere{vec3(0), 1}, b.material(Diffuse{Rgb(rho)}), Rgb(emitted), true);
  b.camera({0.3f, 0.1f, -0.4f}, {0, 0, 1}, 70, exact_resolution);
  b.closed_form("furnace: L = Le / (1 - rho)", [rho](const Ray&) { return dvec3(emitted / (1.0 - rho)); });
  return b.finish();
}

Scene make_white_furnace() {  // lossless objects in a unit environment
  SceneBuilder b("builtin:white-furnace");
  b.quadric(Sphere{{-1.1f, 0, 0}, 0.5f}, b.material(Dielectric{.eta = 1.5f}));
  b.quadric(Sphere{{0, 0, 0}, 0.5f}, b.material(Diffuse{Rgb(1)}));
  b.quadric(Sphere{{1.1f, 0, 0}, 0.5f}, b.material(Conductor{.ideal = true}));
  b.quadric(Cylinder{{-0.4f, 0.7f, 0}, 0.2f, {1, 0, 0}, 0.8f, true}, b.material(Plastic{.reflectance = Rgb(1)}));
  b.light(EnvironmentLight{});
  b.camera({0, 0.15f, -4}, {0, 0.15f, 0}, 42, exact_resolution);
  b.closed_form("white furnace: lossless surfaces in a unit environment, L = 1", [](const Ray&) { return dvec3(1); });
  return b.finish();
}

Scene make_polygon_light() {  // direct light of a rectangle on a plane
  DirectSetting s("builtin:polygon-light");
  const vec3 a(-0.6f, 1.5f, -0.4f), b(0.6f, 1.5f, -0.4f), c(0.6f, 1.5f, 0.4f), d(-0.6f, 1.5f, 0.4f);
  s.builder.mesh(quad(a, b, c, d), s.dark, Rgb(4));
  return s.finish("polygon: E = L/2 sum theta_i (Gamma_i . n)", [corners = std::vector<dvec3>{a, b, c, d}](const dvec3& p) {
    return 4 * polygon_irradiance(p, {0, 1, 0}, corners);
  });
}

// It is that of a sphere.
Scene make_sphere_light() {
  DirectSetting s("builtin:sphere-light");
  s.builder.quadric(Sphere{{0, 1.7f, 0}, 0.3f}, s.dark, Rgb(10));
  return s.finish("sphere: E = pi L (a/d)^2 cos", [](const dvec3& p) {
    return 10 * sphere_irradiance(p, {0, 1, 0}, dvec3(vec3(0, 1.7f, 0)), 0.3f);
  });
}

Scene make_disc_light() {  // ... of a parallel disc
  DirectSetting s("builtin:disc-light");
  s.builder.quadric(Disk{{0, 1.5f, 0}, 0.5f, {0, -1, 0}}, s.dark, Rgb(6));
  return s.finish("parallel disc", [](const dvec3& p) { return 6 * disc_irradiance(1.5, math::hypot(p.x, p.z), 0.5); });
}

}  // namespace

std::vector<BuiltinScene> exact_scenes() {
  return {with_params<make_lambert_sphere>("lambert-sphere", "exact: diffuse sphere, point light at the centre"),
          {"lambert-sphere-off-centre", "exact: diffuse sphere, point light off the centre", make_lambert_sphere_off_centre},
          with_params<make_furnace>("furnace", "exact: closed sphere that emits and reflects evenly"),
          {"white-furnace", "exact: lossless glass, mirror, plastic and white in a unit environment", make_white_furnace},
          {"polygon-light", "exact: direct light of a rectangle", make_polygon_light},
          {"sphere-light", "exact: direct light of a sphere", make_sphere_light},
          {"disc-light", "exact: direct light of a disc", make_disc_light}};
}

}  // namespace etendue
