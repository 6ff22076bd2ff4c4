// Transport is written once over lanes: an instruction set changes how many go together, and no bit of the result. (Images of
// whole runs are compared in tests/unit/isa_test.cpp.)
#include "framework/core/isa.h"
#include "framework/core/sampling.h"
#include "integrators/registry.h"
#include "tests/image_checks.h"

#include <gtest/gtest.h>

#include <numbers>

namespace etendue {
namespace {

struct Case {
  std::string name;
  Material material;
};

std::vector<Case> every_material() {
  const Rgb eta(0.2f, 0.9f, 1.1f), k(3.9f, 2.5f, 2.2f);
  TexturedRgb checkered;
  checkered.texture = 0;
  return {{"diffuse", Diffuse{Rgb(0.7f)}},
          {"checkered", Diffuse{checkered}},
          {"mirror", Conductor{.tint = Rgb(0.9f), .ideal = true}},
          {"rough metal", Conductor{.eta = eta, .k = k, .alpha = vec2(0.3f)}},
          {"brushed metal", Conductor{.eta = eta, .k = k, .alpha = vec2(0.1f, 0.4f)}},
          {"glass", Dielectric{.eta = 1.5f}},
          {"pane", Dielectric{.eta = 1.5f, .thin = true}},
          {"rough glass", Dielectric{.eta = 1.5f, .alpha = 0.3f}},
          {"leaf", DiffuseTransmission{checkered, Rgb(0.2f)}},
          {"plastic", Plastic{.reflectance = Rgb(0.6f)}},
          {"rough plastic", Plastic{.reflectance = checkered, .alpha = 0.2f}},
          {"dimming plastic", Plastic{.reflectance = checkered, .coat = {1.5f, 0.3f}, .alpha = 0.2f}},
          {"Beckmann metal",
           Conductor{.eta = eta, .k = k, .alpha = vec2(0.1f, 0.4f), .distribution = NormalDistribution::beckmann}},
          {"Beckmann glass", Dielectric{.eta = 1.5f, .alpha = 0.3f, .distribution = NormalDistribution::beckmann}},
          {"Beckmann plastic", Plastic{.alpha = 0.2f, .distribution = NormalDistribution::beckmann}}};
}

class Lanes : public ::testing::Test {
 protected:
  void TearDown() override { choose_isa(supported_isas().back()); }

  static void expect_same_bits(const Scene& scene, const std::vector<std::string>& methods, const std::string& what,
                               const ParamMap& params = {}) {
    testing::RenderOptions options;
    options.params = params;
    options.resolution = ivec2(20, 20);
    options.iterations = 2;
    for (const std::string& method : methods) {
      choose_isa(Isa::scalar);
      const Image one = testing::render(scene, method, options).image;
      for (const Isa isa : supported_isas()) {
        choose_isa(isa);
        EXPECT_EQ(testing::render(scene, method, options).image.pixels, one.pixels)
            << method << ", " << what << ", " << isa_name(isa);
      }
    }
  }
};

TEST_F(Lanes, EveryMaterialGivesTheSameBitsAtEveryWidth) {
  for (const Case& c : every_material())
    for (const char* name : {"builtin:cornell-box", "builtin:mesh?triangles=1000"}) {
      Scene scene = load_scene(name);
      scene.textures = {CheckerTexture{Rgb(0.8f), Rgb(0.1f), vec2(7), vec2(0)}};
      scene.materials.back() = c.material;  // others stay, so that runs of several materials meet
      expect_same_bits(scene, {"path"}, c.name + " in " + name);
      expect_same_bits(scene, {"photon-map"}, c.name + " in " + name, {{"photons", {std::int64_t{4000}, {}}}});
    }
}

TEST_F(Lanes, EveryLightGivesTheSameBitsAtEveryWidth) {
  const Scene room = load_scene("builtin:cornell-spheres");
  const std::vector<std::pair<const char*, Light>> lights = {{"point", PointLight{vec3(0.1f), Rgb(2)}},
                                                             {"spot", SpotLight{vec3(0), vec3(0, 0, 1), Rgb(3)}},
                                                             {"sun", DirectionalLight{}},
                                                             {"sky", EnvironmentLight{}}};
  for (const auto& [name, light] : lights) {
    Scene scene = room;
    scene.lights.push_back(light);
    expect_same_bits(scene, {"path"}, name);
    expect_same_bits(scene, {"photon-map"}, name, {{"photons", {std::int64_t{4000}, {}}}});
  }
  Scene many = room;
  for (int i = 0; i < 12; ++i) many.lights.emplace_back(PointLight{vec3(0.05f * static_cast<float>(i)), Rgb(0.1f)});
  expect_same_bits(many, {"path"}, "many lights");
}

// A room of triangles with texture coordinates from their positions.
Scene with_uvs(Scene scene) {
  Object& world = scene.objects[0];
  world.uvs.clear();
  for (const vec3& p : world.geometry.positions) world.uvs.emplace_back(3 * p.x + p.z, 2 * p.y - p.z);
  for (Shape& shape : world.shapes) shape.has_uvs = shape.uses_uvs = true;
  return scene;
}

TEST_F(Lanes, ReliefAndImagesOfLightsGiveTheSameBitsAtEveryWidth) {
  Scene scene = with_uvs(load_scene("builtin:cornell-box"));
  ImageTexture image{.size = {3, 2}, .texels = {Rgb(0.1f), Rgb(0.9f), Rgb(0.3f), Rgb(0.5f), Rgb(0), Rgb(0.7f)}};
  scene.textures = {image};
  for (auto& light : scene.lights)
    if (auto* area = std::get_if<AreaLight>(&light)) area->texture = 0;
  expect_same_bits(scene, {"path", "photon-map"}, "image on the light");
  for (std::uint32_t m = 0; m < scene.materials.size(); ++m)
    scene.reliefs.push_back({m % 2 ? Relief::Kind::normals : Relief::Kind::heights, m, 0, 0.02f});
  finish_scene(scene, {});
  expect_same_bits(scene, {"path", "sppm", "photon-cache", "hash-cache", "irradiance-cache"}, "relief");
}

TEST_F(Lanes, EveryMethodGivesTheSameBitsAtEveryWidth) {
  std::vector<std::string> methods;
  for (const IntegratorEntry& entry : integrators()) methods.push_back(entry.name);
  for (const char* name : {"builtin:glossy-cornell-box", "builtin:glass-caustic", "builtin:two-rooms"})
    expect_same_bits(load_scene(name), methods, name);
}

TEST(CosSinOfTurn, IsWithinAFewUlpsOfTheExactOne) {
  double worst = 0;
  for (std::uint32_t i = 0; i < 1u << 24; i += 61) {
    const float u = to_unit_float(i << 8);
    const CosSin<float> turn = cos_sin_of_turn(u);
    const double angle = 2 * std::numbers::pi * u;
    worst = std::max({worst, std::abs(turn.cosine - std::cos(angle)), std::abs(turn.sine - std::sin(angle))});
  }
  EXPECT_LT(worst, 1.5e-7);
}

}  // namespace
}  // namespace etendue
