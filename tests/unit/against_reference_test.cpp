// Images of several seeds held against one of another program: what agrees passes, what differs is found and measured.
#include "experiments/statistics/against_reference.h"
#include "framework/core/rng.h"
#include "framework/image/metrics.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

constexpr int side = 24;

Image even(double value) {
  Image image(ivec2{side});
  for (dvec3& pixel : image.pixels) pixel = dvec3(value);
  return image;
}

// Noise of a tenth about 1, times `gain` in the left half.
std::vector<Image> noisy(double gain, int count = 12) {
  std::vector<Image> images;
  for (int seed = 0; seed < count; ++seed) {
    Pcg32 rng(static_cast<std::uint64_t>(seed), 7);
    Image image = even(1);
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x)
        for (int c = 0; c < 3; ++c)
          image.at(x, y)[c] = (x < side / 2 ? gain : 1) * (1 + 0.1 * std::sqrt(12.0) * (rng.next_float() - 0.5));
    images.push_back(image);
  }
  return images;
}

TEST(AgainstReference, NoiseAloneAgrees) {
  const auto images = noisy(1);
  const AgainstReference found = hold_against(images, even(1), 1 << 20);
  EXPECT_TRUE(found.agrees()) << found.largest_t;
  EXPECT_NEAR(found.ratio, 1, 4 * found.ratio_error);
  EXPECT_NEAR(found.relmse_of_noise, 0.01 / 1.01, 5e-4);
  EXPECT_NEAR(found.relmse_of_bias, 0, 5e-5);
  EXPECT_NEAR(found.relmse_of_noise, relmse(images[0], even(1)), 1e-3);
}

TEST(AgainstReference, WhatDiffersIsFound) {
  const AgainstReference found = hold_against(noisy(1.5), even(1), 1 << 20);
  EXPECT_FALSE(found.agrees());
  EXPECT_GT(found.failed, found.tests / 3);
  EXPECT_NEAR(found.ratio, 1.25, 0.01);
  EXPECT_NEAR(found.worst.ratio, 1.5, 0.03);
  EXPECT_LT(found.worst.at.x, reference_blocks / 2);
  EXPECT_NEAR(found.relmse_of_bias, 0.125 / 1.01, 2e-3);
  EXPECT_LT(found.largest_at.x, side / 2);
}

TEST(AgainstReference, SmallDifferencesPass) {
  EXPECT_TRUE(hold_against(std::vector<Image>(4, even(1.0005)), even(1), 1 << 20).agrees());
  EXPECT_FALSE(hold_against(std::vector<Image>(4, even(1.002)), even(1), 1 << 20).agrees());
}

// What few samples may have missed.
TEST(AgainstReference, DifferencesThatFewSamplesCannotTellPass) {
  EXPECT_TRUE(hold_against(std::vector<Image>(4, even(0.95)), even(1), 256).agrees());
  EXPECT_FALSE(hold_against(std::vector<Image>(4, even(0.95)), even(1), 4096).agrees());
}

}  // namespace
}  // namespace etendue
