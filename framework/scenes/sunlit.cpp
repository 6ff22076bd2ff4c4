// Exact scenes in the sun, each with a length on which a density estimate, or the precision of floats, depends.
#include "framework/scenes/builtin_scenes.h"
#include "framework/scenes/exact_stage.h"

namespace etendue {

namespace {

const Rgb chalk(0.8f, 0.78f, 0.72f);
constexpr float noon_irradiance = 4;  // facing it

MeshData ground(float height, float half) {
  return quad({-half, height, half}, {half, height, half}, {half, height, -half}, {-half, height, -half});
}

dvec3 chalk_radiance(double cosine) { return dvec3(chalk) * (noon_irradiance * std::max(0.0, cosine) / pi_d); }

struct SunlitFieldParams : VeilParams {
  float surroundings = 1;
};

template <class Visitor>
void describe(Visitor& v, SunlitFieldParams& p) {
  v.number("surroundings", p.surroundings, 1, 1e4, "of 2 m",
           "width of the field, of which the camera sees the middle: photons per area fall with its square");
  describe(v, static_cast<VeilParams&>(p));
}

// Even light as far as the camera sees, so that a density estimate of n photons has a variance of 1 / n and no bias.
Scene make_sunlit_field(const SunlitFieldParams& params) {
  ExactStage s("builtin:sunlit-field");
  s.reflector(ground(0, params.surroundings), s.builder.material(Diffuse{chalk}),
              [](const dvec3&) { return chalk_radiance(1); });
  if (params.veil) s.veil(ground(1.5f, params.surroundings));
  s.builder.light(DirectionalLight{{0, -1, 0}, Rgb(noon_irradiance)});
  s.builder.camera({0, 1.2f, 0.5f}, {0, 0, 0}, 40, exact_resolution);
  return s.finish("even light: L = rho E / pi");
}

struct SunlitBallParams : VeilParams {
  float radius = 1;
};

template <class Visitor>
void describe(Visitor& v, SunlitBallParams& p) {
  v.number("radius", p.radius, 1e-3, 1e3, "m", "of the ball; the image is the same at any");
  describe(v, static_cast<VeilParams&>(p));
}

// A kernel of radius r cuts a cap of area pi r^2 out of the ball, whose mean cosine to the sun is 1 - (r / 2R)^2 of that in its
// middle: so much light a box kernel finds of what there is, as long as the sun reaches the whole cap.
Scene make_sunlit_ball(const SunlitBallParams& params) {
  const float r = params.radius;
  SceneBuilder b("builtin:sunlit-ball");
  b.quadric(Sphere{vec3(0), r}, b.material(Diffuse{chalk}));
  if (params.veil) b.mesh(ground(1.5f * r, 1.1f * r), b.material(Dielectric{.eta = 1}));
  b.light(DirectionalLight{{0, -1, 0}, Rgb(noon_irradiance)});
  b.camera({0.6f * r, 3 * r, 1.5f * r}, vec3(0), 38, exact_resolution);
  b.closed_form("a ball in the sun: L = rho E cos / pi", [r = double(r)](const Ray& ray) {
    const dvec3 o(ray.origin), d = glm::normalize(dvec3(ray.direction));
    const double along = -glm::dot(o, d), inside = along * along - glm::dot(o, o) + r * r;
    if (along <= 0 || inside < 0) return dvec3(0);
    return chalk_radiance((o + (along - std::sqrt(inside)) * d).y / r);
  });
  return b.finish();
}

struct FarKerbParams {
  float distance = 0;
};

template <class Visitor>
void describe(Visitor& v, FarKerbParams& p) {
  v.number("distance", p.distance, 0, 1e6, "m", "from the middle of the scene, where floats lie distance / 2^24 apart");
}

// The low sun casts the shadow of a kerb of 5 cm over half of what is seen, one metre long. Rays leave the floor a height above
// it and look over the kerb from height / 5 cm of the shadow's end: 16 clearances for floors seen from above
// (SurfacePoint::retreat), of 6 / 2^24 of the distance each (framework/scene/clearance.h).
Scene make_far_kerb(const FarKerbParams& params) {
  // The shadow is one metre long. What is parallel to x has no rounded coordinate but x.
  constexpr float height = 0.05f, shadow = 1, half = 1;
  const float x = params.distance;
  const vec3 sun = glm::normalize(vec3(shadow, -height, 0));
  ExactStage s("builtin:far-kerb");
  // The floor ends where the camera sees no more of it; before the kerb there is none.
  s.reflector(quad({x, 0, half}, {x + 2 * shadow, 0, half}, {x + 2 * shadow, 0, -half}, {x, 0, -half}),
              s.builder.material(Diffuse{chalk}),
              [x, sun](const dvec3& p) { return p.x - x > shadow ? chalk_radiance(-sun.y) / double(height) : dvec3(0); });
  s.blocker(quad({x, 0, half}, {x, height, half}, {x, height, -half}, {x, 0, -half}));
  // Another kerb on the other side keeps the middle of the scene at the origin.
  if (x > 0) s.blocker(quad({-x, 0, half}, {-x, height, half}, {-x, height, -half}, {-x, 0, -half}));
  s.builder.light(DirectionalLight{sun, Rgb(noon_irradiance / height)});
  s.builder.camera({x + shadow, 2, 0}, {x + shadow, 0, 0}, 45, exact_resolution, {0, 0, -1});
  return s.finish("the shadow of a kerb in the low sun");
}

}  // namespace

std::vector<BuiltinScene> sunlit_scenes() {
  return {with_params<make_sunlit_field>("sunlit-field", "exact: the middle of a field in the sun"),
          with_params<make_sunlit_ball>("sunlit-ball", "exact: a ball in the sun, for kernels as wide as it"),
          with_params<make_far_kerb>("far-kerb", "exact: the shadow of a kerb, far from the origin of floats")};
}

}  // namespace etendue
