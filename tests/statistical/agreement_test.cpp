// The test that a rendered reference must pass, on samples whose distributions are known: how often it convicts estimators of
// the same mean, and whether it finds the difference of others.
#include "experiments/statistics/agreement.h"
#include "framework/core/rng.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace etendue {
namespace {

using Outcome = Agreement::Verdict;

double uniform(Pcg32& rng) { return (rng.next() + 0.5) * 0x1p-32; }

double normal(Pcg32& rng) {
  const double radius = std::sqrt(-2 * std::log(uniform(rng)));
  return radius * std::cos(2 * std::numbers::pi * uniform(rng));
}

int poisson(Pcg32& rng, double expected) {
  if (expected > 50) return std::max(0, static_cast<int>(std::lround(expected + std::sqrt(expected) * normal(rng))));
  int count = 0;
  for (double product = uniform(rng), limit = std::exp(-expected); product > limit; product *= uniform(rng)) ++count;
  return count;
}

// The mean of `samples` of one pixel's values, of which the expectation is 1.
using PixelMean = std::function<double(Pcg32&, int samples)>;

// Steady light, and a share of it in paths of probability `probability`: a caustic that path tracing finds by chance.
PixelMean rare(double probability, double share = 0.5) {
  return [=](Pcg32& rng, int samples) {
    return 1 - share + share * poisson(rng, probability * samples) / (probability * samples) +
           0.3 * normal(rng) / std::sqrt(samples);
  };
}
// Values e^(s Z), of which the largest ones of few samples are far below what is to come.
PixelMean log_normal(double s) {
  return [=](Pcg32& rng, int samples) {
    double sum = 0;
    for (int i = 0; i < samples; ++i) sum += std::exp(s * normal(rng) - s * s / 2);
    return sum / samples;
  };
}
PixelMean even(double noise = 0.3) {
  return [=](Pcg32& rng, int samples) { return 1 + noise * normal(rng) / std::sqrt(samples); };
}

struct Case {
  const char* name;
  int side, samples;  // of the image in pixels; per pixel in all batches
  PixelMean a, b;
  double brightest = 0;
};

BatchStatistics batches(const Case& c, const PixelMean& pixel_mean, std::uint64_t seed, double factor) {
  const int per_batch = c.samples / reference_batches;
  BatchStatistics statistics({c.side, c.side}, static_cast<std::uint64_t>(per_batch));
  Pcg32 rng(seed, 11);
  Image image({c.side, c.side});
  for (int batch = 0; batch < reference_batches; ++batch) {
    for (dvec3& pixel : image.pixels) pixel = dvec3(factor * pixel_mean(rng, per_batch));
    statistics.add(image);
  }
  return statistics;
}

struct Verdicts {
  int agree = 0, cannot_tell = 0, disagree = 0;
};

Verdicts judge(const Case& c, int trials, double false_alarm_rate, double factor = 1) {
  Verdicts verdicts;
  for (int trial = 0; trial < trials; ++trial) {
    const auto seed = static_cast<std::uint64_t>(trial);
    const Agreement agreement =
        compare_means(batches(c, c.a, 2 * seed, factor), batches(c, c.b, 2 * seed + 1, 1), {0, c.brightest, false_alarm_rate});
    ++(agreement.verdict == Outcome::agree         ? verdicts.agree
       : agreement.verdict == Outcome::cannot_tell ? verdicts.cannot_tell
                                                   : verdicts.disagree);
  }
  return verdicts;
}

// The most false alarms that a test which keeps its rate has in all but one of 10^4 such series.
int most_alarms(int trials, double rate) {
  const double expected = trials * rate;
  return static_cast<int>(std::ceil(expected + 3.7 * std::sqrt(expected) + 2));
}

const std::vector<Case>& cases() {
  static const std::vector<Case> list = {
      {"even", 8, 16, even(), even(1)},
      {"rare in one, few samples", 8, 16, rare(1.0 / 200), even(), 100},
      {"rare in one, more samples", 8, 256, rare(1.0 / 200), even(), 100},
      {"rarer than samples", 8, 64, rare(1e-5), even(), 5e4},
      {"rare in both", 8, 64, rare(1.0 / 50), rare(1.0 / 2000), 1000},
      {"rare, seen elsewhere, no light's radiance known", 8, 256, rare(1.0 / 100), even()},
      {"log-normal", 8, 16, log_normal(1), even()},
      {"heavy log-normal", 8, 64, log_normal(2), log_normal(1)},
      {"many samples of a rare one", 8, 65536, rare(1.0 / 200), even(), 100},
  };
  return list;
}

TEST(AgreementRates, FalseAlarmsOfFewPixelsKeepTheDeclaredRate) {
  constexpr int trials = 200;
  constexpr double rate = 0.02;
  for (const Case& c : cases()) EXPECT_LE(judge(c, trials, rate).disagree, most_alarms(trials, rate)) << c.name;
}

TEST(AgreementRates, FalseAlarmsOfManyPixelsKeepTheDeclaredRate) {
  constexpr int trials = 6;
  constexpr double rate = 0.02;
  for (const Case& c : {Case{"even", 256, 16, even(), even(1)}, Case{"rare", 256, 16, rare(1e-4), even(), 5000},
                        Case{"log-normal", 256, 16, log_normal(2), even()}})
    EXPECT_LE(judge(c, trials, rate).disagree, most_alarms(trials, rate)) << c.name;
}

// A t-test by itself would convict: most pixels have seen no rare path, and look as if they had no noise.
TEST(AgreementRates, RarePathsNotSeenAreNoDifference) {
  for (const Case& c : {cases()[1], cases()[3], cases()[5]}) {
    const Verdicts verdicts = judge(c, 20, 1e-3);
    EXPECT_EQ(verdicts.disagree, 0) << c.name;
    EXPECT_GE(verdicts.cannot_tell, 18) << c.name;
  }
}

TEST(AgreementRates, TwoPercentAreFoundWhereSamplesSuffice) {
  for (const Case& c : {Case{"even", 8, 16384, even(), even(1)}, Case{"rare", 8, 262144, rare(1.0 / 200), even(), 100},
                        Case{"rare in both", 8, 262144, rare(1.0 / 50), rare(1.0 / 200), 100}})
    EXPECT_GE(judge(c, 20, 1e-3, 1.02).disagree, 19) << c.name;
  for (const Case& c : {Case{"even", 256, 16, even(), even(1)}, Case{"rare", 256, 256, rare(1.0 / 200), even(), 100}})
    EXPECT_EQ(judge(c, 2, 1e-3, 1.02).disagree, 2) << c.name;
}

// With as many samples as it asks for, a difference that is there is found.
TEST(AgreementRates, SamplesAskedForSuffice) {
  Case c{"biased by 30 %", 8, 64, even(0.05), even(0.05), 100};
  Agreement few, enough;
  std::uint64_t needed = 0;
  for (Agreement* agreement : {&few, &enough}) {
    *agreement = compare_means(batches(c, c.a, 1, 0.7), batches(c, c.b, 2, 1), {5e-4, c.brightest});
    needed = samples_needed(64, few.times_the_samples);
    c.samples = static_cast<int>(needed);
  }
  EXPECT_EQ(few.verdict, Outcome::cannot_tell) << few.text;
  EXPECT_NE(few.text.find(undecided), std::string::npos) << few.text;
  EXPECT_NE(few.text.find(fmt::format("about {:.0f} times", std::ceil(few.times_the_samples))), std::string::npos) << few.text;
  EXPECT_EQ(enough.verdict, Outcome::disagree) << enough.text;
}

// A pixel is an image and a block; no block is empty or counted twice.
TEST(AgreementRates, OnePixelIsEnough) {
  const Case c{"one pixel", 1, 1 << 20, even(), even()};
  EXPECT_EQ(judge(c, 20, 1e-3).disagree, 0);
  EXPECT_EQ(judge(c, 20, 1e-3, 1.02).disagree, 20);
}

// Both images are black, or nearly so, beside what one path more may bring.
TEST(Agreement, CannotTellWhetherBothLackLight) {
  const auto of_value = [](double value) {
    BatchStatistics statistics({16, 16}, 16);
    for (int batch = 0; batch < reference_batches; ++batch) {
      Image image({16, 16});
      for (dvec3& pixel : image.pixels) pixel = dvec3(value * (1 + 1e-3 * (batch % 2)));
      statistics.add(image);
    }
    return statistics;
  };
  const AgreementOptions bright{.brightest = 1e4};
  const Agreement black = compare_means(of_value(0), of_value(0), bright);
  EXPECT_EQ(black.verdict, Outcome::cannot_tell);
  EXPECT_NE(black.text.find("no number of samples"), std::string::npos) << black.text;
  EXPECT_GT(black.may_lack, 0);
  const Agreement dim = compare_means(of_value(0.1), of_value(0.1), bright);
  EXPECT_EQ(dim.verdict, Outcome::cannot_tell);
  EXPECT_GT(dim.times_the_samples, 1);
  EXPECT_TRUE(std::isfinite(dim.times_the_samples));
  EXPECT_EQ(compare_means(of_value(1000), of_value(1000), bright).verdict, Outcome::agree);
  EXPECT_EQ(compare_means(of_value(0), of_value(0), {}).verdict, Outcome::agree) << "there is no light";
}

}  // namespace
}  // namespace etendue
