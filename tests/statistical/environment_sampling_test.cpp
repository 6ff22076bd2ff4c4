// Sampling an environment's image: its density is one, and what it finds is what the image emits.
#include "framework/transport/light_sampling.h"

#include <gtest/gtest.h>

#include <numbers>

namespace etendue {
namespace {

Scene under_image() {
  EnvironmentLight light{.scale = Rgb(1), .size = {8, 4}, .texels = {}, .light_to_world = {}};
  Sampler numbers(SamplerKind::independent, 3, Stream::test, 0, 0);
  for (int i = 0; i < 32; ++i) light.texels.push_back(Rgb(0.1f + square(square(2 * numbers.get_1d()))));
  Scene scene;
  scene.lights.push_back(light);
  return scene;
}

// Calls use(direction, solid angle) over a grid of directions, finer than the texels.
template <class Use>
void over_sphere(const Use& use) {
  constexpr int rows = 256, columns = 512;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const float theta = pi * (static_cast<float>(y) + 0.5f) / rows, phi = 2 * pi * (static_cast<float>(x) + 0.5f) / columns;
      const float sine = std::sin(theta);
      use(vec3(sine * std::cos(phi), sine * std::sin(phi), std::cos(theta)), double(sine) * 2 * pi * pi / (rows * columns));
    }
}

TEST(EnvironmentSampling, DensityOfAnImageIntegratesToOne) {
  const Scene scene = under_image();
  const LightSampler lights(scene);
  double sum = 0;
  over_sphere([&](const vec3& wi, double solid_angle) { sum += lights.environment_pdf(wi) * solid_angle; });
  EXPECT_NEAR(sum, 1, 1e-3);
}

TEST(EnvironmentSampling, SamplesOverTheirDensityGiveTheImagesLight) {
  const Scene scene = under_image();
  const LightSampler lights(scene);
  double emitted = 0, upper = 0;
  over_sphere([&](const vec3& wi, double solid_angle) {
    emitted += lights.environment(wi).x * solid_angle;
    if (wi.z > 0.3f) upper += lights.environment(wi).x * solid_angle;
  });
  double found = 0, found_upper = 0;
  constexpr int samples = 100000;
  for (int i = 0; i < samples; ++i) {
    Sampler numbers(SamplerKind::independent, 5, Stream::test, i, 0);
    const auto sample = lights.sample(vec3(0), numbers.get_2d());
    if (!sample) continue;  // within rounding of a pole
    const double light = sample->radiance.x / sample->pdf_solid_angle / samples;
    found += light;
    if (sample->wi.z > 0.3f) found_upper += light;
  }
  EXPECT_NEAR(found, emitted, 0.01 * emitted);
  EXPECT_NEAR(found_upper, upper, 0.02 * upper);
}

// A lamp at the zenith or the nadir lies in a polar row, whose directions an arc cosine takes for the pole itself.
TEST(EnvironmentSampling, PolarTexelsOfLargeImagesKeepTheirLight) {
  constexpr int rows = 2048;
  for (const int lit : {0, rows - 1}) {
    EnvironmentLight light{
        .scale = Rgb(1), .size = {2, rows}, .texels = std::vector<Rgb>(2 * rows, Rgb(0)), .light_to_world = {}};
    for (const int x : {0, 1}) light.texels[2 * lit + x] = Rgb(1e6f);
    Scene scene;
    scene.lights.push_back(light);
    const LightSampler lights(scene);
    double found = 0;
    constexpr int samples = 20000;
    for (int i = 0; i < samples; ++i) {
      Sampler numbers(SamplerKind::independent, 6, Stream::test, i, 0);
      if (const auto sample = lights.sample(vec3(0), numbers.get_2d()))
        found += sample->radiance.x / sample->pdf_solid_angle / samples;
    }
    const double cap = 2 * std::numbers::pi * (1 - std::cos(std::numbers::pi / rows));
    EXPECT_NEAR(found, 1e6 * cap, 0.01 * 1e6 * cap) << lit;
  }
}

}  // namespace
}  // namespace etendue
