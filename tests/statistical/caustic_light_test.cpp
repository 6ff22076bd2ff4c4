// Caches that take caustics from a map of photons: against closed forms and other methods, and nothing counted twice.
#include "integrators/photons/caustic_light.h"
#include "experiments/run/closed_form.h"
#include "experiments/run/run_cell.h"
#include "framework/core/counters.h"
#include "framework/scene/builder.h"
#include "tests/block_agreement.h"
#include "tests/image_checks.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::params_of;
using testing::render;
using testing::RenderOptions;

constexpr const char* caches[] = {"irradiance-cache", "radiance-cache", "hash-cache"};
constexpr int seeds = 3;

RenderOptions options_for(const std::string& method, std::uint32_t iterations, const char* caustic_map = "auto") {
  RenderOptions options;
  options.iterations = iterations;
  options.params = params_of({{"caustic_map", caustic_map}});
  if (method != "hash-cache") options.params["samples"] = {std::int64_t{64}, {}};
  return options;
}

// The mean over seeds is within its noise and `allowed` of the closed form, and the method declares no less.
void expect_exact_mean(const char* scene_name, const char* method, std::uint32_t iterations, double allowed) {
  const Scene scene = load_scene(scene_name);
  ASSERT_TRUE(scene.closed_form) << scene_name;
  const RenderOptions options = options_for(method, iterations);
  const auto b = testing::bias_over_seeds(scene, method, options, seeds, integrate_closed_form(scene, options.resolution));
  EXPECT_LT(std::abs(b.mean), 8 * b.deviation + allowed)
      << scene_name << " " << method << ": " << b.mean << " +- " << b.deviation;
  EXPECT_LE(allowed, b.bound) << scene_name << " " << method;
}

// No shadow ray gets through a veil, and no path from the camera meets a sun: all of the light is the map's.
TEST(CausticLight, ThroughAVeilIsThatOfTheClosedForm) {
  for (const char* method : caches) {
    for (const char* scene : {"builtin:sunlit-field", "builtin:sunlit-ball", "builtin:thin-plate"})
      expect_exact_mean(scene, method, 4, 0.015);
    // A few hundred kernels reach over the borders: divided by their whole discs they lost 2.5 and 4 % of the light.
    expect_exact_mean("builtin:edge", method, 4, 0.005);
    expect_exact_mean("builtin:corner", method, 4, 0.01);
  }
}

// The scenes have lights by way of a specular surface, seen by way of one; a lamp that no path finds; a mirror that is nearly a
// delta lobe, and a rough one.
TEST(CausticLight, SeenBySpecularSurfacesIsThatOfTheClosedForm) {
  for (const char* method : caches) {
    for (const char* scene : {"builtin:water?camera=above", "builtin:mirror?view=both", "builtin:veiled-lamp?radius=0.0005",
                              "builtin:veiled-lamp?seen=through,radius=0.3", "builtin:glossy-furnace?alpha=0.05",
                              "builtin:glossy-furnace?alpha=0.5"})
      expect_exact_mean(scene, method, 4, 0.015);
  }
}

// A ball on so wide a field that three of four maps have no photon of it, and most others one: earlier maps tell how wide its
// light is. Where one photon alone was spread over a fiftieth of the scene, the spot had a hundredth of its light or a quarter.
TEST(CausticLight, OfASmallBallStaysUnderIt) {
  SceneBuilder b("ball on a field");
  b.mesh(quad({-95, 0, 95}, {95, 0, 95}, {95, 0, -95}, {-95, 0, -95}), b.material(Diffuse{Rgb(0.5f)}));
  b.quadric(Sphere{{0, 0.6f, 0}, 0.5f}, b.material(Dielectric{.eta = 1}));
  b.light(DirectionalLight{{0, -1, 0}, Rgb(1)});
  b.camera({0, 3, 3}, {0, 0, 0}, 6, {8, 8});  // sees 0.45 m of the field, beneath the ball
  const Scene scene = b.finish();
  for (const char* sampler : {"sobol", "independent"}) {
    RenderOptions options = options_for("irradiance-cache", 400, "on");
    options.params["caustic_photons"] = {std::int64_t{20000}, {}};
    options.params["sampler"] = {std::string(sampler), {}};
    options.resolution = {8, 8};
    const double seen = testing::block_means(render(scene, "irradiance-cache", options).image, 8).front().y;
    EXPECT_NEAR(seen / (0.5 / pi), 1, 0.3) << sampler;
  }
}

// No ray meets the sun behind the pane, so that what follows the narrow lobe does not find its light: photons are gathered.
TEST(CausticLight, OfTheSunFallsOnNarrowRoughCoats) {
  const auto coated = [](const char* name) {
    Scene scene = load_scene(name);
    for (Material& material : scene.materials)
      if (std::holds_alternative<Diffuse>(material)) material = Plastic{.reflectance = Rgb(0.5f), .alpha = 0.1f};
    scene.closed_form = {};
    return scene;
  };
  const Image expected = render(coated("builtin:sunlit-field?veil=false"), "path", {.params = {}, .iterations = 4}).image;
  for (const char* method : {"sppm", "photon-map", "photon-cache", "cppm", "vcm", "hash-cache", "irradiance-cache"}) {
    const auto b =
        testing::bias_over_seeds(coated("builtin:sunlit-field"), method, {.params = {}, .iterations = 16}, seeds, expected);
    EXPECT_LT(std::abs(b.mean), 8 * b.deviation + 0.02) << method << ": " << b.mean << " +- " << b.deviation;
  }
}

// A metal has no diffuse base: its lobe is followed, where gathering would be many times as noisy.
TEST(CausticLight, OfTheSunLeavesNarrowMetalsFollowed) {
  Scene scene = load_scene("builtin:sunlit-field");
  for (Material& material : scene.materials)
    if (std::holds_alternative<Diffuse>(material)) material = Conductor{.alpha = vec2(0.05f)};
  scene.closed_form = {};
  for (const char* method : {"photon-map", "sppm", "photon-cache"}) {
    const testing::Rendered rendered = render(scene, method, {.params = {}, .iterations = 1});
    EXPECT_EQ(relmse(rendered.image, Image(rendered.image.size)), 0) << method;
    EXPECT_EQ(rendered.expectation.bias, Bias::biased) << method;
    EXPECT_NE(rendered.expectation.left_out, "") << method;
    const auto on_chalk = render(load_scene("builtin:sunlit-field"), method, {.params = {}, .iterations = 1}).expectation;
    EXPECT_EQ(on_chalk.left_out, "") << method;
  }
}

// Glass, mirror and walls between which light goes on: the image is that of path tracing, which has no map.
TEST(CausticLight, IsCountedOnce) {
  testing::expect_agreement(load_scene("builtin:cornell-spheres"), {.resolution = {24, 24}, .block = 12, .comparisons = 3},
                            {"path", {}, 64, 0},
                            {{"hash-cache", {}, 16, 0.02}, {"irradiance-cache", params_of({{"samples", "128"}}), 8, 0.03}});
}

TEST(LongCausticLight, IsCountedOnceHoweverRecordsAreFilled) {
  testing::expect_agreement(load_scene("builtin:cornell-spheres"), {.resolution = {24, 24}, .block = 12, .comparisons = 3},
                            {"path", {}, 256, 0},
                            {{"hash-cache", {}, 64, 0.02},
                             {"irradiance-cache", params_of({{"samples", "256"}}), 32, 0.03},
                             {"irradiance-cache", params_of({{"samples", "256"}, {"fill", "paths"}}), 32, 0.03},
                             {"irradiance-cache", params_of({{"samples", "256"}, {"cache_direct", "true"}}), 32, 0.03},
                             {"radiance-cache", params_of({{"samples", "256"}}), 32, 0.03}});
}

TEST(LongCausticLight, OfASharpCausticIsThatOfProgressivePhotons) {
  const Scene scene = load_scene("builtin:glass-caustic");
  testing::expect_agreement(scene, {.resolution = {24, 24}, .block = 12, .comparisons = 3}, {"sppm", {}, 64, 0.03},
                            {{"hash-cache", {}, 64, 0.06}, {"irradiance-cache", params_of({{"samples", "128"}}), 32, 0.06}});
}

// Where nothing is specular there is no map, and a map that is asked for stays empty: the bits are the same.
TEST(CausticLight, CostsNothingWhereNothingIsSpecular) {
  for (const char* method : caches) {
    const Scene scene = load_scene("builtin:cornell-box");
    const std::uint64_t plain = render(scene, method, options_for(method, 2, "off")).hash;
    EXPECT_EQ(render(scene, method, options_for(method, 2)).hash, plain) << method;
  }
}

// An emission brings 1 with a chance of 2 %, else nothing.
TEST(RareEmission, KeepsTheMeanAndTakesFewEmissions) {
  constexpr int runs = 20000, iterations = 64;
  constexpr double chance = 0.02;
  Pcg32 rng(1, 1);
  double sum = 0, squares = 0, emissions = 0;
  for (int run = 0; run < runs; ++run) {
    RareEmission emission;
    double brought = 0;
    for (int i = 0; i < iterations; ++i) {
      const float weight = emission.weight(rng.next_float());
      if (weight == 0) continue;
      const bool found = rng.next_float() < chance;
      brought += found ? weight : 0;
      emission.emitted(found);
      emissions += 1.0 / runs;
    }
    sum += brought / runs;
    squares += brought * brought / runs;
  }
  const double error = std::sqrt((squares - sum * sum) / runs);
  EXPECT_NEAR(sum, chance * iterations, 4 * error);
  EXPECT_LT(error, 0.05);
  EXPECT_LT(emissions, 0.5 * iterations);
}

// The sun's light lands on the plate, and the camera sees what lies below it.
TEST(CausticLight, ThatLightsNothingSeenIsEmittedLessAndLess) {
  const Scene scene = load_scene("builtin:thin-plate");
  const SceneNeeds needs = scene_needs(scene);
  const auto emitted = [&](std::uint64_t iterations) {
    const Method accel{"binned-sah", {}, {}}, method{"hash-cache", {}, {}};
    const Budget budget = Budget::of_iterations(iterations);
    const CellResult cell = run_cell({scene, needs, accel, method, 1, {16, 16}, budget, 2});
    return find_value(cell.checkpoints.back().counters, std::string(counter_name(Counter::photons_emitted))).value_or(0);
  };
  const double some = static_cast<double>(emitted(8)), more = static_cast<double>(emitted(128));
  EXPECT_GT(some, 0);
  EXPECT_LT(more, 8 * some);
}

TEST(CausticLight, IsTheSameAtAnyThreadCount) {
  const Scene scene = load_scene("builtin:glass-caustic");
  for (const char* method : caches) {
    const RenderOptions options = options_for(method, 2);
    testing::expect_same_bits_at_any_thread_count(scene, method, options);
    const std::uint64_t plain = render(scene, method, options).hash;
    RenderOptions changed = options;
    changed.params["caustic_photons"] = {std::int64_t{5000}, {}};
    EXPECT_NE(render(scene, method, changed).hash, plain) << method;
    EXPECT_NE(render(scene, method, options_for(method, 2, "off")).hash, plain) << method;
  }
}

TEST(CausticLight, LosesNoneAtBorders) {
  const Scene scene = load_scene("builtin:edge");
  const Image exact = integrate_closed_form(scene, {32, 32});
  const auto b = testing::bias_over_seeds(scene, "hash-cache", options_for("hash-cache", 128), seeds, exact);
  EXPECT_LT(std::abs(b.mean), 8 * b.deviation + 0.001) << b.mean << " +- " << b.deviation;
}

TEST(CausticLight, IsNotCountedBesideExactRecords) {
  const Scene scene = load_scene("builtin:broad-light");
  RenderOptions options = options_for("irradiance-cache", 1, "on");
  options.params["fill"] = {std::string("exact-values"), {}};
  options.params["cache_direct"] = {true, {}};
  EXPECT_THROW(render(scene, "irradiance-cache", options), Error);
  const auto hash_with = [&](const char* caustic_map) {
    options.params["caustic_map"] = {std::string(caustic_map), {}};
    return render(scene, "irradiance-cache", options).hash;
  };
  EXPECT_EQ(hash_with("auto"), hash_with("off"));
}

}  // namespace
}  // namespace etendue
