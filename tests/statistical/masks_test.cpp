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
  if (method == std::string("vcm")) options.params = testing::params_of({{"neighbours", "1"}});
  return mean_of(under_plate(opacity), method, options);
}

// A share of the photons stops there, and as large a share of camera rays.
TEST(MaskedImages, PhotonsOnAHalfTransparentPlateStandForAll) {
  const double paths = mean_under_plate(0.5f, "path", 64);
  EXPECT_GT(paths, 0.1);
  for (const char* method : {"photon-map", "sppm", "vcm"})
    EXPECT_NEAR(mean_under_plate(0.5f, method, 16) / paths, 1, 0.04) << method;
}

// The covered shares of discs that probes find scatter there, and are measured on and on.
TEST(LongMaskedImages, DiscsOnAPlateAreWholeHoweverLongTheyAreMeasured) {
  EXPECT_NEAR(mean_under_plate(0.3f, "sppm", 256) / mean_under_plate(0.3f, "path", 1024), 1, 0.03);
}

// A dark decal a millimetre above a light floor, both in the light of a ceiling that a lamp shines at from below. The
// camera sees the decal alone.
Scene decal_on_floor(const Texture& mask) {
  SceneBuilder b("decal");
  const std::uint32_t dark = b.material(Diffuse{Rgb(0.2f)}), white = b.material(Diffuse{Rgb(0.8f)});
  const std::uint32_t black = b.material(Diffuse{Rgb(0)});
  MeshData decal = quad({-1, 1e-3f, 1}, {1, 1e-3f, 1}, {1, 1e-3f, -1}, {-1, 1e-3f, -1});
  decal.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), white);
  b.mesh(std::move(decal), dark);
  b.mesh(quad({-2, 2, -2}, {2, 2, -2}, {2, 2, 2}, {-2, 2, 2}), white);
  b.mesh(quad({-0.2f, 1, 0.2f}, {0.2f, 1, 0.2f}, {0.2f, 1, -0.2f}, {-0.2f, 1, -0.2f}), black, Rgb(10));
  b.camera({0.5f, 0.9f, 1.5f}, {0, 0, 0.2f}, 20, {16, 16});
  Scene scene = b.finish();
  scene.textures.push_back(mask);
  scene.objects[0].shapes[1].mask = 0;
  return scene;
}

// The mean over the decal, over that by path tracing, and the standard error of this.
std::pair<double, double> decal_by(const Texture& mask, const char* method, const ParamMap& params, std::uint32_t iterations) {
  constexpr int seeds = 4;
  const Scene scene = decal_on_floor(mask);
  RenderOptions options;
  options.resolution = {16, 16};
  options.iterations = 128;
  const double paths = mean_of(scene, "path", options);
  options.iterations = iterations;
  options.params = params;
  double sum = 0, squares = 0;
  for (options.seed = 1; options.seed <= seeds; ++options.seed) {
    const double ratio = mean_of(scene, method, options) / paths;
    sum += ratio / seeds;
    squares += ratio * ratio / seeds;
  }
  return {sum, std::sqrt(std::max(squares - sum * sum, 0.0) / (seeds - 1))};
}

const ImageTexture half{.size = {1, 1}, .texels = {Rgb(0.5f)}};

void expect_decal(const Texture& mask, const char* method, const ParamMap& params, std::uint32_t iterations, double off) {
  const auto [ratio, error] = decal_by(mask, method, params, iterations);
  EXPECT_NEAR(ratio, 1, off) << method << ", standard error " << error;
  EXPECT_LT(error, 0.5 * off) << method;
}

TEST(MaskedImages, PhotonsOnADecalAreNotThoseOnTheFloorBelow) {
  expect_decal(half, "photon-map", testing::params_of({{"photons", "50k"}}), 4, 0.05);
  expect_decal(half, "sppm", {}, 8, 0.04);
}

TEST(MaskedImages, MergesOnADecalAreNotThoseOnTheFloorBelow) {
  expect_decal(half, "vcm", testing::params_of({{"radius", "0.1"}, {"alpha", "1"}}), 32, 0.03);
}

TEST(MaskedImages, RecordsOnAFloorAreNotThoseOfADecalOnIt) {
  expect_decal(half, "irradiance-cache", {}, 8, 0.03);
  expect_decal(half, "hash-cache", {}, 64, 0.03);
  expect_decal(half, "photon-cache", testing::params_of({{"photons", "50k"}, {"fill", "density"}}), 4, 0.03);
}

// Holes are filled by what lies beneath: a kernel that is wider than they are takes both for one surface.
TEST(MaskedImages, DecalsWithHolesLoseNoLightAtTheirBorders) {
  const CheckerTexture holes{.even = Rgb(1), .odd = Rgb(0), .uv_scale = vec2(40)};
  expect_decal(holes, "photon-map", testing::params_of({{"photons", "50k"}}), 4, 0.04);
  expect_decal(holes, "vcm", testing::params_of({{"radius", "0.1"}, {"alpha", "1"}}), 32, 0.04);
}

TEST(LongMaskedImages, EveryMethodKeepsADecalAndTheFloorApart) {
  for (const char* method : {"photon-map", "ppm", "sppm", "ppm-memoryless", "appm", "cppm", "vcm", "photon-cache",
                             "irradiance-cache", "radiance-cache", "hash-cache", "guided", "bdpt"})
    expect_decal(half, method, method == std::string("vcm") ? testing::params_of({{"neighbours", "1"}}) : ParamMap{}, 64, 0.03);
  for (const auto& params : {testing::params_of({{"edges", "visible"}}), testing::params_of({{"edges", "hull"}}),
                             testing::params_of({{"final_gather", "16"}})})
    expect_decal(half, "photon-map", params, 16, 0.04);
  expect_decal(half, "vcm", testing::params_of({{"neighbours", "1"}, {"mis", "correlation-aware"}}), 64, 0.03);
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
