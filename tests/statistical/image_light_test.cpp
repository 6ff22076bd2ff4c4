// Area lights that show images, held to quadrature: what they send to a point, and what they emit.
#include "framework/core/sampling.h"
#include "framework/scene/builder.h"
#include "framework/transport/light_sampling.h"

#include <gtest/gtest.h>

#include <numbers>

namespace etendue {
namespace {

// A rectangle of 2 m by 3 m at the height of 1 m that shines down. Half of its image is black.
Scene lit_by_image() {
  SceneBuilder builder("image light");
  builder.mesh(quad({-1, -1, 1}, {-1, 2, 1}, {1, 2, 1}, {1, -1, 1}), builder.material(Diffuse{}));
  Scene scene = builder.finish();
  ImageTexture image{.size = {2, 2}, .texels = {Rgb(1, 0.5f, 0), Rgb(0), Rgb(0), Rgb(0.25f)}};
  image.wrap_u = image.wrap_v = Wrap::clamp;
  scene.textures = {image};
  finish_scene(scene, {{.shape = 0, .radiance = Rgb(3), .two_sided = false, .texture = 0}});
  return scene;
}

// Radiance of the rectangle's point (s, t) in shares of its sides: its corners are (0, 0), (1, 0), (1, 1), (0, 1) of (u, v).
Rgb radiance_at(const Scene& scene, double s, double t) {
  return 3.0f * evaluate(scene.textures[0], vec2(static_cast<float>(s), static_cast<float>(t)));
}

template <class Value>
dvec3 quadrature(const Scene& scene, const Value& weight) {
  constexpr int side = 256;
  dvec3 sum(0);
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const double s = (i + 0.5) / side, t = (j + 0.5) / side;
      sum += dvec3(radiance_at(scene, s, t)) * weight(dvec3(-1 + 2 * t, -1 + 3 * s, 1)) * (6.0 / (side * side));
    }
  return sum;
}

void expect_near(const dvec3& found, const dvec3& expected, double tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], tolerance * expected[c]) << c;
}

TEST(ImageLights, SendTheirImageToAPoint) {
  const Scene scene = lit_by_image();
  const LightSampler lights(scene);
  constexpr int samples = 1 << 14;
  dvec3 sum(0);
  for (int i = 0; i < samples; ++i) {
    Sampler s(SamplerKind::sobol, 3, Stream::test, 0, i);
    const auto light = lights.sample(vec3(0), s.get_2d());
    if (light) sum += dvec3(light->radiance * (light->wi.z / light->pdf_solid_angle)) / static_cast<double>(samples);
  }
  // Irradiance on the plane z = 0 at the origin: L cos cos / r^2 over the area.
  expect_near(sum, quadrature(scene, [](const dvec3& p) { return 1 / std::pow(glm::dot(p, p), 2); }), 5e-3);
}

TEST(ImageLights, EmitTheirPower) {
  const Scene scene = lit_by_image();
  const LightSampler lights(scene);
  constexpr int samples = 1 << 21;
  dvec3 sum(0);
  for (int i = 0; i < samples; ++i) {
    Sampler s(SamplerKind::sobol, 4, Stream::test, 0, i);
    const float choice = s.get_1d();
    const vec2 where = s.get_2d();
    const auto ray = lights.emit(choice, where, s.get_2d());
    ASSERT_TRUE(ray);
    sum += dvec3(ray->power) / static_cast<double>(samples);
  }
  expect_near(sum, std::numbers::pi * quadrature(scene, [](const dvec3&) { return 1.0; }), 2e-3);
}

TEST(ImageLights, AreSeenAsTheyAreSampled) {
  const Scene scene = lit_by_image();
  const LightSampler lights(scene);
  for (int i = 0; i < 100; ++i) {
    Sampler s(SamplerKind::independent, 5, Stream::test, i, 0);
    const auto light = lights.sample(vec3(0), s.get_2d());
    if (!light) continue;
    const vec3 p = light->distance * light->wi;  // on the rectangle
    const Rgb expected = radiance_at(scene, (p.y + 1) / 3, (p.x + 1) / 2);
    expect_near(dvec3(light->radiance) + 1e-3, dvec3(expected) + 1e-3, 2e-2);
  }
}

}  // namespace
}  // namespace etendue
