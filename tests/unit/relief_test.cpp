// The shading normals of bump and normal maps.
#include "framework/materials/relief.h"
#include "framework/scene/builder.h"
#include "tests/render_scene.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

void expect_close(const vec3& a, const vec3& b, float tolerance) {
  EXPECT_LE(glm::length(a - b), tolerance) << a.x << ' ' << a.y << ' ' << a.z << " is not " << b.x << ' ' << b.y << ' ' << b.z;
}

// Heights that rise by 4 from u = 0 to 1, and by 2 from v = 0 to 1, but for half a texel at the edges.
ImageTexture ramp() {
  constexpr int side = 8;
  ImageTexture image{.size = ivec2(side), .texels = {}};
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i)
      image.texels.emplace_back((4.0f * static_cast<float>(i) - 2.0f * static_cast<float>(j)) / side);
  return image;
}

// A parallelogram with edges `a` and `b` along u and v.
Scene slope_with(const Relief& relief, const Texture& texture, const vec3& a, const vec3& b) {
  SceneBuilder builder("relief");
  builder.mesh(quad(vec3(0), a, a + b, b), builder.material(Diffuse{}));
  Scene scene = builder.finish();
  scene.textures = {texture};
  scene.reliefs = {relief};
  finish_scene(scene, {});
  return scene;
}

vec3 normal_in_the_middle(const Scene& scene, std::uint32_t instance = 0) {
  const Hit hit{.t = 1, .uv = {0.25f, 0.3f}, .instance = instance, .primitive = 0};
  return scene.surface_at(Ray{.origin = {0, 0, 5}, .direction = {0, 0, -1}}, hit).shading_normal;
}

// The normal of the surface that is lifted by h n: the cross product of its derivatives.
vec3 lifted(const vec3& a, const vec3& b, const vec2& slopes) {
  const vec3 n = glm::normalize(glm::cross(a, b));
  return glm::normalize(glm::cross(a + slopes.x * n, b + slopes.y * n));
}

TEST(Relief, TurnsTheNormalAsTheLiftedSurface) {
  const vec3 a(3, 0.5f, 0), b(1, 2, 0.4f);
  const Scene scene = slope_with({.scale = 0.25f}, ramp(), a, b);
  EXPECT_TRUE(scene.objects[0].shapes[0].uses_uvs);
  expect_close(normal_in_the_middle(scene), lifted(a, b, {1, 0.5f}), 1e-5f);
}

TEST(Relief, HeightsAreOnTheOuterSideWhereNormalsAreFlipped) {
  const vec3 a(3, 0, 0), b(0, 2, 0);
  Scene scene = slope_with({}, ramp(), a, b);
  scene.objects[0].shapes[0].flip_normal = true;
  const vec3 up = lifted(a, b, {4, 2}), down = normal_in_the_middle(scene);
  expect_close(down, {up.x, up.y, -up.z}, 1e-5f);
}

TEST(Relief, HeightsAreMetresOfTheWorldOnInstances) {
  const vec3 a(3, 0, 0), b(0, 2, 0);
  Scene scene = slope_with({}, ramp(), a, b);
  scene.objects.push_back(scene.objects[0]);
  scene.instances.push_back({1, Transform::scale(vec3(4))});
  expect_close(normal_in_the_middle(scene, 1), lifted(4.0f * a, 4.0f * b, {4, 2}), 1e-5f);
}

TEST(Relief, NormalMapsStateTheNormalAboutTheSurfacesOwn) {
  const vec3 a(3, 0, 0), b(0, 2, 0), tilt = glm::normalize(vec3(0.3f, -0.2f, 0.9f));
  const ImageTexture flat{.size = {1, 1}, .texels = {Rgb(0.5f, 0.5f, 1)}},
      tilted{.size = {1, 1}, .texels = {0.5f * tilt + 0.5f}};
  const Relief map{.kind = Relief::Kind::normals};
  expect_close(normal_in_the_middle(slope_with(map, flat, a, b)), {0, 0, 1}, 1e-6f);
  expect_close(normal_in_the_middle(slope_with(map, tilted, a, b)), tilt, 1e-6f);
  // Along dp/du, whatever v does: turned by a quarter, x points along y.
  expect_close(normal_in_the_middle(slope_with(map, tilted, b, -a)), {-tilt.y, tilt.x, tilt.z}, 1e-6f);
}

TEST(Relief, KeepsToTheSideOfTheGeometricNormal) {
  const ImageTexture inward{.size = {1, 1}, .texels = {Rgb(0.9f, 0.5f, 0.2f)}};
  EXPECT_GT(normal_in_the_middle(slope_with({.kind = Relief::Kind::normals}, inward, {1, 0, 0}, {0, 1, 0})).z, 0);
}

TEST(Relief, WithoutAreaInTextureSpaceThereIsNone) {
  Scene scene = slope_with({}, ramp(), {1, 0, 0}, {0, 1, 0});
  for (vec2& uv : scene.objects[0].uvs) uv = vec2(0.5f);
  expect_close(normal_in_the_middle(scene), {0, 0, 1}, 0);
}

// Irradiance that is computed once is that of the surface: slopes of two fifths receive less, so that rays gather photons
// there.
TEST(Relief, IsSeenByGatherRays) {
  SceneBuilder builder("bumpy room");
  const auto bumpy = builder.material(Diffuse{Rgb(0.7f)});
  const vec3 p[8] = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}, {1, 1, 1}};
  constexpr int faces[5][4] = {{0, 1, 5, 4}, {2, 6, 7, 3}, {4, 5, 7, 6}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : faces) builder.mesh(quad(p[f[0]], p[f[1]], p[f[2]], p[f[3]]), bumpy);
  builder.mesh(quad({-0.4f, 0.9f, -0.4f}, {0.4f, 0.9f, -0.4f}, {0.4f, 0.9f, 0.4f}, {-0.4f, 0.9f, 0.4f}),
               builder.material(Diffuse{}), Rgb(10));
  builder.camera({0, 0, -4}, {0, 0, 0}, 40, {16, 16});
  Scene scene = builder.finish();
  ImageTexture bumps{.size = ivec2(8), .texels = {}};
  for (int i = 0; i < 64; ++i) bumps.texels.emplace_back((i + i / 8) % 2 == 0 ? 0.0f : 0.1f);
  scene.textures = {bumps};
  scene.reliefs = {Relief{.material = bumpy}};
  finish_scene(scene, {});
  const auto mean = [&](std::int64_t precompute) {
    testing::RenderOptions options;
    options.iterations = 8;
    options.resolution = {16, 16};
    options.params = {
        {"photons", {std::int64_t{20000}, {}}}, {"final_gather", {std::int64_t{16}, {}}}, {"precompute", {precompute, {}}}};
    double sum = 0;
    for (const dvec3& pixel : testing::render(scene, "photon-map", options).image.pixels) sum += pixel.y;
    return sum;
  };
  EXPECT_NEAR(mean(4) / mean(0), 1, 0.01);
}

// Slopes that are seen from behind reflect light from between their planes and the surface alone: here that of a wall behind
// the eye. Records hold what comes to the other side, or, of the density of photons, what the surface receives.
TEST(Relief, RecordsDoNotAnswerWhereItIsSeenFromBehind) {
  SceneBuilder builder("slope");
  const auto white = builder.material(Diffuse{Rgb(0.8f)});
  builder.mesh(quad({2, 0, 2}, {2, 0, -2}, {-2, 0, -2}, {-2, 0, 2}), builder.material(Diffuse{Rgb(0.8f)}));
  builder.mesh(quad({-6, 0, -6}, {6, 0, -6}, {6, 6, -6}, {-6, 6, -6}), white);
  builder.mesh(quad({-0.5f, 2.5f, -4}, {-0.5f, 3.5f, -4}, {0.5f, 3.5f, -4}, {0.5f, 2.5f, -4}), white, Rgb(10));
  builder.camera({0, 1.2f, -5}, {0, 0, 0}, 20, {8, 8});
  Scene scene = builder.finish();
  scene.textures = {ramp()};
  scene.reliefs = {Relief{.material = 1}};
  finish_scene(scene, {});
  const auto mean = [&](const std::string& method, std::uint32_t iterations, const ParamMap& params = {}) {
    testing::RenderOptions options;
    options.iterations = iterations;
    options.resolution = {8, 8};
    options.params = params;
    double sum = 0;
    for (const dvec3& pixel : testing::render(scene, method, options).image.pixels) sum += pixel.y;
    return sum;
  };
  const double paths = mean("path", 1024);
  EXPECT_NEAR(mean("irradiance-cache", 64) / paths, 1, 0.15);
  EXPECT_NEAR(mean("radiance-cache", 64) / paths, 1, 0.15);
  EXPECT_NEAR(mean("hash-cache", 64) / paths, 1, 0.15);
  EXPECT_NEAR(mean("photon-cache", 32) / paths, 1, 0.15);
  EXPECT_NEAR(mean("photon-cache", 16, {{"fill", {std::string("density"), {}}}}) / paths, 1, 0.07);
}

TEST(Relief, ChangesTheHashOfTheScene) {
  const Scene with = slope_with({}, ramp(), {1, 0, 0}, {0, 1, 0});
  Scene without = with;
  without.reliefs.clear();
  EXPECT_NE(with.content_hash(), without.content_hash());
}

}  // namespace
}  // namespace etendue
