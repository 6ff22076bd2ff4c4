// FLIP against figures of its authors' implementation, and against what follows from its definition.
#include "framework/image/flip.h"
#include "framework/core/error.h"
#include "framework/core/parallel.h"
#include "framework/image/metrics.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <limits>

namespace etendue {
namespace {

constexpr ivec2 flip_size{40, 30};

// A gradient with a bright spot, and the same with noise, a red stripe and a blue one.
Image reference_image() {
  Image image(flip_size);
  for (int y = 0; y < flip_size.y; ++y)
    for (int x = 0; x < flip_size.x; ++x) {
      const bool spot = x >= 20 && x < 25 && y >= 12 && y < 16;
      image.at(x, y) = dvec3(0.1 + x / 40.0, 0.2 + 0.5 * y / 30, 0.3) + (spot ? 20.0 : 0.0);
    }
  return image;
}

Image test_image() {
  Image image = reference_image();
  for (int y = 0; y < flip_size.y; ++y)
    for (int x = 0; x < flip_size.x; ++x) {
      dvec3& pixel = image.at(x, y);
      pixel *= 1 + 0.4 * ((x * 7 + y * 13) % 11 / 11.0 - 0.5);
      if (x == 10) pixel.x += 0.8;
      if (y == 20) pixel.z += 0.5;
    }
  return image;
}

Image constant(const dvec3& colour, ivec2 of = {8, 8}) {
  Image image(of);
  std::ranges::fill(image.pixels, colour);
  return image;
}

void expect_errors(const std::vector<double>& errors, double mean, const std::array<double, 4>& pixels) {
  EXPECT_NEAR(mean_of(errors), mean, 2e-6);
  constexpr ivec2 at[] = {{0, 0}, {22, 15}, {10, 20}, {39, 29}};
  for (std::size_t i = 0; i < pixels.size(); ++i) EXPECT_NEAR(errors[pixel_index(at[i], flip_size)], pixels[i], 2e-5) << i;
}

// The figures are those of the published formulas in Python, with whole kernels in place of separable ones and conversions to
// sRGB and back.
TEST(Flip, AgreesWithThePublishedImplementation) {
  expect_errors(flip_errors(test_image(), reference_image()), 0.1083465, {0.2058587, 0.0595415, 0.4138265, 0.1129194});
  expect_errors(ldr_flip_errors(test_image(), reference_image()), 0.1398714, {0.1667119, 0.0788024, 0.5395459, 0.1496144});
  const std::vector<double> exposures = flip_exposures(reference_image());
  ASSERT_EQ(exposures.size(), 6u);
  EXPECT_NEAR(exposures.front(), -3.273715, 1e-6);
  EXPECT_NEAR(exposures.back(), 2.185925, 1e-6);
}

// L* of white and black is 100 apart, and green and blue are the farthest apart of all colours: their distance is 203.3016.
TEST(Flip, EvenColoursDifferAsTheirDistanceSays) {
  const double most = std::pow(203.3016, 0.7), white = std::pow(100, 0.7);
  const double expected = 0.95 + 0.05 * (white - 0.4 * most) / (0.6 * most);
  for (const double error : ldr_flip_errors(constant(dvec3(1)), constant(dvec3(0)))) EXPECT_NEAR(error, expected, 1e-5);
  for (const double error : ldr_flip_errors(constant({0, 1, 0}), constant({0, 0, 1}))) EXPECT_NEAR(error, 1, 1e-6);
}

TEST(Flip, EqualImagesHaveNoneAndOthersAreSymmetricAndWithinOne) {
  const Image a = test_image(), b = reference_image();
  EXPECT_EQ(flip(a, a), 0);
  EXPECT_EQ(ldr_flip_errors(a, b), ldr_flip_errors(b, a));
  for (const double error : flip_errors(a, b)) {
    EXPECT_GE(error, 0);
    EXPECT_LE(error, 1);
  }
}

TEST(Flip, ExposuresTakeTheBrightestAndTheMedianToTheSameGrey) {
  Image image = constant(dvec3(2), {3, 1});
  image.at(0, 0) = dvec3(0.25);
  image.at(2, 0) = dvec3(32);
  const std::vector<double> exposures = flip_exposures(image);
  ASSERT_EQ(exposures.size(), 4u);  // four stops
  EXPECT_NEAR(flip_tone_map(std::exp2(exposures.front()) * 32), 0.85, 1e-12);
  EXPECT_NEAR(flip_tone_map(std::exp2(exposures.back()) * 2), 0.85, 1e-12);
  EXPECT_EQ(flip_exposures(constant(dvec3(0))), std::vector<double>{0});
  EXPECT_EQ(flip_exposures(constant(dvec3(5))).size(), 1u);
  // Where most is black, the rest decides.
  image.at(0, 0) = image.at(1, 0) = dvec3(0);
  EXPECT_NEAR(flip_tone_map(std::exp2(flip_exposures(image).back()) * 32), 0.85, 1e-12);
}

// A scale that both images share is an exposure like any other.
TEST(Flip, DoesNotDependOnTheUnitOfRadiance) {
  Image a = test_image(), b = reference_image();
  const double before = flip(a, b);
  for (Image* image : {&a, &b})
    for (dvec3& pixel : image->pixels) pixel *= 1e-4;
  EXPECT_NEAR(flip(a, b), before, 1e-6);
}

TEST(Flip, ExtremeImagesHaveNumbersAndNonFiniteOnesAnError) {
  const Image reference = reference_image();
  Image image = test_image();
  image.at(3, 4) = dvec3(1e300, -1e300, 1e-300);
  for (const double error : flip_errors(image, reference)) EXPECT_TRUE(error >= 0 && error <= 1) << error;
  for (const double error : flip_errors(reference, image)) EXPECT_TRUE(error >= 0 && error <= 1) << error;
  for (const double error : flip_errors(reference, constant(dvec3(0), flip_size)))
    EXPECT_TRUE(error >= 0 && error <= 1) << error;
  EXPECT_GE(flip(constant(dvec3(1), {1, 1}), constant(dvec3(0.5), {1, 1})), 0.1);
  for (const double bad : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    image.at(3, 4).y = bad;
    EXPECT_THROW(flip(image, reference), Error);
    EXPECT_THROW(flip(reference, image), Error);
  }
}

TEST(Flip, IsTheSameAtAnyNumberOfThreads) {
  Image a({33, 200}), b({33, 200});
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    b.pixels[i] = dvec3(0.1 + static_cast<double>(i % 33));
    a.pixels[i] = b.pixels[i] * (1 + 0.01 * static_cast<double>(i % 7));
  }
  std::vector<double> one, three;
  with_threads(1, [&] { one = flip_errors(a, b); });
  with_threads(3, [&] { three = flip_errors(a, b); });
  EXPECT_EQ(one, three);
}

}  // namespace
}  // namespace etendue
