// Masks in images: a plate of a given opacity before a light dims it by that, whatever the method and structure.
#include "framework/scene/builder.h"
#include "tests/block_agreement.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::render;
using testing::RenderOptions;

// A floor under a lamp, and between them a black plate that the camera is below.
Scene floor_under_plate(float opacity) {
  SceneBuilder b("plate");
  b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(Diffuse{Rgb(0.5f)}));
  b.mesh(quad({-5, 1, -5}, {5, 1, -5}, {5, 1, 5}, {-5, 1, 5}), b.material(Diffuse{Rgb(0)}));
  b.mesh(quad({-0.5f, 2, -0.5f}, {0.5f, 2, -0.5f}, {0.5f, 2, 0.5f}, {-0.5f, 2, 0.5f}), b.material(Diffuse{Rgb(0)}), Rgb(10));
  b.camera({0, 0.8f, 1.2f}, {0, 0, 0}, 40, {16, 16});
  Scene scene = b.finish();
  scene.textures.push_back(ImageTexture{.size = {1, 1}, .texels = {Rgb(opacity)}});
  scene.objects[0].shapes[1].mask = 0;
  return scene;
}

double mean_of(const Scene& scene, const char* method, const RenderOptions& options) {
  const testing::Rendered rendered = render(scene, method, options);
  EXPECT_EQ(rendered.non_finite, 0u);
  return testing::block_means(rendered.image, options.resolution.x).front().y;
}

TEST(MaskedImages, AHalfTransparentPlateHalvesTheLight) {
  RenderOptions options;
  options.resolution = {16, 16};
  options.iterations = 64;
  const double open = mean_of(floor_under_plate(0), "path", options);
  EXPECT_GT(open, 0.1);
  EXPECT_EQ(mean_of(floor_under_plate(1), "path", options), 0);
  for (const char* method :
       {"path", "bdpt", "photon-map", "sppm", "guided", "irradiance-cache", "photon-cache", "hash-cache", "vcm"})
    EXPECT_NEAR(mean_of(floor_under_plate(0.5f), method, options) / open, 0.5, 0.03) << method;
  EXPECT_NEAR(mean_of(floor_under_plate(0.5f), "light-trace", options) / open, 0.5, 0.05);
  EXPECT_NEAR(mean_of(floor_under_plate(0.25f), "path", options) / open, 0.75, 0.03);
}

// The plate's underside in the light of the floor.
Scene under_plate(float opacity) {
  Scene scene = floor_under_plate(opacity);
  scene.materials[1] = Diffuse{Rgb(0.8f)};
  scene.camera.to_world = *Transform::look_at({0, 0.2f, 0.5f}, {0, 1, 0}, {0, 1, 0});
  return scene;
}

double mean_under_plate(float opacity, const char* method, std::uint32_t iterations) {
  RenderOptions options;
  options.resolution = {16, 16};
  options.iterations = iterations;
  return mean_of(under_plate(opacity), method, options);
}

// A share of the photons stops there, and as large a share of camera rays.
TEST(MaskedImages, PhotonsOnAHalfTransparentPlateStandForAll) {
  const double paths = mean_under_plate(0.5f, "path", 64);
  EXPECT_GT(paths, 0.1);
  for (const char* method : {"photon-map", "sppm", "vcm"})
    EXPECT_NEAR(mean_under_plate(0.5f, method, 16) / paths, 1, 0.04) << method;
}

// What probes find of discs scatters there, and is measured on and on.
TEST(LongMaskedImages, DiscsOnAPlateAreWholeHoweverLongTheyAreMeasured) {
  EXPECT_NEAR(mean_under_plate(0.3f, "sppm", 256) / mean_under_plate(0.3f, "path", 1024), 1, 0.03);
}

TEST(MaskedImages, StructuresAgree) {
  RenderOptions options;
  options.resolution = {16, 16};
  options.iterations = 32;
  const double open = mean_of(floor_under_plate(0), "path", options);
  for (const RayEntry& entry : ray_structures()) {
    if (!entry.available) continue;
    options.accel = entry.name;
    EXPECT_NEAR(mean_of(floor_under_plate(0.5f), "path", options) / open, 0.5, 0.04) << entry.name;
  }
}

}  // namespace
}  // namespace etendue
