#include "framework/scenes/borders.h"

#include "framework/scenes/exact_stage.h"

namespace etendue {

namespace {

const Rgb sand(0.7f, 0.6f, 0.45f);
constexpr float sun_irradiance = 4;  // facing it

// A diffuse surface in the sun.
ExactStage::Radiance sunlit(double cosine) {
  return [radiance = dvec3(sand) * (sun_irradiance * cosine / double(pi))](const dvec3&) { return radiance; };
}

MeshData level(float height, float half) {
  return quad({-half, height, half}, {half, height, half}, {half, height, -half}, {-half, height, -half});
}

}  // namespace

Scene make_edge(const EdgeParams& params) {
  const float half = params.size / 2;
  ExactStage s("builtin:edge");
  s.reflector(level(0, half), s.builder.material(Diffuse{sand}), sunlit(1));
  if (params.veil) s.veil(level(2 * half, 1.05f * half));
  s.builder.light(DirectionalLight{{0, -1, 0}, Rgb(sun_irradiance)});
  s.builder.camera(half * vec3(0.9f, 1.7f, 2.6f), half * vec3(0.05f, 0, 0.05f), 46, exact_resolution);
  return s.finish("even light: L = rho E / pi up to the border");
}

Scene make_corner(const VeilParams& params) {
  const float slant = std::sqrt(0.5f);
  ExactStage s("builtin:corner");
  const auto wall = s.builder.material(Diffuse{sand});
  s.reflector(quad({0, 0, 1}, {1, 0, 1}, {1, 0, -1}, {0, 0, -1}), wall, sunlit(slant));
  s.reflector(quad({0, 0, 1}, {0, 0, -1}, {0, 1, -1}, {0, 1, 1}), wall, sunlit(slant));
  // Across the beam, 1.8 from the corner.
  const auto across = [slant](float aside, float z) { return vec3((1.8f + aside) * slant, (1.8f - aside) * slant, z); };
  if (params.veil) s.veil(quad(across(-0.75f, 1.05f), across(0.75f, 1.05f), across(0.75f, -1.05f), across(-0.75f, -1.05f)));
  s.builder.light(DirectionalLight{{-slant, -slant, 0}, Rgb(sun_irradiance)});
  s.builder.max_depth(params.veil ? 2 : 1);
  s.builder.camera({1, 1.15f, 3}, {0.36f, 0.36f, 0}, 32, exact_resolution);
  return s.finish("even light on both walls, without what they send each other: L = rho E / pi");
}

Scene make_thin_plate(const ThinPlateParams& params) {
  const float t = params.thickness;
  const Rgb glow(0.02f, 0.04f, 0.08f);
  ExactStage s("builtin:thin-plate");
  const auto stone = s.builder.material(Diffuse{sand});
  s.reflector(level(0, 1), stone, sunlit(1));
  s.emitter(quad({-1, -t, -1}, {1, -t, -1}, {1, -t, 1}, {-1, -t, 1}), glow, stone);
  s.blocker(quad({-1, -t, 1}, {1, -t, 1}, {1, 0, 1}, {-1, 0, 1}));
  s.blocker(quad({-1, -t, -1}, {-1, 0, -1}, {1, 0, -1}, {1, -t, -1}));
  s.blocker(quad({1, -t, 1}, {1, -t, -1}, {1, 0, -1}, {1, 0, 1}));
  s.blocker(quad({-1, -t, 1}, {-1, 0, 1}, {-1, 0, -1}, {-1, -t, -1}));
  if (params.veil) s.veil(level(1, 1.05f));
  s.builder.light(DirectionalLight{{0, -1, 0}, Rgb(sun_irradiance)});
  s.builder.camera({-0.9f, -1.7f, 2.4f}, {0, 0, 0.05f}, 46, exact_resolution);
  return s.finish("a plate in the sun, seen from below: its own glow");
}

}  // namespace etendue
