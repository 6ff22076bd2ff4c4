// How camera samples are shared out: where they go, how many they are, and that choosing them adds no bias.
#include "integrators/paths/sample_shares.h"
#include "framework/core/sampler.h"

#include <gtest/gtest.h>

#include <cmath>

namespace etendue {
namespace {

constexpr ivec2 resolution{16, 16};
constexpr std::size_t pixels = 256;

TEST(SampleShares, ExtraSamplesGoWherePixelsScatterAndBesideThem) {
  SampleShares shares(resolution, 2);
  Sampler sampler(SamplerKind::independent, 3, Stream::test, 0, 0);
  for (int iteration = 0; iteration < 8; ++iteration) {
    for (std::size_t i = 0; i < pixels; ++i)
      for (std::uint32_t s = 0; s < shares.range(i).count; ++s)
        shares.add(i, i / 16 == 7 ? 2 * sampler.get_1d() : 1);  // noise in row 7
    shares.end_iteration();
  }
  double sum = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    const std::uint32_t count = shares.range(i).count;
    const bool near = i / 16 >= 6 && i / 16 <= 8;
    EXPECT_EQ(count > 1, near) << i;
    EXPECT_LE(count, SampleShares::most);
    sum += count;
  }
  EXPECT_LE(sum, 3 * pixels);
  EXPECT_GT(sum, 2.7 * pixels);
}

TEST(SampleShares, WithoutExtraSamplesEachPixelTakesOne) {
  SampleShares shares(resolution, 0, 5);
  EXPECT_EQ(shares.range(3).begin, 5 * SampleShares::most);
  for (const float value : {1.0f, 7.0f}) {
    for (std::size_t i = 0; i < pixels; ++i) shares.add(i, value * static_cast<float>(i));
    shares.end_iteration();
  }
  for (std::size_t i = 0; i < pixels; ++i) EXPECT_EQ(shares.range(i).count, 1u);
  EXPECT_EQ(shares.range(3).begin, 5 * SampleShares::most + 2);
}

// Light that differs from pixel to pixel, but not within them, needs no further samples.
TEST(SampleShares, PixelsOfAGradientTakeOne) {
  SampleShares shares(resolution, 2);
  for (std::size_t i = 0; i < pixels; ++i)
    for (std::uint32_t s = 0; s < shares.range(i).count; ++s) shares.add(i, 1 + static_cast<float>(i % 16));
  shares.end_iteration();
  for (std::size_t i = 0; i < pixels; ++i) EXPECT_EQ(shares.range(i).count, 1u);
}

// One sample of each pixel cannot tell a gradient from scatter: the sequence goes on until there are two.
TEST(SampleShares, BegunWithOneStayInOneSequenceWhereLightIsSmooth) {
  SampleShares shares(resolution, 2);
  shares.begin_with_one();
  for (std::uint32_t iteration = 0; iteration < 5; ++iteration) {
    for (std::size_t i = 0; i < pixels; ++i) {
      EXPECT_EQ(shares.range(i).begin, iteration);
      EXPECT_EQ(shares.range(i).count, 1u);
      shares.add(i, 1 + static_cast<float>(i % 16));
    }
    shares.end_iteration();
  }
}

TEST(SampleShares, BegunWithOneTakeMoreWhereLightIsNot) {
  SampleShares shares(resolution, 2);
  shares.begin_with_one();
  Sampler sampler(SamplerKind::independent, 4, Stream::test, 0, 0);
  for (std::uint32_t iteration = 0; iteration < 2; ++iteration) {
    for (std::size_t i = 0; i < pixels; ++i) shares.add(i, 1 + sampler.get_1d());
    shares.end_iteration();
  }
  for (std::size_t i = 0; i < pixels; ++i) EXPECT_EQ(shares.range(i).count, 3u);
}

TEST(SampleShares, StayInOneSequenceWherePixelsScatterAlike) {
  SampleShares shares(resolution, 2);
  Sampler sampler(SamplerKind::independent, 4, Stream::test, 0, 0);
  for (std::uint32_t iteration = 0; iteration < 5; ++iteration) {
    for (std::size_t i = 0; i < pixels; ++i) {
      EXPECT_EQ(shares.range(i).begin, 3 * iteration);
      EXPECT_EQ(shares.range(i).count, 3u);
      for (std::uint32_t s = 0; s < 3; ++s) shares.add(i, 1 + sampler.get_1d());
    }
    shares.end_iteration();
  }
}

// Photons' noise is an iteration's own, and alike in blocks of pixels.
TEST(SampleShares, PixelsTakeOneWhereNewPhotonsLeaveMostOfTheNoise) {
  const auto samples_where = [](float common, float own) {
    SampleShares shares(resolution, 2);
    shares.expect_common_noise();
    Sampler sampler(SamplerKind::independent, 5, Stream::test, 0, 0);
    for (int iteration = 0; iteration < 8; ++iteration) {
      std::vector<float> blocks(pixels / 16);
      for (float& block : blocks) block = sampler.get_1d();
      for (std::size_t i = 0; i < pixels; ++i)
        for (std::uint32_t s = 0; s < shares.range(i).count; ++s)
          shares.add(i, 1 + common * blocks[i / 64 * 4 + i % 16 / 4] + own * sampler.get_1d());
      shares.end_iteration();
    }
    return shares.range(0).count;
  };
  EXPECT_EQ(samples_where(1, 0.3f), 1u);
  EXPECT_EQ(samples_where(0.3f, 1), 3u);
}

TEST(SampleShares, NumbersChosenByWhatWasFoundAddNoBias) {
  // Rare bright samples, which make numbers and values depend on each other most. A mean over all samples of a pixel alike
  // would come out too low: pixels without a bright one so far take few.
  constexpr float chance = 0.1f;
  constexpr int images = 60, iterations = 8;
  double sum = 0;
  for (int image = 0; image < images; ++image) {
    SampleShares shares(resolution, 4);
    for (int iteration = 0; iteration < iterations; ++iteration) {
      for (std::size_t i = 0; i < pixels; ++i) {
        const SampleShares::Range range = shares.range(i);
        for (std::uint32_t s = 0; s < range.count; ++s) {
          Sampler sampler(SamplerKind::independent, static_cast<std::uint64_t>(image), Stream::test, i, range.begin + s);
          const float value = sampler.get_1d() < chance ? 1 / chance : 0;
          shares.add(i, value);
          sum += value / range.count;
        }
      }
      shares.end_iteration();
    }
  }
  // The variance of one sample is (1 - chance) / chance; that of the mean is no greater than with one sample per iteration.
  const double count = images * iterations * static_cast<double>(pixels);
  EXPECT_NEAR(sum / count, 1, 4 * std::sqrt((1 - chance) / chance / count));
}

// Outlines: each sees part of a pixel lit. Points of a low-discrepancy sequence make up for those before them, which must not
// depend on how many there are.
TEST(SampleShares, PointsOfASequenceAddNoBiasEither) {
  constexpr int images = 400, iterations = 6;
  double sum = 0, squares = 0;
  for (int image = 0; image < images; ++image) {
    SampleShares shares(resolution, 2);
    double mean = 0;
    for (int iteration = 0; iteration < iterations; ++iteration) {
      for (std::size_t i = 0; i < pixels; ++i) {
        const float lit = i / 16 == 7 ? static_cast<float>(i % 16 + 1) / 17 : 0;
        const SampleShares::Range range = shares.range(i);
        for (std::uint32_t s = 0; s < range.count; ++s) {
          Sampler sampler(SamplerKind::sobol, static_cast<std::uint64_t>(image), Stream::test, i, range.begin + s);
          const float value = sampler.get_2d().x < lit ? 1 : 0;
          shares.add(i, value);
          mean += value / static_cast<float>(range.count) / (8 * iterations);
        }
      }
      shares.end_iteration();
    }
    sum += mean / images;
    squares += mean * mean / images;
  }
  const double error = std::sqrt((squares - sum * sum) / (images - 1));
  EXPECT_LT(std::abs(sum - 1), 4 * error) << sum;
  EXPECT_LT(error, 4e-3);
}

}  // namespace
}  // namespace etendue
