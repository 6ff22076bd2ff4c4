// The path tracer, the light tracer and the bidirectional one against every closed form.
#include "integrators/paths/path.h"
#include "tests/image_checks.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::exact_image;
using testing::render;
using testing::RenderOptions;

// The mean over the image within `sigmas` of the closed form, the noise estimated from independent seeds.
void expect_mean_exact(const std::string& scene_name, const std::string& integrator, const ParamMap& params,
                       std::uint32_t iterations) {
  const Scene scene = load_scene(scene_name);
  RenderOptions options;
  options.params = params;
  options.iterations = iterations;
  const auto b = testing::bias_over_seeds(scene, integrator, options, 8);
  // 34 such tests, 8 seeds each: Student's t of 7 degrees of freedom at 1e-3 (Sidak) is 7.1. Rays start off their surface by its
  // clearance, 4.7e-5 on the sphere of radius 1 around a light, which is then so much nearer.
  EXPECT_LT(std::abs(b.mean), 7.1 * b.deviation + 1.2e-4)
      << scene_name << " " << integrator << ": bias " << b.mean << " +- " << b.deviation;
}

constexpr const char* exact_scenes[] = {"builtin:lambert-sphere", "builtin:lambert-sphere-off-centre",
                                        "builtin:furnace",        "builtin:polygon-light",
                                        "builtin:sphere-light",   "builtin:disc-light"};

TEST(PathTracer, MatchesEveryClosedFormInEveryMisMode) {
  for (const char* scene : exact_scenes)
    for (const char* mis : {"power", "balance", "light", "bsdf"})
      expect_mean_exact(scene, "path", {{"mis", {std::string(mis), {}}}}, 16);
}

TEST(PathTracer, WhiteFurnaceIsOneEverywhere) {
  const Scene scene = load_scene("builtin:white-furnace");
  for (const char* mis : {"power", "light", "bsdf"}) {
    RenderOptions options;
    options.params["mis"] = {std::string(mis), {}};
    options.params["roulette_depth"] = {std::int64_t{64}, {}};
    options.iterations = 64;
    EXPECT_LT(std::abs(bias(render(scene, "path", options).image, exact_image(scene, options.resolution))), 2e-3) << mis;
  }
}

TEST(LightTracer, MatchesClosedFormsThatItCanSample) {
  for (const char* scene :
       {"builtin:lambert-sphere", "builtin:lambert-sphere-off-centre", "builtin:furnace", "builtin:polygon-light"})
    expect_mean_exact(scene, "light-trace", {}, 16);
}

TEST(BidirectionalTracer, MatchesEveryClosedForm) {
  for (const char* scene : exact_scenes) expect_mean_exact(scene, "bdpt", {}, 8);
  RenderOptions options;
  options.iterations = 32;
  const Scene furnace = load_scene("builtin:white-furnace");
  EXPECT_LT(std::abs(bias(render(furnace, "bdpt", options).image, exact_image(furnace, options.resolution))), 4e-3);
}

TEST(PathTracer, DepthLimitTruncatesTheSeries) {
  // k reflections of the integrating sphere: L (1 - rho^k), the closed form for the central light.
  const Scene scene = load_scene("builtin:lambert-sphere");
  const double full = 1 / static_cast<double>(pi);
  for (const char* integrator : {"path", "light-trace", "bdpt"})
    for (int depth = 1; depth <= 3; ++depth) {
      RenderOptions options;
      options.params["max_depth"] = {std::int64_t{depth}, {}};
      options.iterations = 64;
      const auto image = render(scene, integrator, options).image;
      double mean = 0;
      for (const dvec3& p : image.pixels) mean += p.x / static_cast<double>(image.pixels.size());
      EXPECT_NEAR(mean / (full * (1 - std::pow(0.5, depth))), 1, 6e-3) << integrator << " " << depth;
    }
}

TEST(PathTracer, RouletteChangesNoiseNotTheMean) {
  for (const std::int64_t depth : {0, 1, 20})
    expect_mean_exact("builtin:furnace", "path", {{"roulette_depth", {depth, {}}}}, 16);
}

TEST(PathTracer, MisBeatsItsParts) {
  // Veach's plates: power-weighted sampling has less error than either strategy alone.
  const Scene scene = load_scene("builtin:veach-mis");
  RenderOptions options;
  options.resolution = {48, 32};
  options.iterations = 2048;
  options.seed = 77;
  const Image reference = render(scene, "path", options).image;
  const auto error = [&](const char* mis) {
    RenderOptions o;
    o.resolution = options.resolution;
    o.params["mis"] = {std::string(mis), {}};
    return trimmed_relmse(render(scene, "path", o).image, reference);
  };
  const double power = error("power");
  EXPECT_LT(power, error("light"));
  EXPECT_LT(power, error("bsdf"));
}

TEST(PathTracer, SameBitsAtAnyThreadCount) {
  for (const char* integrator : {"path", "light-trace", "bdpt"}) {
    RenderOptions options;
    options.iterations = 2;
    testing::expect_same_bits_at_any_thread_count(load_scene("builtin:cornell-spheres"), integrator, options);
  }
}

TEST(PathTracer, PathsTogetherGiveTheBitsOfEachAlone) {
  const Scene scene = load_scene("builtin:cornell-spheres");
  const SceneNeeds needs = scene_needs(scene);
  LightSampler lights(scene);
  for (const char* layout : {"binary", "bvh16"}) {
    const auto rays = find_ray_structure("binned-sah", {}).make(scene, {{"layout", {std::string(layout), {}}}});
    PhaseTimes phases;
    const RenderContext context{scene, needs, *rays, lights, 1, ivec2(40), phases, {}, {}};
    std::vector<PathSample> together;
    for (int i = 0; i < 1600; ++i) {
      Sampler sampler(SamplerKind::sobol, 1, Stream::camera, static_cast<std::uint64_t>(i), 0);
      const Ray ray = sample_camera_ray(context, {i % 40, i / 40}, sampler);
      together.push_back({ray, sampler});
    }
    std::vector<PathSample> alone = together;
    const PathSettings settings{.max_depth = 8, .roulette_depth = 3};
    trace_paths(context, together, 0, settings, false);
    for (PathSample& path : alone) trace_paths(context, {&path, 1}, 0, settings, false);
    for (std::size_t i = 0; i < alone.size(); ++i) {
      EXPECT_EQ(together[i].radiance, alone[i].radiance) << layout << " " << i;
      EXPECT_EQ(together[i].first_distance, alone[i].first_distance) << layout << " " << i;
    }
  }
}

}  // namespace
}  // namespace etendue
