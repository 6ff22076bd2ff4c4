// Exact scenes of lamps over a floor that are hard to find: behind glass, where no shadow ray gets through, or among many that
// light nothing.
#include "framework/core/elementary.h"
#include "framework/scenes/builtin_scenes.h"
#include "framework/scenes/exact.h"
#include "framework/scenes/exact_stage.h"

namespace etendue {

namespace {

const Rgb plaster(0.8f, 0.78f, 0.72f);
constexpr float lamp_height = 1, watts_per_sr = 5;

void lamp_floor(ExactStage& s, std::function<double(const dvec3& point)> irradiance) {
  s.reflector(quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}), s.builder.material(Diffuse{plaster}),
              [irradiance](const dvec3& p) { return dvec3(plaster) / pi_d * irradiance(p); });
}

// The camera sees the floor alone, less than a metre about the lamp's foot.
void lamp_camera(ExactStage& s) { s.builder.camera({0, 1.1f, 1.7f}, {0, 0, 0}, 20, exact_resolution); }

struct VeiledLampParams : VeilParams {
  float radius = 0.1f;
  std::string seen = "directly";
};

template <class Visitor>
void describe(Visitor& v, VeiledLampParams& p) {
  v.number("radius", p.radius, 1e-4, 0.3, "m", "of the lamp, a sphere a metre above the floor, of the same power at any size");
  v.choice("seen", p.seen, {"directly", "through"}, "the floor; through: a second pane, before the camera");
  describe(v, static_cast<VeilParams&>(p));
}

// Directions in proportion to the cosine find the lamp with a chance p of (radius / distance)^2 cos: the relative variance of n
// samples is (1 - p) / (n p).
Scene make_veiled_lamp(const VeiledLampParams& params) {
  const float radius = params.radius, radiance = watts_per_sr / (pi * square(radius));
  ExactStage s("builtin:veiled-lamp");
  lamp_floor(s, [=](const dvec3& p) { return radiance * sphere_irradiance(p, {0, 1, 0}, {0, lamp_height, 0}, radius); });
  s.builder.quadric(Sphere{{0, lamp_height, 0}, radius}, s.black(), Rgb(radiance));
  // Between the lamp and all of the floor that is seen, but not between that and the camera.
  constexpr float height = 0.68f, half = 0.6f;
  if (params.veil) s.veil(quad({-half, height, half}, {half, height, half}, {half, height, -half}, {-half, height, -half}));
  if (params.seen == "through") s.veil(quad({-1, 0.2f, 1.6f}, {1, 0.2f, 1.6f}, {1, 1.6f, 1.6f}, {-1, 1.6f, 1.6f}));
  lamp_camera(s);
  return s.finish("sphere: E = pi L (a/d)^2 cos");
}

struct ManyLampsParams {
  int lamps = 1;
};

template <class Visitor>
void describe(Visitor& v, ManyLampsParams& p) {
  v.integer("lamps", p.lamps, 1, 1'000'000, "lamps", "of the same power; all but one hang below the floor");
}

// Where lamps are chosen in proportion to their power, the relative variance of n samples is (lamps - 1) / n.
Scene make_many_lamps(const ManyLampsParams& params) {
  ExactStage s("builtin:many-lamps");
  lamp_floor(s, [](const dvec3& p) { return watts_per_sr * sphere_irradiance(p, {0, 1, 0}, {0, lamp_height, 0}, 1) / pi_d; });
  s.builder.light(PointLight{{0, lamp_height, 0}, Rgb(watts_per_sr)});
  for (int i = 1; i < params.lamps; ++i) {
    const float turn = 2 * pi * static_cast<float>(i) / static_cast<float>(params.lamps);
    s.builder.light(PointLight{{0.5f * math::cos(turn), -lamp_height, 0.5f * math::sin(turn)}, Rgb(watts_per_sr)});
  }
  lamp_camera(s);
  return s.finish("the one lamp above the floor: E = I cos/d^2");
}

}  // namespace

std::vector<BuiltinScene> lamp_scenes() {
  return {with_params<make_veiled_lamp>("veiled-lamp", "exact: a lamp behind glass, at any size"),
          with_params<make_many_lamps>("many-lamps", "exact: one lamp that lights, among many that do not")};
}

}  // namespace etendue
