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
  EXPECT_GT(found.failed, found.tests / 6);
  EXPECT_NEAR(found.ratio, 1.25, 0.01);
  EXPECT_NEAR(found.channel_ratio.y, 1.25, 0.02);
  EXPECT_NEAR(found.worst.ratio, 1.5, 0.03);
  EXPECT_LT(found.worst.at.x, reference_blocks / 2);
  EXPECT_NEAR(found.relmse_of_bias, 0.125 / 1.01, 2e-3);
  EXPECT_LT(found.largest_at.x, side / 2);
}

TEST(AgainstReference, ABlockWithoutAnyLightIsTheWorst) {
  Image image = even(1);
  for (int y = 0; y < side / 4; ++y)
    for (int x = 0; x < side / 4; ++x) image.at(x, y) = dvec3(0);
  const AgainstReference found = hold_against(std::vector<Image>(4, image), even(1), 1 << 20);
  EXPECT_EQ(found.worst.ratio, 0);
  EXPECT_EQ(found.worst.at, ivec2(0)) << "the first of those that are as bad";
}

TEST(AgainstReference, SmallDifferencesPass) {
  EXPECT_TRUE(hold_against(std::vector<Image>(4, even(1.0005)), even(1), 1 << 20).agrees());
  EXPECT_FALSE(hold_against(std::vector<Image>(4, even(1.002)), even(1), 1 << 20).agrees());
}

// Few samples of a pixel may have missed what all samples of an image have not.
TEST(AgainstReference, DifferencesThatFewSamplesCannotTellPass) {
  Image image = even(1);
  image.at(5, 7) = dvec3(0.95);
  EXPECT_TRUE(hold_against(std::vector<Image>(4, image), even(1), 256).agrees());
  EXPECT_FALSE(hold_against(std::vector<Image>(4, image), even(1), 4096).agrees());
  const AgainstReference found = hold_against(std::vector<Image>(4, even(0.95)), even(1), 256);
  EXPECT_EQ(found.failed, 0u);
  EXPECT_FALSE(found.agrees());
}

// Noise of 0.3 of a pixel under five seeds hides a quarter from the test of each pixel, and from that of blocks of 9 pixels.
TEST(AgainstReference, AMeanThatIsOffIsFoundWhereNoPixelCanTell) {
  const auto noisy_images = [](double gain, std::uint64_t stream) {
    std::vector<Image> images = noisy(gain, 5);
    for (std::size_t seed = 0; seed < images.size(); ++seed) {
      Pcg32 rng(seed, stream);
      for (dvec3& pixel : images[seed].pixels) pixel = gain * dvec3(1 + 0.3 * std::sqrt(12.0) * (rng.next_float() - 0.5));
    }
    return images;
  };
  const AgainstReference off = hold_against(noisy_images(1.25, 11), even(1), 1 << 20);
  EXPECT_EQ(off.failed, 0u);
  EXPECT_FALSE(off.mean_agrees()) << off.mean_t;
  EXPECT_FALSE(off.agrees());
  for (std::uint64_t stream = 20; stream < 30; ++stream)
    EXPECT_TRUE(hold_against(noisy_images(1, stream), even(1), 1 << 20).agrees());
}

TEST(AgainstReference, ABlockThatIsOffIsFound) {
  std::vector<Image> images = noisy(1);
  for (Image& image : images)
    for (int y = 6; y < 9; ++y)
      for (int x = 9; x < 12; ++x) image.at(x, y) *= 1.3;
  const AgainstReference found = hold_against(images, even(1), 1 << 20);
  EXPECT_EQ(found.blocks, 64u);
  EXPECT_EQ(found.blocks_failed, 1u);
  EXPECT_EQ(found.worst.at, ivec2(3, 2));
}

TEST(AgainstReference, BlackAndNonFiniteImagesHaveAVerdict) {
  EXPECT_TRUE(hold_against(std::vector<Image>(3, even(0)), even(0), 64).agrees());
  EXPECT_FALSE(hold_against(std::vector<Image>(3, even(1)), even(0), 64).agrees());
  Image broken = even(1);
  broken.at(0, 0).x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(hold_against(std::vector<Image>(3, broken), even(1), 64).agrees());
}

TEST(AgainstReference, ChannelsAreToldApart) {
  Image image = even(1), reference = even(1);
  for (dvec3& pixel : image.pixels) pixel = dvec3(1.5, 1, 0);
  for (dvec3& pixel : reference.pixels) pixel.z = 0;
  EXPECT_EQ(hold_against(std::vector<Image>(2, image), reference, 64).channel_ratio, dvec3(1.5, 1, 1));
}

TEST(AgainstReference, LargerReferencesAreAveraged) {
  Image image(ivec2(4, 2));
  for (int i = 0; i < 8; ++i) image.at(i % 4, i / 4) = dvec3(i);
  const Image mean = averaged(image, 2);
  EXPECT_EQ(mean.size, ivec2(2, 1));
  EXPECT_EQ(mean.at(0, 0), dvec3(2.5));  // of 0, 1, 4 and 5
  EXPECT_EQ(mean.at(1, 0), dvec3(4.5));
}

TEST(AgainstReference, TurnedImagesAreFound) {
  Image slope(ivec2{side}), left_right = slope, up_down = slope, half = slope;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const dvec3 value(1 + x + 0.3 * y);
      slope.at(x, y) = left_right.at(side - 1 - x, y) = up_down.at(x, side - 1 - y) = half.at(side - 1 - x, side - 1 - y) =
          value;
    }
  EXPECT_EQ(turned_against(slope, slope), "");
  EXPECT_EQ(turned_against(left_right, slope), "mirrored left to right");
  EXPECT_EQ(turned_against(up_down, slope), "upside down");
  EXPECT_EQ(turned_against(half, slope), "turned by half");
  EXPECT_EQ(turned_against(noisy(1)[0], even(1)), "");
  EXPECT_EQ(turned_against(noisy(1.5)[0], even(1)), "");
}

}  // namespace
}  // namespace etendue
