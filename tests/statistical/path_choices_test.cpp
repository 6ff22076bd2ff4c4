// Choices that path tracing makes by a scene: what they are, and that images keep their means.
#include "integrators/paths/path_choices.h"
#include "framework/scene/builder.h"
#include "framework/transport/roulette.h"
#include "tests/block_agreement.h"
#include "tests/image_checks.h"
#include "tests/scene_context.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::params_of;
using testing::SceneContext;

MisMode mis_of(const char* name) {
  const SceneContext scene(load_scene(name), {16, 16});
  return choose_mis(scene.context).mode;
}

TEST(PathChoices, DirectLightIsFoundByTheSamplesThatBringIt) {
  for (const char* name : {"builtin:white-furnace", "builtin:furnace"}) EXPECT_EQ(mis_of(name), MisMode::bsdf) << name;
  for (const char* name : {"builtin:polygon-light", "builtin:sphere-light", "builtin:disc-light"})
    EXPECT_EQ(mis_of(name), MisMode::light) << name;
  for (const char* name : {"builtin:broad-light", "builtin:two-occluders", "builtin:hidden-occluder", "builtin:slit-light",
                           "builtin:thin-wall", "builtin:black-surroundings"})
    EXPECT_EQ(mis_of(name), MisMode::bsdf) << name;
  for (const char* name : {"builtin:cornell-box", "builtin:cornell-spheres", "builtin:veach-mis", "builtin:glowing-room",
                           "builtin:stadium", "builtin:water", "builtin:broad-light?veil=false"})
    EXPECT_EQ(mis_of(name), MisMode::power) << name;
}

// Close to large lamps the error of light samples alone has no bound. Caches had 2e-2 between two glowing spheres, and 5e-2 to
// 0.27 in a glowing room.
TEST(PathChoices, PhotonsAndCachesFindTheLightOfCloseLampsByBothKindsOfSamples) {
  const auto direct_of = [](const char* name) { return choose_direct(SceneContext(load_scene(name), {32, 32}).context); };
  for (const char* name :
       {"builtin:cornell-box", "builtin:two-rooms", "builtin:sphere-light", "builtin:many-lights", "builtin:corner"})
    EXPECT_EQ(direct_of(name), MisMode::light) << name;
  for (const char* name : {"builtin:concentric-spheres", "builtin:glowing-room", "builtin:exterior"})
    EXPECT_EQ(direct_of(name), MisMode::power) << name;

  testing::RenderOptions options;
  options.resolution = {32, 32};
  options.iterations = 8;
  for (const char* name : {"builtin:concentric-spheres", "builtin:glowing-room"}) {
    const Scene scene = load_scene(name);
    const Image exact = testing::exact_image(scene, options.resolution);
    for (const char* method : {"irradiance-cache", "photon-cache", "hash-cache", "photon-map", "sppm"})
      EXPECT_LT(relmse(testing::render(scene, method, options).image, exact), 8e-3) << name << " " << method;
  }
}

// Each has a light that a few paths do not meet: a far sphere, the sun in an image of the sky, a lamp beside one behind glass,
// and a lamp of which a mirror that fills the view shows the reflection.
TEST(PathChoices, LightsThatFewPathsMeetAreSampled) {
  const auto mode = [](const auto& add) {
    SceneBuilder b("few paths");
    b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(Diffuse{Rgb(0.6f)}));
    b.camera({0, 1.6f, 4.5f}, {0, 0, 0}, 20, {16, 16});
    add(b);
    const SceneContext scene(b.finish(), {16, 16});
    return choose_mis(scene.context).mode;
  };
  const auto lamp = [](SceneBuilder& b, const vec3& at, float radius) {
    b.quadric(Sphere{at, radius}, b.material(Diffuse{Rgb(0)}), Rgb(10));
  };
  EXPECT_EQ(mode([&](SceneBuilder& b) {
              b.quadric(Sphere{{0, 0.5f, 0}, 0.5f}, b.material(Conductor{.ideal = true, .alpha = vec2(0.3f)}));
              lamp(b, {0, 1000, 0}, 5);
            }),
            MisMode::power);
  EXPECT_EQ(mode([](SceneBuilder& b) {
              std::vector<Rgb> texels(64 * 32, Rgb(1));
              texels[5 * 64 + 20] = Rgb(1e4f);
              b.light(EnvironmentLight{.scale = Rgb(1), .size = {64, 32}, .texels = texels, .light_to_world = {}});
            }),
            MisMode::power);
  EXPECT_EQ(mode([&](SceneBuilder& b) {
              b.quadric(Sphere{{0, 3, 0}, 0.5f}, b.material(Dielectric{.eta = 1.5f}));
              lamp(b, {0, 3, 0}, 0.3f);
              lamp(b, {1, 0.2f, 0}, 0.02f);
            }),
            MisMode::power);
  EXPECT_EQ(mode([&](SceneBuilder& b) {
              b.quadric(Disk{{0, 1, 3}, 3, {0, 0, 1}}, b.material(Conductor{}));
              lamp(b, {0, 1.6f, 9}, 3);
            }),
            MisMode::power);
}

// Two paths in the one pixel that is lit agree by chance under some seeds.
TEST(PathChoices, OneLitPixelDoesNotTellThatLightIsEven) {
  SceneBuilder b("small thing");
  b.mesh(quad({-0.1f, 0, 0.1f}, {0.1f, 0, 0.1f}, {0.1f, 0, -0.1f}, {-0.1f, 0, -0.1f}), b.material(Diffuse{Rgb(0.6f)}));
  b.quadric(Disk{{0, 1, 0}, 1, {0, -1, 0}}, b.material(Diffuse{Rgb(0)}), Rgb(10));
  b.camera({0, 0.9f, 0.2f}, {0, 0, 0}, 100, {16, 16});
  const Scene scene = b.finish();
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SceneContext context(scene, {16, 16}, seed);
    EXPECT_NE(choose_mis(context.context).mode, MisMode::bsdf) << seed;
  }
}

// A lamp over a floor, with a pane of glass between: wide enough, beneath the whole lamp and to be trusted to stop shadow rays.
struct UnderGlass {
  float half = 1;  // of the pane's width, metres
  float lift = 0;  // of one of its corners
  bool masked = false, rough = false, one_triangle = false, table = false, second_lamp = false;

  MisMode mode() const {
    SceneBuilder b("under glass");
    const std::uint32_t grey = b.material(Diffuse{Rgb(0.6f)}), black = b.material(Diffuse{Rgb(0)});
    const auto level = [](float half, float at) {
      return quad({-half, at, half}, {half, at, half}, {half, at, -half}, {-half, at, -half});
    };
    b.mesh(level(2, 0), grey);
    if (table) b.mesh(level(0.1f, 1.95f), grey);
    MeshData lamp = level(0.5f, 2), pane = level(half, 1.9f);
    for (uvec3& t : lamp.triangles) std::swap(t.y, t.z);
    pane.positions[2].y += lift;
    if (one_triangle) pane.triangles.pop_back();
    b.mesh(lamp, black, Rgb(10));
    if (second_lamp) b.quadric(Sphere{{3, 1, 0}, 0.1f}, black, Rgb(1));
    b.mesh(pane, b.material(Dielectric{.eta = 1.5f, .alpha = rough ? 0.3f : 0}));
    b.camera({0, 1.6f, 4.5f}, {0, 0, 0}, 40, {16, 16});
    Scene scene = b.finish();
    if (masked) {
      scene.textures.push_back({});
      scene.objects[0].shapes.back().mask = 0;
    }
    const SceneContext context(scene, {16, 16});
    return choose_mis(context.context).mode;
  }
};

TEST(PathChoices, LightsAreSampledUnlessPanesHideThemFromAllSurfaces) {
  EXPECT_EQ(UnderGlass{}.mode(), MisMode::bsdf);
  EXPECT_NE((UnderGlass{.half = 0.55f}.mode()), MisMode::bsdf);  // rays slip through beside it
  EXPECT_NE((UnderGlass{.lift = 0.02f}.mode()), MisMode::bsdf);  // not flat: not looked into
  EXPECT_NE((UnderGlass{.masked = true}.mode()), MisMode::bsdf);
  EXPECT_NE((UnderGlass{.rough = true}.mode()), MisMode::bsdf);
  EXPECT_NE((UnderGlass{.one_triangle = true}.mode()), MisMode::bsdf);
  EXPECT_NE((UnderGlass{.table = true}.mode()), MisMode::bsdf);
  EXPECT_NE((UnderGlass{.second_lamp = true}.mode()), MisMode::bsdf);
}

// A bulb: a lamp in a ball of glass over a floor.
MisMode under_bulb(float lamp_radius, const Material& glass, float floor = 0) {
  SceneBuilder b("bulb");
  b.mesh(quad({-1, floor, 1}, {1, floor, 1}, {1, floor, -1}, {-1, floor, -1}), b.material(Diffuse{Rgb(0.5f)}));
  b.quadric(Sphere{{0, 1, 0}, lamp_radius}, b.material(Diffuse{Rgb(0)}), Rgb(1));
  b.quadric(Sphere{{0, 1, 0}, 0.2f}, b.material(glass));
  b.camera({0, 1, 3}, {0, 0.5f, 0}, 50, {8, 8});
  SceneContext stage(b.finish(), {8, 8}, 1);
  return choose_mis(stage.context).mode;
}

TEST(PathChoices, LightsAreSampledUnlessAShellHidesThemFromAllSurfaces) {
  EXPECT_EQ(mis_of("builtin:glossy-furnace"), MisMode::bsdf);
  EXPECT_EQ(under_bulb(0.05f, Dielectric{.eta = 1.5f}), MisMode::bsdf);
  EXPECT_NE(under_bulb(0.05f, Dielectric{.eta = 1.5f, .alpha = 0.3f}), MisMode::bsdf);
  EXPECT_NE(under_bulb(0.25f, Dielectric{.eta = 1.5f}), MisMode::bsdf);        // the lamp is without
  EXPECT_NE(under_bulb(0.05f, Dielectric{.eta = 1.5f}, 0.9f), MisMode::bsdf);  // the floor is within as well
}

TEST(PathChoices, RouletteWaitsWherePathsBringTheSame) {
  const auto evenness = [](const char* name) {
    const SceneContext scene(load_scene(name), {16, 16});
    return roulette_evenness(scene.context, {});
  };
  EXPECT_GT(evenness("builtin:furnace"), 1e4f);
  EXPECT_GT(evenness("builtin:lambert-sphere"), 1e4f);
  EXPECT_EQ(evenness("builtin:cornell-box"), 1);
  EXPECT_EQ(evenness("builtin:veach-mis"), 1);
  EXPECT_EQ(survival_of(Rgb(0.5f), 1.0f), 0.5f);
  EXPECT_EQ(survival_of(Rgb(0.5f), 1.0f, 1.5f), 0.75f);
  EXPECT_EQ(survival_of(Rgb(0.5f), 1.0f, 4), 1);
  EXPECT_EQ(survival_of(Rgb(1), 1.0f), 0.95f);
}

TEST(PathChoices, LightIsSmoothWhereNoPixelScatters) {
  const auto smooth = [](const char* name) { return is_smooth(SceneContext(load_scene(name), {48, 48}).context, 0.04); };
  EXPECT_TRUE(smooth("builtin:many-lamps"));
  EXPECT_TRUE(smooth("builtin:lambert-sphere"));
  EXPECT_FALSE(smooth("builtin:cornell-box"));
  EXPECT_FALSE(smooth("builtin:edge"));
}

// An even sky, a lamp and the sun over surfaces of each kind.
Scene under_the_sky() {
  SceneBuilder b("under the sky");
  b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(Diffuse{Rgb(0.6f)}));
  b.quadric(Sphere{{0.6f, 0.5f, 0.4f}, 0.5f}, b.material(Conductor{.ideal = true, .alpha = vec2(0.3f)}));
  b.quadric(Sphere{{-0.7f, 0.5f, 0}, 0.5f}, b.material(Dielectric{.eta = 1.5f}));
  b.quadric(Disk{{0, 2, 0}, 0.3f, {0, -1, 0}}, b.material(Diffuse{Rgb(0)}), Rgb(8));
  b.light(DirectionalLight{glm::normalize(vec3(1, -2, -1)), Rgb(0.4f)});
  b.light(EnvironmentLight{.scale = Rgb(0.5f), .size = {}, .texels = {}, .light_to_world = {}});
  b.camera({0, 1.6f, 4.5f}, {0, 0.6f, 0}, 42, {16, 16});
  return b.finish();
}

TEST(PathChoices, AnEvenSkyFoundByBsdfSamplesMakesTheSameImage) {
  const auto with = [](const char* mis, const char* lights) {
    ParamMap params = params_of({{"mis", mis}, {"lights", lights}});
    params["max_depth"] = {std::int64_t{4}, {}};
    return params;
  };
  testing::expect_agreement(under_the_sky(), {.resolution = {12, 12}, .block = 4, .comparisons = 1},
                            {"path", with("power", "power"), 128, 0},
                            {{"path", with("auto", "auto"), 96, 0}, {"path", with("balance", "auto"), 96, 0}});
}

}  // namespace
}  // namespace etendue
