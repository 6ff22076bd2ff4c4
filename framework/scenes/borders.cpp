// Exact scenes of even light that ends at a border: where density estimates darken, leak through a plate, or take light from
// the wrong wall. The sun lights them through a veil (exact_stage.h), so its light is a caustic to every method.
#include "framework/scenes/builtin_scenes.h"
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

struct EdgeParams : VeilParams {
  float size = 2;
};

template <class Visitor>
void describe(Visitor& v, EdgeParams& p) {
  v.number("size", p.size, 1e-3, 1e3, "m", "side of the patch; the image is the same at any");
  describe(v, static_cast<VeilParams&>(p));
}

Scene make_edge(const EdgeParams& params) {  // a square patch: a density estimate keeps 1 - (acos x - x sqrt(1 - x^2)) / pi
  const float half = params.size / 2;
  ExactStage s("builtin:edge");
  s.reflector(level(0, half), s.builder.material(Diffuse{sand}), sunlit(1));
  if (params.veil) s.veil(level(2 * half, 1.05f * half));
  s.builder.light(DirectionalLight{{0, -1, 0}, Rgb(sun_irradiance)});
  s.builder.camera(half * vec3(0.9f, 1.7f, 2.6f), half * vec3(0.05f, 0, 0.05f), 46, exact_resolution);
  return s.finish("even light: L = rho E / pi up to the border");
}

Scene make_corner(const VeilParams& params) {  // two walls that meet; paths end before they light each other
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

struct ThinPlateParams : VeilParams {
  float thickness = 0.01f;
};

template <class Visitor>
void describe(Visitor& v, ThinPlateParams& p) {
  v.number("thickness", p.thickness, 1e-4, 0.5, "m", "of the plate, two metres wide");
  describe(v, static_cast<VeilParams&>(p));
}

// Lit from above, seen from below, where it glows faintly: without a test of sides 1 - (t/r)^2 of the light leaks.
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

}  // namespace

std::vector<BuiltinScene> border_scenes() {
  return {with_params<make_edge>("edge", "exact: even light up to a border, where density estimates darken"),
          with_params<make_corner>("corner", "exact: even light on two walls that meet"),
          with_params<make_thin_plate>("thin-plate", "exact: a plate in the sun from below, where density leaks")};
}

}  // namespace etendue
