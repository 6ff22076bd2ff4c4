// Bidirectional path tracing, with merging and without, against path tracing: every kind of light, surface and lens, whose
// densities all have to be right for the weights to sum to one.
#include "framework/scene/builder.h"
#include "tests/block_agreement.h"

namespace etendue {
namespace {

using testing::AgreementMethod;
using testing::params_of;

constexpr int comparisons = 15;

void expect_agreement(const Scene& scene, const AgreementMethod& path, const std::vector<AgreementMethod>& methods) {
  testing::expect_agreement(scene, {.resolution = {16, 16}, .block = 4, .comparisons = comparisons}, path, methods);
}

// A ball of triangles with vertex normals, coarse enough for the two normals to differ.
MeshData faceted_ball(const vec3& centre, float radius) {
  MeshData mesh;
  constexpr int rings = 5, around = 8;
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j < around; ++j) {
      const float theta = pi * static_cast<float>(i) / rings, phi = 2 * pi * static_cast<float>(j) / around;
      const vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
      mesh.normals.push_back(n);
      mesh.positions.push_back(centre + radius * n);
    }
  for (std::uint32_t i = 0; i < rings; ++i)
    for (std::uint32_t j = 0; j < around; ++j) {
      const std::uint32_t a = i * around + j, b = i * around + (j + 1) % around;
      if (i > 0) mesh.triangles.push_back({a, b, a + around});
      if (i + 1 < rings) mesh.triangles.push_back({b, b + around, a + around});
    }
  return mesh;
}

// A corner with one object of each kind. `smooth`: with delta lobes, which no path tracer joins to delta lights.
SceneBuilder furnished(const char* name, bool smooth) {
  SceneBuilder b(name);
  const auto white = b.material(Diffuse{Rgb(0.7f, 0.6f, 0.5f)});
  b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), white);
  b.mesh(quad({-2, 0, -2}, {2, 0, -2}, {2, 3, -2}, {-2, 3, -2}),
         b.material(Plastic{.reflectance = {Rgb(0.3f, 0.5f, 0.7f)}, .alpha = 0.3f}));
  b.mesh(faceted_ball({-1, 0.6f, -0.6f}, 0.6f), white);
  b.quadric(Sphere{{0.2f, 0.5f, 0.4f}, 0.5f}, b.material(Dielectric{.eta = 1.5f, .alpha = smooth ? 0.0f : 0.4f}));
  b.quadric(Sphere{{1.1f, 0.5f, -0.7f}, 0.5f}, b.material(Plastic{.reflectance = {Rgb(0.6f)}, .alpha = smooth ? 0.0f : 0.25f}));
  b.mesh(box({0.9f, 0, 0.5f}, {1.4f, 0.5f, 1}),
         b.material(Conductor{.eta = Rgb(0.2f, 0.4f, 1.4f), .k = Rgb(3.9f, 2.4f, 1.6f), .alpha = vec2(0.2f, 0.4f)}));
  b.camera({0, 1.6f, 4.5f}, {0, 0.7f, 0}, 40, {16, 16});
  return b;
}

const AgreementMethod path{"path", params_of({{"max_depth", "6"}}), 128, 0};
const AgreementMethod bdpt{"bdpt", params_of({{"max_depth", "6"}}), 64, 0};
// Light paths enough for a radius small against the objects.
const AgreementMethod vcm{"vcm", params_of({{"max_depth", "6"}, {"paths", "4096"}}), 12, 0.03};
// Nothing is specular here.
const AgreementMethod merging{"vcm", params_of({{"max_depth", "6"}, {"paths", "4096"}, {"neighbours", "1"}}), 12, 0.03};

TEST(Bidirectional, CornellBoxAsPathTracing) {
  expect_agreement(load_scene("builtin:cornell-box"), {"path", {}, 128, 0},
                   {{"bdpt", {}, 64, 0}, {"bdpt", params_of({{"paths", "100"}, {"sampler", "independent"}}), 64, 0}});
}

TEST(Bidirectional, CornellBoxCutAtOneAndThreeEvents) {
  for (const char* depth : {"1", "3"})
    expect_agreement(load_scene("builtin:cornell-box"), {"path", params_of({{"max_depth", depth}}), 64, 0},
                     {{"bdpt", params_of({{"max_depth", depth}}), 32, 0}});
}

TEST(LongBidirectional, GlossyPlatesOfVeachAsPathTracing) {
  expect_agreement(load_scene("builtin:veach-mis"), {"path", {}, 512, 0}, {{"bdpt", {}, 512, 0}});
}

TEST(LongBidirectional, TwoRoomsAsPathTracing) {
  expect_agreement(load_scene("builtin:two-rooms"), {"path", {}, 1024, 0}, {{"bdpt", {}, 128, 0}});
}

TEST(Bidirectional, MirrorAndGlassAsPathTracing) {
  expect_agreement(load_scene("builtin:cornell-spheres"), {"path", {}, 512, 0},
                   {{"bdpt", {}, 64, 0}, {"vcm", params_of({{"paths", "4096"}}), 12, 0.03}});
}

TEST(Bidirectional, AreaLightsOfAllShapesAndSides) {
  SceneBuilder b = furnished("area lights", true);
  const auto black = b.material(Diffuse{Rgb(0)});
  b.quadric(Sphere{{-1, 2.2f, 0.8f}, 0.3f}, black, Rgb(6, 5, 4));
  b.quadric(Disk{{1, 2.4f, 0.2f}, 0.4f, {0, -1, 0}}, black, Rgb(3, 4, 5));
  b.quadric(Cylinder{{0, 2.0f, -1}, 0.1f, {1, 0, 0}, 0.6f, true}, b.material(Diffuse{Rgb(0.5f)}), Rgb(4));
  Scene scene = b.finish();
  expect_agreement(scene, {"path", params_of({{"max_depth", "6"}}), 256, 0}, {bdpt, vcm});
  for (Light& light : scene.lights) std::get<AreaLight>(light).two_sided = true;
  expect_agreement(scene, {"path", params_of({{"max_depth", "6"}}), 256, 0}, {bdpt, vcm});
}

// Frosted glass that glows on both sides, or on its inside alone, shows its own inside: light samples find that, too.
TEST(Bidirectional, BallsOfFrostedGlassThatGlow) {
  for (const bool inward : {false, true}) {
    SceneBuilder b("a ball that glows");
    b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(Diffuse{Rgb(0.5f)}));
    b.quadric(Sphere{{0, 0.7f, 0}, 0.6f}, b.material(Dielectric{.eta = 1.5f, .alpha = 0.5f}), Rgb(3, 2, 1), inward);
    b.camera({0, 1.2f, 3.5f}, {0, 0.7f, 0}, 40, {16, 16});
    Scene scene = b.finish();
    std::get<AreaLight>(scene.lights[0]).two_sided = !inward;
    const auto cut = [](const char* mis) { return params_of({{"mis", mis}, {"max_depth", "3"}}); };
    expect_agreement(
        scene, {"path", cut("bsdf"), 256, 0},
        {{"path", cut("light"), 256, 0}, {"path", cut("power"), 128, 0}, {"bdpt", params_of({{"max_depth", "3"}}), 64, 0}});
  }
}

TEST(Bidirectional, PointSpotAndDirectionalLights) {
  SceneBuilder b = furnished("delta lights", false);
  b.light(PointLight{{-1, 2.2f, 0.8f}, Rgb(3, 2, 2)});
  b.light(SpotLight{{1, 2.5f, 1}, glm::normalize(vec3(-0.3f, -1, -0.4f)), Rgb(8, 8, 12), 0.8f, 0.9f});
  b.light(DirectionalLight{glm::normalize(vec3(-0.4f, -1, -0.3f)), Rgb(1, 1, 0.6f)});
  expect_agreement(b.finish(), path, {bdpt, vcm});
}

EnvironmentLight gradient_environment() {
  EnvironmentLight light{
      .scale = Rgb(0.8f, 0.9f, 1), .size = {8, 4}, .texels = {}, .light_to_world = Transform::rotate(1.1f, {1, 0, 0})};
  for (int i = 0; i < 32; ++i) light.texels.push_back(i == 11 ? Rgb(8, 7, 5) : Rgb(0.1f + 0.02f * static_cast<float>(i)));
  return light;
}

TEST(Bidirectional, EnvironmentsOfConstantAndImage) {
  SceneBuilder b = furnished("environments", true);
  b.light(EnvironmentLight{.scale = Rgb(0.3f), .size = {}, .texels = {}, .light_to_world = {}});
  b.light(gradient_environment());
  expect_agreement(b.finish(), path, {bdpt, vcm});
}

TEST(Bidirectional, InfinitePlanesUnderAnEnvironmentAndTheSun) {
  SceneBuilder b("planes");
  const auto white = b.material(Diffuse{Rgb(0.6f)});
  b.quadric(Sphere{{0, 0.8f, 0}, 0.5f}, b.material(Plastic{.alpha = 0.3f}));
  b.plane({{0, 0, 0}, {0, 1, 0}, white});
  b.plane({{0, 0, -4}, {0, 0, 1}, white});
  b.light(gradient_environment());
  b.light(DirectionalLight{glm::normalize(vec3(-0.4f, -1, -0.3f)), Rgb(1, 1, 0.6f)});
  b.camera({0, 1.6f, 4.5f}, {0, 0.7f, 0}, 50, {16, 16});
  expect_agreement(b.finish(), path, {bdpt, merging});
}

// Rounding puts the lamp to one side of a tilted ceiling or the other: its light falls on the floor all the same, as light
// samples find it.
Scene lamp_in_a_ceiling(float tilt) {
  SceneBuilder b("lamp in a ceiling");
  const Transform roof = Transform::translate({0, 1.9f, 0}) * Transform::rotate(tilt * pi / 180, {0, 0, 1});
  const auto white = b.material(Diffuse{Rgb(0.5f)});
  b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), white);
  b.mesh(transformed(quad({-3, 0, -3}, {3, 0, -3}, {3, 0, 3}, {-3, 0, 3}), roof), white);
  b.light(PointLight{roof.point({0.37f, 0, 0.21f}), Rgb(3)});
  b.camera({0, 0.9f, 2.5f}, {0, 0.6f, 0}, 60, {16, 16});
  return b.finish();
}

double mean_of(const Scene& scene, const char* method, const ParamMap& params, std::uint32_t iterations) {
  const testing::RenderOptions options{.params = params, .iterations = iterations, .resolution = {16, 16}};
  return testing::block_means(testing::render(scene, method, options).image, 16).front().y;
}

TEST(Bidirectional, LampsInACeilingSendAllTheirLight) {
  for (const float tilt : {10.0f, 17.0f}) {
    const Scene scene = lamp_in_a_ceiling(tilt);
    const double paths = mean_of(scene, "path", params_of({{"max_depth", "1"}}), 16);
    EXPECT_NEAR(mean_of(scene, "light-trace", params_of({{"max_depth", "1"}, {"paths", "8192"}}), 64) / paths, 1, 0.03) << tilt;
    EXPECT_NEAR(mean_of(scene, "bdpt", params_of({{"max_depth", "1"}}), 64) / paths, 1, 0.02) << tilt;
  }
}

TEST(Photons, OfALampInACeilingAreAllSent) {
  for (const float tilt : {10.0f, 17.0f}) {
    const Scene scene = lamp_in_a_ceiling(tilt);
    const double paths = mean_of(scene, "path", params_of({{"max_depth", "4"}}), 512);
    for (const auto& [method, samples] : {std::pair("photon-map", "0"), std::pair("photon-cache", "32")}) {
      ParamMap params = params_of({{"max_depth", "4"}, {"photons", "20000"}});
      if (samples != std::string("0")) params.merge(params_of({{"samples", samples}}));
      EXPECT_NEAR(mean_of(scene, method, params, 8) / paths, 1, 0.03) << method << ' ' << tilt;
    }
  }
}

TEST(Bidirectional, ThinLens) {
  SceneBuilder b = furnished("lens", false);
  b.quadric(Sphere{{-1, 2.2f, 0.8f}, 0.3f}, b.material(Diffuse{Rgb(0)}), Rgb(6, 5, 4));
  Scene scene = b.finish();
  scene.camera.lens_radius = 0.25f;
  scene.camera.focal_distance = 3.5f;
  expect_agreement(scene, path, {bdpt, vcm});
}

TEST(Bidirectional, ParallelView) {
  SceneBuilder b = furnished("parallel", false);
  b.quadric(Sphere{{-1, 2.2f, 0.8f}, 0.3f}, b.material(Diffuse{Rgb(0)}), Rgb(6, 5, 4));
  Scene scene = b.finish();
  scene.camera.half_width = 1.5f;
  expect_agreement(scene, path, {bdpt, vcm});
}

}  // namespace
}  // namespace etendue
