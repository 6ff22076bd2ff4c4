// Exact scenes of spherical cavities: a sphere's form factor between any two of its elements is the same.
#include "framework/scenes/builtin_scenes.h"
#include "framework/scenes/exact_stage.h"

namespace etendue {

namespace {

struct CavityParams {
  float opening = 0.1f;
};

template <class Visitor>
void describe(Visitor& v, CavityParams& p) {
  v.number("opening", p.opening, 0.001, 0.6, "of the sphere's area", "the cap removed; 0.5: a hemisphere");
}

// A sphere without a cap in a unit environment, seen from inside. What comes through the opening comes through its rim's disc,
// so a disc of radiance 1 stands for the environment.
Scene make_cavity(const CavityParams& params) {
  const Rgb albedo(0.8f, 0.65f, 0.5f);
  const float height = 1 - 2 * params.opening;  // of the rim above the centre of the unit sphere
  SceneBuilder b("builtin:cavity");
  b.quadric(Sphere{vec3(0), 1}, b.material(Diffuse{albedo}), std::nullopt, true);
  b.quadric(Disk{{0, height, 0}, safe_sqrt(1 - height * height), {0, -1, 0}}, b.material(Diffuse{Rgb(0)}), Rgb(1));
  b.camera({0.3f, -0.5f, 0.65f}, {-0.05f, -0.02f, -0.5f}, 75, exact_resolution);
  // [Cohen1993] 2.10: every wall element gets the same, M = rho (f pi + (1 - f) M).
  const double f = params.opening;
  const dvec3 rho(albedo), wall = rho * f / (1.0 - rho * (1 - f));
  b.closed_form("spherical cavity: L = rho f / (1 - rho (1 - f))", [wall, height](const Ray& ray) {
    const double t = (height - ray.origin.y) / ray.direction.y;
    const dvec3 p = dvec3(ray.origin) + t * dvec3(ray.direction);
    return t > 0 && p.x * p.x + p.z * p.z < 1 - double(height) * height ? dvec3(1) : wall;
  });
  return b.finish();
}

// A glowing sphere inside a glowing sphere, both diffuse.
Scene make_concentric_spheres() {
  constexpr float inner_radius = 0.4f;
  const Rgb inner_albedo(0.2f, 0.4f, 0.6f), outer_albedo(0.7f, 0.6f, 0.5f);
  const Rgb inner_emitted(1, 0.6f, 0.25f), outer_emitted(0.02f, 0.05f, 0.12f);
  SceneBuilder b("builtin:concentric-spheres");
  b.quadric(Sphere{vec3(0), inner_radius}, b.material(Diffuse{inner_albedo}), inner_emitted);
  b.quadric(Sphere{vec3(0), 1}, b.material(Diffuse{outer_albedo}), outer_emitted, true);
  b.camera({0.1f, 0.25f, -0.85f}, {0, 0, 0}, 70, exact_resolution);
  // L1 = M1 + rho1 L2; L2 = M2 + rho2 (F L1 + (1 - F) L2), F = (r1/r2)^2, in radiances ([Cohen1993] 2.10).
  const double seen = double(inner_radius) * inner_radius;
  const dvec3 rho1(inner_albedo), rho2(outer_albedo), emitted1(inner_emitted), emitted2(outer_emitted);
  const dvec3 outer = (emitted2 + rho2 * seen * emitted1) / (1.0 - rho2 * (seen * rho1 + (1 - seen)));
  const dvec3 inner = emitted1 + rho1 * outer;
  b.closed_form("concentric spheres: two equations", [inner, outer, seen](const Ray& ray) {
    const dvec3 o(ray.origin), d = glm::normalize(dvec3(ray.direction));
    const double along = -glm::dot(o, d), nearest2 = glm::dot(o, o) - along * along;
    return along > 0 && nearest2 < seen ? inner : outer;
  });
  return b.finish();
}

}  // namespace

std::vector<BuiltinScene> cavity_scenes() {
  return {with_params<make_cavity>("cavity", "exact: spherical cavity with an opening to a unit environment"),
          {"concentric-spheres", "exact: a glowing sphere in a glowing sphere", make_concentric_spheres}};
}

}  // namespace etendue
