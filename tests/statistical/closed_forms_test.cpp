// The built-in scenes' closed forms against estimators that share nothing with them.
#include "experiments/run/closed_form.h"
#include "framework/materials/fresnel.h"
#include "framework/scenes/exact.h"
#include "tests/image_checks.h"
#include "tests/sealed_checks.h"

#include <gtest/gtest.h>

#include <numbers>

namespace etendue {
namespace {

using testing::render;
using testing::RenderOptions;

struct ClosedFormScene {
  const char* scene;
  const char* integrator = "path";
  std::uint32_t iterations = 16;
  ParamMap params = {};
  double allowed = 2e-5;  // beyond the noise: single precision's, or a density estimate's bias
};

// The image's mean by independent seeds within seven standard errors of the closed form: of 7 degrees of freedom and some 25
// cases, one false alarm in a thousand runs.
void expect_exact_mean(const ClosedFormScene& c) {
  const Scene scene = load_scene(c.scene);
  ASSERT_TRUE(scene.closed_form) << c.scene;
  RenderOptions options;
  options.params = c.params;
  options.iterations = c.iterations;
  const auto b = testing::bias_over_seeds(scene, c.integrator, options, 8, integrate_closed_form(scene, options.resolution));
  ::testing::Test::RecordProperty(c.scene, std::to_string(b.mean) + " +- " + std::to_string(b.deviation));
  EXPECT_LT(std::abs(b.mean), 7.1 * b.deviation + c.allowed)
      << c.scene << " " << c.integrator << ": " << b.mean << " +- " << b.deviation;
}

TEST(ClosedForms, OfCavitiesMatchPathTracing) {
  for (const char* scene :
       {"builtin:cavity", "builtin:cavity?opening=0.5", "builtin:cavity?opening=0.02", "builtin:concentric-spheres"})
    expect_exact_mean({scene});
}

TEST(ClosedForms, OfLightWithoutVeilMatchPathTracing) {
  for (const char* scene :
       {"builtin:edge?veil=false", "builtin:corner?veil=false", "builtin:thin-plate?veil=false,thickness=0.1",
        "builtin:broad-light?veil=false", "builtin:two-occluders?veil=false", "builtin:hidden-occluder?veil=false",
        "builtin:slit-light?veil=false", "builtin:thin-wall?veil=false", "builtin:black-surroundings?veil=false",
        "builtin:sunlit-field?veil=false", "builtin:sunlit-ball?veil=false", "builtin:veiled-lamp?veil=false",
        "builtin:glossy-furnace?veil=false", "builtin:many-lamps"})
    expect_exact_mean({scene});
}

TEST(ClosedForms, HoldAlongTheirParameters) {
  for (const char* scene :
       {"builtin:edge?veil=false,size=0.5", "builtin:slit-light?veil=false,width=0.5",
        "builtin:hidden-occluder?veil=false,light=2", "builtin:thin-wall?veil=false,day=3",
        "builtin:black-surroundings?veil=false,walls=1", "builtin:sunlit-field?veil=false,surroundings=9",
        "builtin:sunlit-ball?veil=false,radius=0.1", "builtin:veiled-lamp?veil=false,radius=0.3,seen=through",
        "builtin:glossy-furnace?veil=false,alpha=0.8", "builtin:glossy-furnace?veil=false,alpha=0.05",
        "builtin:glossy-lamp?alpha=0.02,size=0.3", "builtin:glossy-lamp?alpha=0.5,size=0.1", "builtin:many-lamps?lamps=4",
        "builtin:furnace?albedo=0.7", "builtin:lambert-sphere?albedo=0.7"})
    expect_exact_mean({scene});
  // Rays that leave the floor look over the kerb from 16 clearances above it.
  expect_exact_mean({"builtin:far-kerb", "path", 16, {}, 1e-3});
}

TEST(ClosedForms, OfGlowingRoomMatchesPathTracing) {
  for (const char* name : {"builtin:glowing-room", "builtin:glowing-room?panel=2,walls=0.5"}) {
    const Scene scene = load_scene(name);
    ASSERT_TRUE(scene.closed_form);
    RenderOptions options;
    options.resolution = {8, 8};
    options.iterations = 4096;
    const Image rendered = render(scene, "path", options).image, exact = integrate_closed_form(scene, options.resolution);
    EXPECT_LT(std::abs(bias(rendered, exact)), 1e-3) << name;
    for (std::size_t i = 0; i < exact.pixels.size(); ++i)
      EXPECT_LT(glm::length(rendered.pixels[i] - exact.pixels[i]), 0.018 * glm::length(exact.pixels[i])) << name << " " << i;
  }
}

// With the veil, path tracing finds these lights by chance.
TEST(ClosedForms, OfVeiledLightsMatchPathTracing) {
  for (const char* scene : {"builtin:two-occluders", "builtin:thin-wall", "builtin:thin-plate"})
    expect_exact_mean({scene, "path", 64});
  for (const char* scene : {"builtin:slit-light", "builtin:hidden-occluder", "builtin:black-surroundings"})
    expect_exact_mean({scene, "path", 256});
}

TEST(ClosedForms, OfTheBackOfALightIsBlackToEveryMethod) {
  SceneBuilder builder("back of a light");
  builder.mesh(quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}), builder.material(Diffuse{}), Rgb(1));  // shines up
  builder.camera({0, -2, 0.1f}, {0, 0, 0}, 90, {8, 8});
  const Scene scene = builder.finish();
  for (const testing::SealedMethod& method : testing::sealed_methods()) {
    RenderOptions options;
    options.params = method.params;
    options.resolution = {8, 8};
    const Image image = render(scene, method.name, options).image;
    for (const dvec3& p : image.pixels) ASSERT_EQ(p, dvec3(0)) << method.name << method.variant;
  }
}

TEST(ClosedForms, OfCausticsMatchLightTracing) {
  for (const char* scene : {"builtin:edge", "builtin:corner", "builtin:mirror", "builtin:water"})
    expect_exact_mean({scene, "light-trace", 64});
}

// Paths from a point light by way of a specular surface, seen by way of one: of all methods only photons find them.
TEST(ClosedForms, OfSpecularDiffuseSpecularPathsMatchPhotonMapping) {
  const ParamMap params{{"retrace", {true, {}}}, {"caustic_photons", {std::int64_t{50'000}, {}}}};
  for (const char* scene : {"builtin:mirror?view=mirror", "builtin:mirror?view=both", "builtin:water?camera=above"})
    expect_exact_mean({scene, "photon-map", 2, params, 5e-3});
}

// Directions cast from the light, refracted, counted where they fall.
TEST(ClosedForms, OfWaterMatchesRaysCast) {
  constexpr double height = 0.8, depth = 1, eta = 1.33, width = 0.25;
  constexpr int rings = 8, rays = 400'000;
  std::vector<double> flux(rings);
  for (int i = 0; i < rays; ++i) {
    const double cosine = (i + 0.5) / rays;  // directions downwards, even in solid angle
    const double sine = std::sqrt(1 - cosine * cosine), sine_t = sine / eta;
    const double x = height * sine / cosine + depth * sine_t / std::sqrt(1 - sine_t * sine_t);
    const auto ring = static_cast<std::size_t>(x / width);
    if (ring < flux.size())
      flux[ring] += 2 * std::numbers::pi / rays * (1 - fresnel_dielectric(static_cast<float>(cosine), static_cast<float>(eta)));
  }
  for (int ring = 0; ring < rings; ++ring) {
    // The ring's flux, E times its area, by Simpson's rule.
    const double a = ring * width, b = a + width;
    const auto density = [&](double x) { return 2 * std::numbers::pi * x * refracted_irradiance(x, height, depth, eta); };
    double expected = 0;
    for (int k = 0; k < 16; ++k) {
      const double l = a + width * k / 16, r = l + width / 16;
      expected += (r - l) / 6 * (density(l) + 4 * density(0.5 * (l + r)) + density(r));
    }
    EXPECT_NEAR(flux[static_cast<std::size_t>(ring)] / expected, 1, 2e-4) << a << " to " << b;
  }
}

TEST(ClosedForms, OnTheAxisWaterIsAsIfNearer) {
  const double normal = 1 - std::pow(0.33 / 2.33, 2);
  EXPECT_NEAR(refracted_irradiance(0, 0.8, 1, 1.33), normal / std::pow(0.8 + 1 / 1.33, 2), 1e-12);
}

// A veil is nothing but an obstacle to shadow rays.
TEST(ClosedForms, DoNotChangeWithTheVeil) {
  for (const char* name : {"edge", "corner", "thin-plate", "two-occluders", "hidden-occluder", "slit-light", "thin-wall",
                           "black-surroundings", "sunlit-field", "sunlit-ball", "veiled-lamp", "glossy-furnace"}) {
    const Scene veiled = load_scene(std::string("builtin:") + name),
                bare = load_scene(std::string("builtin:") + name + "?veil=false");
    EXPECT_NE(veiled.hash(), bare.hash()) << name;
    EXPECT_TRUE(scene_needs(veiled).caustic_map) << name;
    EXPECT_FALSE(scene_needs(bare).caustic_map) << name;
    for (int i = 0; i < 64; ++i) {
      const Ray ray = veiled.camera.ray({8, 8}, {i % 8 + 0.5f, i / 8 + 0.5f}, vec2(0.5f));
      EXPECT_EQ(veiled.closed_form->radiance(ray), bare.closed_form->radiance(ray)) << name;
    }
  }
}

}  // namespace
}  // namespace etendue
