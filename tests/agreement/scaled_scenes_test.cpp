// Units of length and of light do not matter: a scene scaled by a power of two has the image that it had, and one whose lamps
// are a power of two brighter has that image times this power, to the bit.
#include "tests/sealed_checks.h"

namespace etendue {
namespace {

using testing::Placement;
using testing::sealed_methods;
using testing::SealedMethod;

// A box with a diffuse ball, a glass one and a lamp under its ceiling.
Scene furnished_box(const Placement& place, float radiance = 8) {
  SceneBuilder builder("furnished box");
  const auto wall = builder.material(Diffuse{Rgb(0.7f, 0.5f, 0.3f)});
  builder.mesh(place(testing::box_walls(2)), wall);
  builder.quadric(place(Sphere{{-0.8f, -1.2f, 0.6f}, 0.7f}), wall);
  builder.quadric(place(Sphere{{0.8f, -1.2f, 0.2f}, 0.6f}), builder.material(Dielectric{.eta = 1.5f}));
  builder.mesh(place(quad({-0.5f, 1.9f, -0.5f}, {0.5f, 1.9f, -0.5f}, {0.5f, 1.9f, 0.5f}, {-0.5f, 1.9f, 0.5f})), wall,
               Rgb(radiance));
  builder.camera(place({0, 0, -1.9f}), place({0, 0, 1}), 90, {16, 16});
  Scene scene = builder.finish();
  for (Light& light : scene.lights) std::get<AreaLight>(light).two_sided = true;
  return scene;
}

Image image_of(const Scene& scene, const SealedMethod& method, std::uint32_t iterations) {
  testing::RenderOptions options;
  options.params = method.params;
  options.iterations = iterations;
  options.resolution = {16, 16};
  const auto rendered = testing::render(scene, method.name, options);
  EXPECT_EQ(rendered.non_finite, 0u) << method.name;
  return rendered.image;
}

double mean_of(const Image& image) {
  double sum = 0;
  for (const dvec3& p : image.pixels) sum += (p.x + p.y + p.z) / 3;
  return sum / static_cast<double>(image.pixels.size());
}

void expect_means_whatever_the_scale(std::initializer_list<int> exponents, std::uint32_t rounds) {
  const Scene unscaled = furnished_box({});
  for (const SealedMethod& method : sealed_methods()) {
    const std::uint32_t iterations = rounds * method.iterations;
    const double expected = mean_of(image_of(unscaled, method, iterations));
    EXPECT_GT(expected, 0) << method.name;
    for (const int exponent : exponents) {
      const double found = mean_of(image_of(furnished_box({std::ldexp(1.0f, exponent)}), method, iterations));
      if (testing::prints_leaks())
        std::printf("%-40s times 2^%-4d mean %.6g, relative difference %+.2e\n", (method.name + method.variant).c_str(),
                    exponent, found, found / expected - 1);
      EXPECT_NEAR(found / expected, 1, 1e-3) << method.name << method.variant << ", times 2^" << exponent;
    }
  }
}

TEST(ScaledScenes, MeanOfEveryMethodIsThatOfTheUnscaledScene) { expect_means_whatever_the_scale({-20, 20}, 1); }

TEST(ScaledScenes, RadianceTimesAPowerOfTwoGivesThatTimesTheImage) {
  const Scene dim = furnished_box({}, 8);
  for (const int exponent : {-12, 12}) {
    const float factor = std::ldexp(1.0f, exponent);
    const Scene bright = furnished_box({}, 8 * factor);
    for (const SealedMethod& method : sealed_methods()) {
      const Image expected = image_of(dim, method, method.iterations), found = image_of(bright, method, method.iterations);
      std::size_t different = 0;
      for (std::size_t i = 0; i < expected.pixels.size(); ++i)
        different += expected.pixels[i] * static_cast<double>(factor) != found.pixels[i];
      EXPECT_EQ(different, 0u) << "pixels of " << method.name << method.variant << ", light times 2^" << exponent;
    }
  }
}

TEST(LongScaledScenes, MeanOfEveryMethodAtEveryScale) {
  expect_means_whatever_the_scale({-20, -16, -13, -10, -5, 5, 10, 20}, 4);
}

}  // namespace
}  // namespace etendue
