// Sheets that light passes, whatever the method. Panes let it straight on: what they let through and mirror, against
// 2 R / (1 + R), R being Fresnel's factor of a side. Leaves scatter it: both sides of one between two lights of closed form.
#include "framework/materials/fresnel.h"
#include "framework/scene/builder.h"
#include "tests/block_agreement.h"

#include <gtest/gtest.h>

namespace etendue::panes {
namespace {

using testing::render;
using testing::RenderOptions;

constexpr float index_of_pane = 1.5f;
const Rgb mirrored(0.5f, 0.6f, 0.7f), passed(0.9f, 0.8f, 0.7f);

Dielectric pane() { return {.eta = index_of_pane, .reflect_tint = mirrored, .transmit_tint = passed, .thin = true}; }

float reflectance(float cosine) {
  const float once = fresnel_dielectric(cosine, index_of_pane);
  return 2 * once / (1 + once);
}

dvec3 mean_of(const Scene& scene, const char* method, std::uint32_t iterations) {
  RenderOptions options;
  options.resolution = {8, 8};
  options.iterations = iterations;
  return testing::block_means(render(scene, method, options).image, options.resolution.x).front();
}

// A black square under the sky, seen in a pane at the cosine of the angle: the sky by way of the pane, and nothing through it.
Scene pane_in_sky(float cosine, bool from_below, bool black_behind) {
  SceneBuilder b("pane");
  b.mesh(quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}), b.material(pane()));
  const float side = from_below ? -1.0f : 1.0f, sine = std::sqrt(1 - cosine * cosine);
  const float hidden = black_behind ? -side : side;
  if (hidden > 0)
    b.mesh(quad({-9, 8, -9}, {9, 8, -9}, {9, 8, 9}, {-9, 8, 9}), b.material(Diffuse{Rgb(0)}));
  else
    b.mesh(quad({-9, -8, 9}, {9, -8, 9}, {9, -8, -9}, {-9, -8, -9}), b.material(Diffuse{Rgb(0)}));
  b.light(EnvironmentLight{.scale = Rgb(1), .size = {}, .texels = {}, .light_to_world = {}});
  b.camera(5.0f * vec3(sine, side * cosine, 0), {0, 0, 0}, 1, {8, 8}, {0, 0, 1});
  return b.finish();
}

TEST(Panes, MirrorAndLetThroughByTheAngle) {
  for (const char* method : {"path", "bdpt", "photon-map"})
    for (const bool from_below : {false, true})
      for (const float cosine : {0.98f, 0.7f}) {
        const dvec3 reflected = mean_of(pane_in_sky(cosine, from_below, true), method, 512);
        const dvec3 through = mean_of(pane_in_sky(cosine, from_below, false), method, 512);
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(reflected[c] / (reflectance(cosine) * mirrored[c]), 1, 0.03) << method << cosine << from_below;
          EXPECT_NEAR(through[c] / ((1 - reflectance(cosine)) * passed[c]), 1, 0.01) << method << cosine << from_below;
        }
      }
}

// A floor under a lamp, with a pane between them or not.
Scene floor_under_pane(bool with_pane, bool two_panes) {
  SceneBuilder b("floor under pane");
  b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(Diffuse{Rgb(0.5f)}));
  b.quadric(Disk{.centre = {0, 2, 0}, .radius = 0.6f, .normal = {0, -1, 0}}, b.material(Diffuse{Rgb(0)}), Rgb(10));
  const auto glass = b.material(pane());
  if (with_pane) b.mesh(quad({-5, 1, 5}, {5, 1, 5}, {5, 1, -5}, {-5, 1, -5}), glass);
  if (two_panes) b.mesh(quad({-5, 1.2f, 5}, {5, 1.2f, 5}, {5, 1.2f, -5}, {-5, 1.2f, -5}), glass);
  b.camera({0.4f, 0.5f, 0}, {0, 0, 0}, 6, {8, 8});
  b.max_depth(two_panes ? 3 : 2);
  return b.finish();
}

TEST(Panes, DimWhatTheLampSendsThrough) {
  const double open = mean_of(floor_under_pane(false, false), "path", 64).y;
  const double once = (1 - reflectance(1)) * passed.y;
  for (const auto& [method, iterations] : {std::pair{"path", 1024u},
                                           {"bdpt", 256u},
                                           {"photon-map", 16u},
                                           {"sppm", 64u},
                                           {"guided", 1024u},
                                           {"irradiance-cache", 64u}})
    EXPECT_NEAR(mean_of(floor_under_pane(true, false), method, iterations).y / open / once, 1, 0.04) << method;
  EXPECT_NEAR(mean_of(floor_under_pane(true, true), "bdpt", 256).y / open / (once * once), 1, 0.03);
}

// A leaf under a disk that emits downwards, of which half the light leaves the upper side and the other half the lower one.
Scene leaf_under_lamp(bool from_below, const Rgb& reflectance, const Rgb& transmittance) {
  SceneBuilder b("leaf");
  b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(DiffuseTransmission{reflectance, transmittance}));
  b.quadric(Disk{.centre = {0, 1, 0}, .radius = 1, .normal = {0, -1, 0}}, b.material(Diffuse{Rgb(0)}), Rgb(10));
  b.camera({0.9f, from_below ? -0.6f : 0.6f, 0}, {0, 0, 0}, 3, {8, 8});
  return b.finish();
}

TEST(Leaves, ShowTheLightOfOneSideOnBoth) {
  const Rgb reflectance(0.1f, 0.2f, 0.3f), transmittance(0.5f, 0.4f, 0.3f);
  for (const auto& [method, iterations] : {std::pair{"path", 64u},
                                           {"bdpt", 64u},
                                           {"vcm", 64u},
                                           {"photon-map", 8u},
                                           {"sppm", 32u},
                                           {"guided", 64u},
                                           {"irradiance-cache", 16u},
                                           {"hash-cache", 64u},
                                           {"light-trace", 2048u}})
    for (const bool from_below : {false, true}) {
      const dvec3 seen = mean_of(leaf_under_lamp(from_below, reflectance, transmittance), method, iterations);
      const Rgb expected = 5.0f * (from_below ? transmittance : reflectance);
      const double off = method == std::string("light-trace") ? 0.06 : 0.03;
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c] / expected[c], 1, off) << method << (from_below ? " below" : " above");
    }
}

// Two leaves in an even sky send on all that they take up: everything is as bright as the sky.
TEST(Leaves, OfNoLossAreAsBrightAsTheSky) {
  SceneBuilder b("leaves");
  const auto leaf = b.material(DiffuseTransmission{Rgb(0.4f), Rgb(0.6f)});
  b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), leaf);
  b.mesh(quad({-2, 1, 2}, {2, 1, 2}, {2, 1, -2}, {-2, 1, -2}), leaf);
  b.light(EnvironmentLight{.scale = Rgb(1), .size = {}, .texels = {}, .light_to_world = {}});
  b.camera({0.5f, 3, 0}, {0, 0, 0}, 10, {8, 8});
  const Scene scene = b.finish();
  for (const char* method : {"path", "bdpt"}) EXPECT_NEAR(mean_of(scene, method, 64).y, 1, 0.02) << method;
}

}  // namespace
}  // namespace etendue::panes
