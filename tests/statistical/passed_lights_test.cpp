// Lights that let rays through, against closed forms: of a floor under a disk that emits downwards, with the sky above all of
// it and a directional light straight down, whatever the method.
#include "framework/scene/builder.h"
#include "tests/block_agreement.h"

#include <gtest/gtest.h>

namespace etendue::passed_lights {
namespace {

using testing::render;
using testing::RenderOptions;

constexpr float radius = 1, height = 1, lamp = 5, sky = 1, sun = 2, grey = 0.5f;
constexpr float lamp_share = radius * radius / (radius * radius + height * height);  // of the floor's irradiance under the axis

struct Look {
  vec3 eye, target;
};
// A spot of the floor straight under the middle of the lamp, seen past it and through it; and the lamp, from below.
constexpr Look past_lamp{{1.9f, 0.9f, 0}, {0, 0, 0}}, through_lamp{{0.02f, 4, 0}, {0, 0, 0}},
    at_lamp{{0, 0.5f, 0}, {0.02f, 1, 0}};

Scene passed(Scene scene, float opacity) {
  scene.textures.push_back(ImageTexture{.size = {1, 1}, .texels = {Rgb(opacity)}});
  for (Shape& shape : scene.objects[0].shapes)
    if (shape.first_light != no_id) shape.mask = 0;
  return scene;
}

Scene lit_floor(const Look& look, float opacity, const Quadric& light, bool with_sun, bool inward = false) {
  SceneBuilder b("passed light");
  b.mesh(quad({-4, 0, 4}, {4, 0, 4}, {4, 0, -4}, {-4, 0, -4}), b.material(Diffuse{Rgb(grey)}));
  b.quadric(light, b.material(Diffuse{Rgb(0)}), Rgb(lamp), inward);
  b.light(EnvironmentLight{.scale = Rgb(sky), .size = {}, .texels = {}, .light_to_world = {}});
  if (with_sun) b.light(DirectionalLight{.direction = {0, -1, 0}, .irradiance = Rgb(sun)});
  b.camera(look.eye, look.target, 3, {8, 8}, {0, 0, 1});
  return passed(b.finish(), opacity);
}

Scene under_disk(const Look& look, float opacity, bool with_sun = false) {
  return lit_floor(look, opacity, Disk{.centre = {0, height, 0}, .radius = radius, .normal = {0, -1, 0}}, with_sun);
}

double mean_of(const Scene& scene, const char* method, std::uint32_t iterations, const ParamMap& params = {}) {
  RenderOptions options;
  options.resolution = {8, 8};
  options.iterations = iterations;
  options.params = params;
  const testing::Rendered rendered = render(scene, method, options);
  EXPECT_EQ(rendered.non_finite, 0u);
  return testing::block_means(rendered.image, options.resolution.x).front().y;
}

constexpr const char* methods[] = {"path",   "bdpt",       "vcm",          "photon-map",       "sppm",
                                   "guided", "hash-cache", "photon-cache", "irradiance-cache", "radiance-cache"};

TEST(PassedLights, LightTheFloorAndHideNothing) {
  const double floor = grey * (lamp * lamp_share + sky);
  for (const char* method : methods) {
    EXPECT_NEAR(mean_of(under_disk(past_lamp, 0), method, 64) / floor, 1, 0.02) << method;
    EXPECT_NEAR(mean_of(under_disk(through_lamp, 0), method, 64) / floor, 1, 0.02) << method << ", through the lamp";
    EXPECT_NEAR(mean_of(under_disk(at_lamp, 0), method, 4) / (lamp + sky), 1, 1e-4) << method << ", at the lamp";
  }
  EXPECT_NEAR(mean_of(under_disk(through_lamp, 0), "light-trace", 2048) / floor, 1, 0.05);
  EXPECT_NEAR(mean_of(under_disk(at_lamp, 0), "light-trace", 4) / (lamp + sky), 1, 1e-4);
}

TEST(PassedLights, LetTheLightOfPointsThrough) {
  const double floor = grey * (lamp * lamp_share + sky + sun / pi);
  for (const char* method : {"path", "bdpt", "vcm", "photon-map", "sppm", "irradiance-cache"})
    EXPECT_NEAR(mean_of(under_disk(past_lamp, 0, true), method, 64) / floor, 1, 0.02) << method;
}

TEST(PassedLights, AreFoundByEitherStrategyAlone) {
  const double floor = grey * (lamp * lamp_share + sky);
  for (const char* mis : {"light", "bsdf", "balance", "power"})
    EXPECT_NEAR(mean_of(under_disk(past_lamp, 0), "path", 256, testing::params_of({{"mis", mis}})) / floor, 1, 0.02) << mis;
}

// The lamp hides half of the sky behind it, and emits as if it hid nothing or all.
TEST(PassedLights, EmitAllAndStopAShare) {
  const double floor = grey * (lamp * lamp_share + sky * (1 - 0.5 * lamp_share));
  for (const char* method : {"path", "bdpt", "vcm", "photon-map", "sppm", "guided", "hash-cache", "irradiance-cache"}) {
    EXPECT_NEAR(mean_of(under_disk(past_lamp, 0.5f), method, 128) / floor, 1, 0.02) << method;
    EXPECT_NEAR(mean_of(under_disk(at_lamp, 0.5f), method, 64) / (lamp + 0.5 * sky), 1, 0.02) << method << ", at the lamp";
  }
}

// The far side of a sphere that emits inwards is seen through the near one.
TEST(PassedLights, ShowTheInsideOfASphere) {
  const double seen = square(0.5 / height);  // sine of its half angle, squared
  for (const bool inward : {false, true})
    for (const char* method : {"path", "bdpt", "photon-map", "sppm"})
      EXPECT_NEAR(mean_of(lit_floor(past_lamp, 0, Sphere{{0, height, 0}, 0.5f}, false, inward), method, 256) /
                      (grey * (lamp * seen + sky)),
                  1, 0.02)
          << method << (inward ? ", inward" : "");
}

}  // namespace
}  // namespace etendue::passed_lights
