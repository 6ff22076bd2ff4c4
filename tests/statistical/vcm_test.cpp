// Vertex connection and merging against closed forms: paths that only merging finds among them.
#include "integrators/bidirectional/vcm.h"
#include "experiments/run/closed_form.h"
#include "framework/scene/builder.h"
#include "tests/block_agreement.h"
#include "tests/faceted_ball.h"
#include "tests/image_checks.h"
#include "tests/scene_context.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::render;
using testing::RenderOptions;

// The image's mean over 8 seeds within seven standard errors (Student's t at 1e-3, Sidak over a dozen scenes) and the bias
// allowed.
void expect_exact_mean(const char* scene_name, const char* integrator, std::uint32_t iterations, double allowed,
                       const ParamMap& params = {}) {
  const Scene scene = load_scene(scene_name);
  RenderOptions options;
  options.iterations = iterations;
  options.params = params;
  const auto b = testing::bias_over_seeds(scene, integrator, options, 8, integrate_closed_form(scene, options.resolution));
  EXPECT_LT(std::abs(b.mean), 7.1 * b.deviation + allowed)
      << scene_name << " " << integrator << ": " << b.mean << " +- " << b.deviation;
  EXPECT_LT(7.1 * b.deviation, 0.05) << scene_name << " " << integrator << ": too noisy to tell anything";
}

// A bulb of many triangles is one lamp, and a hundred are few.
TEST(Vcm, MergesAmongManyLampsThatStandApart) {
  const auto merged = [](const Scene& scene) { return neighbours_by_need(testing::SceneContext(scene, {16, 16}).context); };
  EXPECT_EQ(merged(load_scene("builtin:many-lights?lights=200")), 4);
  EXPECT_EQ(merged(load_scene("builtin:many-lights?lights=100")), 0);
  for (const float width : {0.02f, 3.0f}) {
    SceneBuilder b("bulb");
    b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(Diffuse{Rgb(0.5f)}));
    MeshData panel;
    for (int i = 0; i < 200; ++i) {
      const float x = width * (static_cast<float>(i) / 200 - 0.5f);
      const auto first = static_cast<std::uint32_t>(panel.positions.size());
      panel.positions.insert(panel.positions.end(), {vec3(x, 2, 0), vec3(x + 0.005f * width, 2, 0), vec3(x, 2, width)});
      panel.triangles.emplace_back(first, first + 1, first + 2);
    }
    b.mesh(panel, b.material(Diffuse{Rgb(0)}), Rgb(1));
    b.camera({0, 1, 3}, {0, 0.5f, 0}, 50, {8, 8});
    EXPECT_EQ(merged(b.finish()), 0) << width;
  }
}

// Nearly all light paths stay in a shut ball of metal. As far apart as those in view are, merges would reach beyond the room.
TEST(Vcm, MergesNoWiderThanTheSceneWhereHardlyAnyLightPathIsSeen) {
  SceneBuilder b("shut lamp");
  MeshData room = box({-1, 0, -1}, {1, 2, 1});
  for (uvec3& triangle : room.triangles) std::swap(triangle.y, triangle.z);  // seen from inside
  b.mesh(room, b.material(Diffuse{Rgb(0.5f)}));
  const auto metal = b.material(Conductor{.ideal = true});
  b.quadric(Sphere{{0.5f, 0.3f, 0}, 0.2f}, metal);
  b.quadric(Sphere{{-0.6f, 1.7f, -0.6f}, 0.1f}, metal);
  b.light(PointLight{{-0.6f, 1.7f, -0.6f}, Rgb(30)});
  b.light(PointLight{{0, 1.6f, 0.3f}, Rgb(1)});
  b.camera({0, 1, 0.95f}, {0, 0.7f, 0}, 70, {16, 16});
  b.max_depth(2);
  const Scene scene = b.finish();
  RenderOptions options;
  options.resolution = {16, 16};
  options.iterations = 64;
  const auto expected = testing::block_means(render(scene, "bdpt", options).image, 4);
  const auto merged = testing::block_means(render(scene, "vcm", options).image, 4);
  // Up to 72 % were lost without a bound.
  for (std::size_t i = 0; i < merged.size(); ++i) EXPECT_NEAR(merged[i].y / expected[i].y, 1, 0.2) << "block " << i;
}

// Half of the light falls on the inside of a lamp of 6 cm, open at the front, behind glass.
TEST(Vcm, MergesNoWiderThanSmallSurfacesThatHoldMuchOfTheLight) {
  SceneBuilder b("lamp behind glass");
  b.mesh(quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}), b.material(Diffuse{Rgb(0.5f)}));
  MeshData lamp = box({-0.03f, 0.97f, -0.03f}, {0.03f, 1.03f, 0.03f});
  std::erase_if(lamp.triangles, [&](const uvec3& t) {
    return lamp.positions[t.x].y + lamp.positions[t.y].y + lamp.positions[t.z].y < 2.92f;  // its lower face
  });
  ASSERT_EQ(lamp.triangles.size(), 10u);
  for (uvec3& triangle : lamp.triangles) std::swap(triangle.y, triangle.z);  // shines inwards
  b.mesh(lamp, b.material(Diffuse{Rgb(0.8f)}), Rgb(100));
  b.quadric(Sphere{{0, 1, 0}, 0.3f}, b.material(Dielectric{.eta = 1.5f}));
  b.camera({0, 0.5f, 1.5f}, {0, 0, 0}, 50, {16, 16});
  const Scene scene = b.finish();
  RenderOptions options;
  options.resolution = {16, 16};
  options.iterations = 256;
  const auto mean = [&](const char* method) {
    return testing::block_means(render(scene, method, options).image, 16).front().y;
  };
  const double expected = mean("bdpt"), merged = mean("vcm");
  EXPECT_NEAR(merged / expected, 1, 0.05);
}

// A table on a plain, on which nearly all of the light lands.
TEST(Vcm, MergesNoWiderThanWhatIsSeen) {
  SceneBuilder b("a table on a plain");
  const auto wood = b.material(Diffuse{Rgb(0.5f)});
  b.mesh(quad({-100, 0, 100}, {100, 0, 100}, {100, 0, -100}, {-100, 0, -100}), wood);
  b.mesh(box({-0.3f, 0.95f, -0.3f}, {0.3f, 1, 0.3f}), wood);
  b.quadric(Sphere{{20, 2, 0}, 1}, b.material(Dielectric{.eta = 1.5f}));
  b.light(PointLight{{0, 30, 0}, Rgb(3000)});
  b.camera({0, 1.5f, 0.4f}, {0, 1, 0}, 35, {16, 16});
  const Scene scene = b.finish();
  RenderOptions options;
  options.resolution = {16, 16};
  options.iterations = 64;
  const auto mean = [&](const char* method) {
    return testing::block_means(render(scene, method, options).image, 16).front().y;
  };
  const double expected = mean("bdpt"), merged = mean("vcm");
  EXPECT_NEAR(merged / expected, 1, 0.02);
}

TEST(Bidirectional, MatchesCausticsOfPointLightsSeenDirectly) {
  for (const char* scene : {"builtin:mirror", "builtin:water"}) expect_exact_mean(scene, "bdpt", 64, 2e-5);
}

// A closed slot whose walls all shine alike: everywhere the sum of albedo^k over k events. Connections across it graze, or are
// short; aimed at the light vertex itself, not at a point off its surface, all of them ended at the wall that they led to
// (minus 5 % with three events).
TEST(Bidirectional, LosesNoConnectionsInANarrowFurnace) {
  constexpr float albedo = 0.8f, exact = 1 + albedo + albedo * albedo + albedo * albedo * albedo;
  SceneBuilder b("slot");
  const vec3 corner(4);
  MeshData walls = box(corner, corner + vec3(1, 0.1f, 1));
  for (uvec3& triangle : walls.triangles) std::swap(triangle.y, triangle.z);  // seen from inside
  b.mesh(walls, b.material(Diffuse{Rgb(albedo)}), Rgb(1));
  b.camera(corner + vec3(0.5f, 0.05f, 0.9f), corner + vec3(0.5f, 0.05f, 0), 60, {16, 16});
  b.max_depth(3);
  const Scene scene = b.finish();
  std::vector<double> errors;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    RenderOptions options;
    options.resolution = {16, 16};
    options.iterations = 48;
    options.seed = seed;
    errors.push_back(testing::block_means(render(scene, "bdpt", options).image, 16).front().y / exact - 1);
  }
  const double error = sample_sd(errors) / std::sqrt(8.0);
  EXPECT_LT(std::abs(mean(errors)), 5.4 * error);  // Student's t at 1e-3
  EXPECT_LT(error, 1e-3);
}

// A sphere that shines is sampled by the cone it fills, up to its edge, where the cosine is 0 in single precision: the density
// of light leaving there was 0 times infinity once in two million samples.
TEST(Bidirectional, WeighsLightThatGrazesItsSource) {
  const Scene scene = load_scene("builtin:glass-caustic");
  const LightSampler lights(scene);
  int edges = 0;
  for (int i = 0; i < 300000; ++i) {
    const float share = static_cast<float>(i) / 300000;
    const vec3 floor(6 * share - 3, 0, 1.2f);
    const auto sample = lights.sample(floor, 0, {0x1.fffffep-1f, std::fmod(100 * share, 1.0f)});
    ASSERT_TRUE(sample.has_value());
    const float cosine = -glm::dot(sample->normal, sample->wi);
    const float over_cosine = lights.emission_pdf_over_cosine(0, -sample->wi, floor);
    ASSERT_TRUE(over_cosine > 0 && std::isfinite(over_cosine));
    if (cosine > 0) {
      ASSERT_FLOAT_EQ(over_cosine * cosine, lights.emission_pdf(0, sample->normal, -sample->wi, floor));
    } else {
      ++edges;
    }
  }
  EXPECT_GT(edges, 0);
  RenderOptions options;  // by which iteration 35 draws such a sample
  options.resolution = {96, 96};
  options.iterations = 36;
  for (const char* integrator : {"bdpt", "vcm"}) EXPECT_EQ(render(scene, integrator, options).non_finite, 0u) << integrator;
}

const ParamMap merging = testing::params_of({{"neighbours", "1"}});  // where nothing is specular, too

TEST(Vcm, MatchesClosedForms) {
  for (const char* scene : {"builtin:lambert-sphere", "builtin:furnace", "builtin:cavity", "builtin:concentric-spheres"})
    expect_exact_mean(scene, "vcm", 4, 0.003, merging);
}

// Light that specular surfaces cast and show again.
TEST(Vcm, MatchesSpecularDiffuseSpecularPaths) {
  for (const char* scene : {"builtin:mirror?view=mirror", "builtin:mirror?view=both", "builtin:water?camera=above"})
    expect_exact_mean(scene, "vcm", 32, 0.01);
}

// See ProgressivePhotons.FacetsThatAreShadedRoundAreNotTooBright.
TEST(Vcm, FacetsThatAreShadedRoundAreNotTooBright) {
  const Scene scene = testing::faceted_ball();
  const Image reference = render(scene, "path", {.params = {}, .iterations = 512}).image;
  const auto b = testing::bias_over_seeds(scene, "vcm", {.params = merging, .iterations = 32}, 6, reference);
  EXPECT_LT(std::abs(b.mean), 0.03);
  EXPECT_LT(b.deviation, 0.008);
}

TEST(Vcm, CorrelationAwareWeightsKeepTheMean) {
  for (const char* scene : {"builtin:lambert-sphere", "builtin:concentric-spheres"})
    expect_exact_mean(scene, "vcm", 4, 0.003, testing::params_of({{"neighbours", "1"}, {"mis", "correlation-aware"}}));
  for (const char* scene : {"builtin:mirror?view=both", "builtin:water?camera=above"})
    expect_exact_mean(scene, "vcm", 32, 0.01, testing::params_of({{"mis", "correlation-aware"}}));
}

TEST(Vcm, LosesAndLeaksLittleAtEdges) {
  for (const char* scene : {"builtin:edge", "builtin:corner", "builtin:thin-plate"})
    expect_exact_mean(scene, "vcm", 4, 0.015, testing::params_of({{"paths", "10000"}}));
}

// Merges take time and add noise where all other strategies find the same light.
TEST(Vcm, MergesWhereLightIsSpecular) {
  const auto merges = [](const Scene& scene, const ParamMap& params = {}) {
    RenderOptions options;
    options.resolution = {16, 16};
    const auto of_bdpt = render(scene, "bdpt", options);
    options.params = params;
    const auto rendered = render(scene, "vcm", options);
    EXPECT_EQ(rendered.hash != of_bdpt.hash, rendered.expectation.mse_exponent > -1);
    return rendered.hash != of_bdpt.hash;
  };
  const auto lobe_under = [](float alpha, bool sun) {
    SceneBuilder b("lobe");
    b.mesh(quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}), b.material(Diffuse{Rgb(0.5f)}));
    b.mesh(box({0, 0, 0}, {0.5f, 0.5f, 0.5f}), b.material(Conductor{.ideal = true, .alpha = vec2(alpha)}));
    if (sun) b.light(DirectionalLight{glm::normalize(vec3(-0.4f, -1, -0.3f)), Rgb(1)});
    b.light(EnvironmentLight{.scale = Rgb(0.3f), .size = {}, .texels = {}, .light_to_world = {}});
    b.camera({0, 1, 3}, {0, 0, 0}, 40, {16, 16});
    return b.finish();
  };
  EXPECT_TRUE(merges(load_scene("builtin:glass-caustic")));
  EXPECT_TRUE(merges(lobe_under(0.1f, true)));
  EXPECT_FALSE(merges(lobe_under(0.1f, false)));
  EXPECT_FALSE(merges(lobe_under(0.5f, true)));
  const Scene diffuse = load_scene("builtin:cornell-box");
  EXPECT_FALSE(merges(diffuse));
  EXPECT_FALSE(merges(diffuse, testing::params_of({{"mis", "correlation-aware"}})));
  EXPECT_TRUE(merges(diffuse, testing::params_of({{"neighbours", "1"}})));
  EXPECT_TRUE(merges(diffuse, testing::params_of({{"radius", "0.05"}})));
}

// Two rooms on one floor, a wall of 4 cm between them; the rest of the light stays behind it.
TEST(Vcm, RefusesMergesThroughWalls) {
  const Scene scene = load_scene("builtin:keyhole");
  const auto mean = [&](const char* name, const decltype(ParamValue::value)& value) {
    RenderOptions options;
    options.resolution = {48, 48};
    options.params["neighbours"] = {std::int64_t{4}, {}};
    options.params[name] = {value, {}};
    const Image image = render(scene, "vcm", options).image;
    return testing::block_means(image, 48).front().y;  // of the whole image
  };
  const double narrow = mean("radius", 0.03), leaking = mean("wall_test", false), clear = mean("wall_test", true);
  EXPECT_GT(leaking, 1.25 * narrow);
  EXPECT_LT(std::abs(clear - narrow), 0.2 * (leaking - narrow));
}

// k reflections of the integrating sphere: L (1 - rho^k).
TEST(Vcm, DepthLimitTruncatesTheSeries) {
  const Scene scene = load_scene("builtin:lambert-sphere");
  for (int depth = 1; depth <= 3; ++depth) {
    RenderOptions options;
    options.params = merging;
    options.params["max_depth"] = {std::int64_t{depth}, {}};
    options.iterations = 32;
    const Image image = render(scene, "vcm", options).image;
    double mean = 0;
    for (const dvec3& p : image.pixels) mean += p.x / static_cast<double>(image.pixels.size());
    EXPECT_NEAR(mean * static_cast<double>(pi) / (1 - std::pow(0.5, depth)), 1, 0.01) << depth;
  }
}

TEST(Vcm, SameBitsAtAnyThreadCount) {
  const Scene scene = load_scene("builtin:cornell-spheres");
  RenderOptions options;
  options.iterations = 2;
  options.resolution = {48, 48};  // more light paths than one chunk
  for (const char* integrator : {"light-trace", "bdpt", "vcm", "vcm correlation-aware"}) {
    if (std::string(integrator) == "vcm correlation-aware") {
      integrator = "vcm";
      options.params["mis"] = {"correlation-aware", {}};
    }
    testing::expect_same_bits_at_any_thread_count(scene, integrator, options);
  }
}

TEST(Vcm, EveryParameterChangesTheImage) {
  const Scene scene = load_scene("builtin:cornell-spheres");
  RenderOptions options;
  options.iterations = 2;
  const auto hash = [&](const char* name, const decltype(ParamValue::value)& value) {
    RenderOptions changed = options;
    changed.params[name] = {value, {}};
    return render(scene, "vcm", changed).hash;
  };
  const std::uint64_t plain = render(scene, "vcm", options).hash;
  const std::pair<const char*, decltype(ParamValue::value)> changes[] = {
      {"max_depth", std::int64_t{2}},
      {"roulette_depth", std::int64_t{1}},
      {"paths", std::int64_t{100}},
      {"sampler", "independent"},
      {"radius", 0.05},
      {"neighbours", std::int64_t{9}},
      {"alpha", 0.5},
      {"mis", "correlation-aware"},
      {"wall_test", false},
  };
  for (const auto& [name, value] : changes) EXPECT_NE(hash(name, value), plain) << name;
  EXPECT_THROW(hash("structure", "hashgrid"), Error);
}

}  // namespace
}  // namespace etendue
