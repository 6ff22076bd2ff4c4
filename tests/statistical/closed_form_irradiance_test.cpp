// Records filled from a scene's closed form: their irradiance and derivatives against the formula, and the orders that
// interpolation between them must have.
#include "integrators/caches/closed_form_irradiance.h"
#include "framework/core/error.h"
#include "framework/io/load_scene.h"
#include "framework/scenes/exact.h"
#include "tests/render_scene.h"
#include "tests/scene_context.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::exact_image;
using testing::render;
using testing::RenderOptions;
using testing::SceneContext;

constexpr double light_height = 1.5, light_radius = 0.5, light_radiance = 6;  // builtin:disc-light's, over a floor of y = 0

double disc_light(double x, double z) { return light_radiance * disc_irradiance(light_height, std::hypot(x, z), light_radius); }

TEST(ClosedFormIrradiance, HasTheFormulasDerivatives) {
  const SceneContext scene(load_scene("builtin:disc-light"));
  const vec3 normal(0, 1, 0);
  for (const vec3& at : {vec3(0.3f, 0, 0.2f), vec3(-0.7f, 0, 0.5f)}) {
    const IrradianceEstimate found = closed_form_irradiance(scene.context, {at, normal, normal, at, 0, 0});
    const double x = at.x, z = at.z, h = 1e-4, here = disc_light(x, z);
    EXPECT_NEAR(found.irradiance.x / here, 1, 1e-5);
    EXPECT_NEAR(found.translation[0].x, (disc_light(x + h, z) - disc_light(x - h, z)) / (2 * h), 1e-3 * here);
    EXPECT_NEAR(found.translation[0].z, (disc_light(x, z + h) - disc_light(x, z - h)) / (2 * h), 1e-3 * here);
    EXPECT_NEAR(found.translation[0].y, 0, 1e-5 * here);
    const Frame frame = Frame::from_normal(normal);
    const auto second = [&](const vec3& a) {
      const auto along = [&](double s) { return disc_light(x + s * a.x, z + s * a.z); };
      return (along(1e-3) - 2 * along(0) + along(-1e-3)) / 1e-6;
    };
    EXPECT_NEAR(found.hessian.xx, second(frame.tangent), 0.02 * here);
    EXPECT_NEAR(found.hessian.yy, second(frame.bitangent), 0.02 * here);
    EXPECT_NEAR(2 * found.hessian.xy, second(frame.tangent + frame.bitangent) - second(frame.tangent) - second(frame.bitangent),
                0.02 * here);
  }
}

TEST(ClosedFormIrradiance, HasOneSidedDerivativesAtABorder) {
  const SceneContext scene(load_scene("builtin:broad-light?veil=false"));
  const vec3 normal(0, 1, 0);
  const IrradianceEstimate inside = closed_form_irradiance(scene.context, {{1.9f, 0, 0}, normal, normal, vec3(0), 0, 0});
  const IrradianceEstimate border = closed_form_irradiance(scene.context, {{1.9995f, 0, 0}, normal, normal, vec3(0), 0, 0});
  EXPECT_LT(inside.translation[0].x, 0);
  EXPECT_NEAR(border.translation[0].x / inside.translation[0].x, 1, 0.2);
  EXPECT_NE(inside.hessian.xx, 0);
  EXPECT_EQ(border.hessian.xx, 0);
}

RenderOptions exact_records(const char* gradients, double spacing) {
  RenderOptions options;
  options.resolution = {96, 96};
  options.iterations = 8;
  options.params["fill"] = {std::string("closed-form"), {}};
  options.params["cache_direct"] = {true, {}};
  options.params["refine"] = {false, {}};
  options.params["neighbour_clamping"] = {false, {}};
  options.params["gradients"] = {std::string(gradients), {}};
  options.params["accuracy"] = {1.0, {}};
  options.params["min_spacing"] = {0.0, {}};
  options.params["max_spacing"] = {spacing, {}};
  return options;
}

// Root mean square over the middle of the floor.
double error_at(const Scene& scene, const Image& exact, const char* gradients, double spacing) {
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    RenderOptions options = exact_records(gradients, spacing);
    options.seed = seed;
    const Image image = render(scene, "irradiance-cache", options).image;
    for (int y = 24; y < 72; ++y)
      for (int x = 24; x < 72; ++x) sum += square(image.at(x, y).y - exact.at(x, y).y);
  }
  return std::sqrt(sum / (3 * 48 * 48));
}

TEST(ClosedFormIrradiance, InterpolationBetweenExactRecordsIsOfItsOrder) {
  const Scene scene = load_scene("builtin:broad-light?veil=false");
  const Image exact = exact_image(scene, {96, 96});
  const double none = error_at(scene, exact, "none", 0.06) / error_at(scene, exact, "none", 0.03);
  const double both = error_at(scene, exact, "both", 0.06) / error_at(scene, exact, "both", 0.03);
  EXPECT_NEAR(std::log2(none), 1, 0.25);
  EXPECT_NEAR(std::log2(both), 2, 0.35);
}

TEST(ClosedFormIrradiance, NeedsAKnownAnswerAndAllItsLight) {
  RenderOptions options = exact_records("both", 0.05);
  EXPECT_THROW(render(load_scene("builtin:cornell-box"), "irradiance-cache", options), Error);
  const Scene scene = load_scene("builtin:broad-light");
  options.params["metric"] = {std::string("geometric-hessian"), {}};
  EXPECT_THROW(render(scene, "irradiance-cache", options), Error);
  options.params["metric"] = {std::string("occlusion-hessian"), {}};
  options.params["cache_direct"] = {false, {}};
  EXPECT_THROW(render(scene, "irradiance-cache", options), Error);
}

}  // namespace
}  // namespace etendue
