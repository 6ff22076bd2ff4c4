#include "framework/scenes/lamps.h"

#include "framework/core/elementary.h"
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

}  // namespace

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

}  // namespace etendue
