// Fitted exponents on trajectories whose exponents are known.
#include "experiments/statistics/rate_fit.h"
#include "framework/core/rng.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace etendue {
namespace {

using Model = Prediction::Model;

class NormalNoise {
 public:
  explicit NormalNoise(std::uint64_t seed) : rng_(seed, 11) {}
  double operator()() {
    const double u = 1 - rng_.next_float(), v = rng_.next_float();
    return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
  }

 private:
  Pcg32 rng_;
};

std::vector<double> ladder(double from, double to, std::size_t count) {
  std::vector<double> x(count);
  for (std::size_t i = 0; i < count; ++i)
    x[i] = from * std::pow(to / from, static_cast<double>(i) / static_cast<double>(count - 1));
  return x;
}

// A region of `pixels` seen by progressive runs: the error of pixel p at iteration n is bias(n) plus a random walk whose
// variance is n^exponent, so that checkpoints of a run are autocorrelated as those of a renderer are.
template <class Bias>
std::vector<RatePoint> progressive_runs(NormalNoise& normal, std::size_t seeds, std::size_t pixels,
                                        const std::vector<double>& x, double exponent, const Bias& bias) {
  std::vector<RatePoint> points(x.size(), {std::vector<double>(seeds), std::vector<double>(seeds * seeds, 0), 0});
  std::vector<std::vector<double>> walk(seeds, std::vector<double>(pixels, 0)), error = walk;
  double clock = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    // W(n^(2 + e)) / n has variance n^e.
    const double now = std::pow(x[k], 2 + exponent), step = std::sqrt(now - clock);
    clock = now;
    for (std::size_t i = 0; i < seeds; ++i) {
      points[k].x[i] = x[k];
      for (std::size_t p = 0; p < pixels; ++p) {
        walk[i][p] += step * normal();
        error[i][p] = walk[i][p] / x[k] + bias(x[k], p);
      }
    }
    for (std::size_t i = 0; i < seeds; ++i)
      for (std::size_t j = 0; j < seeds; ++j)
        for (std::size_t p = 0; p < pixels; ++p)
          points[k].products[i * seeds + j] += error[i][p] * error[j][p] / static_cast<double>(pixels);
  }
  return points;
}

double no_bias(double, std::size_t) { return 0; }

RatePoint exact_point(double x, double y, std::size_t seeds = 3) {
  RatePoint point{std::vector<double>(seeds, x), std::vector<double>(seeds * seeds, y), 0};
  return point;
}

TEST(RateFit, ExactPowerLawIsFoundExactly) {
  std::vector<RatePoint> points;
  for (const double x : ladder(1e3, 1e5, 9)) points.push_back(exact_point(x, 5 * std::pow(x, -2.0 / 3)));
  const auto fit = fit_rate(points, "mse", Model::power);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->exponent, -2.0 / 3, 1e-12);
  EXPECT_NEAR(fit->amplitude, 5, 1e-9);
  EXPECT_EQ(fit->points, 9u);
  EXPECT_DOUBLE_EQ(fit->from, 1e3);
  EXPECT_NEAR(fit->exponent_interval->low, -2.0 / 3, 1e-12);
  EXPECT_NEAR(fit_rate(points, "rmse", Model::power)->exponent, -1.0 / 3, 1e-12);
  EXPECT_NEAR(fit_rate(points, "bias2", Model::power)->exponent, -2.0 / 3, 1e-12) << "what all seeds share is bias";
}

TEST(RateFit, PlateauIsToldFromTheSlopeBeforeIt) {
  for (const double plateau : {1e-2, 1e-4, 1e-6}) {
    std::vector<RatePoint> points;
    for (const double x : ladder(1, 1e6, 13)) points.push_back(exact_point(x, 2 / x + plateau));
    const auto fit = fit_rate(points, "mse", Model::plateau, {.resamples = 20});
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->exponent, -1, 2e-3) << plateau;
    EXPECT_NEAR(fit->plateau, plateau, 0.02 * plateau);
    EXPECT_NEAR(fit->value(10), 0.2 + plateau, 2e-3);
  }
}

TEST(RateFit, WithoutSeedsThereIsNoIntervalWithoutPointsNoFit) {
  std::vector<RatePoint> points;
  for (const double x : ladder(1, 100, 5)) points.push_back(exact_point(x, 1 / x, 1));
  const auto fit = fit_rate(points, "mse", Model::power);
  ASSERT_TRUE(fit);
  EXPECT_FALSE(fit->exponent_interval);
  points.resize(2);
  EXPECT_FALSE(fit_rate(points, "mse", Model::power));
  EXPECT_FALSE(fit_rate({}, "mse", Model::power));
}

TEST(RateFit, ValueThatIsNotPositiveIsLeftOutAndCounted) {
  std::vector<RatePoint> points;
  for (const double x : ladder(1, 1000, 7)) points.push_back(exact_point(x, 1 / x));
  points[3].offset = 1;
  const auto fit = fit_rate(points, "mse", Model::power);
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->points, 6u);
  EXPECT_EQ(fit->dropped, 1u);
  EXPECT_NEAR(fit->exponent, -1, 1e-12);
}

TEST(RateFit, PointWhoseXIsZeroIsNeitherUsedNorDropped) {
  std::vector<RatePoint> points{exact_point(0, 1)};
  for (const double x : ladder(1, 1000, 7)) points.push_back(exact_point(x, 1 / x));
  const auto fit = fit_rate(points, "mse", Model::power);
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->points, 7u);
  EXPECT_EQ(fit->dropped, 0u);
  EXPECT_EQ(fit->from, 1);
  EXPECT_FALSE(fit_rate(std::vector{exact_point(0, 1)}, "mse", Model::power));
}

TEST(RateFit, ReferencesOwnVarianceIsSubtracted) {
  std::vector<RatePoint> points;
  for (const double x : ladder(1, 1000, 7)) {
    points.push_back(exact_point(x, 1 / x + 0.01));
    points.back().offset = 0.01;
  }
  EXPECT_NEAR(fit_rate(points, "mse", Model::power)->exponent, -1, 1e-9);
}

TEST(RateFit, BiasAndVarianceHaveExponentsOfTheirOwn) {
  NormalNoise normal(3);
  const auto bias = [](double n, std::size_t p) { return (p % 2 == 0 ? 3 : 1) * std::pow(n, -0.25); };
  const auto points = progressive_runs(normal, 10, 60, ladder(10, 1e4, 10), -1, bias);
  const auto bias_fit = fit_rate(points, "bias2", Model::power), variance_fit = fit_rate(points, "variance", Model::power);
  ASSERT_TRUE(bias_fit && variance_fit);
  EXPECT_NEAR(bias_fit->exponent, -0.5, 0.02);
  EXPECT_NEAR(variance_fit->exponent, -1, 0.1);
  EXPECT_NEAR(bias_fit->value(100), 5 * std::pow(100, -0.5), 0.05);
}

TEST(RateFit, BiasOfUnbiasedRunsIsZeroWithinItsNoise) {
  NormalNoise normal(5);
  double sum = 0;
  constexpr int runs = 200;
  for (int i = 0; i < runs; ++i) {
    const auto points = progressive_runs(normal, 4, 10, {100.0}, -1, no_bias);
    sum += rate_value(points[0], "bias2", std::vector<double>(4, 1)) / runs;
  }
  // The estimate of one run has variance 2 (0.01)^2 / (10 * 4 * 3).
  EXPECT_LT(std::abs(sum), 4 * 0.01 * std::sqrt(2.0 / 120 / runs));
}

TEST(RateFit, SameSeedGivesTheSameInterval) {
  NormalNoise normal(9);
  const auto points = progressive_runs(normal, 10, 20, ladder(10, 1e3, 6), -1, no_bias);
  const auto a = fit_rate(points, "mse", Model::power), b = fit_rate(points, "mse", Model::power);
  EXPECT_EQ(a->exponent_interval->low, b->exponent_interval->low);
  EXPECT_EQ(a->exponent_interval->high, b->exponent_interval->high);
}

// How often do 95 % intervals of ten seeds hold the true exponent? Each share is of 300 experiments, at a false-alarm rate of 1
// % for the three together (Sidak: 0.33 % each, 2.94 standard deviations of a binomial); a percentile bootstrap of ten seeds is
// allowed 2 points less than it promises.
struct Coverage {
  const char* name;
  double exponent;
  std::size_t pixels;
};
void PrintTo(const Coverage& c, std::ostream* out) { *out << c.name; }

class RateFitCoverage : public ::testing::TestWithParam<Coverage> {};

TEST_P(RateFitCoverage, IntervalsHoldTheExponentAsOftenAsTheyPromise) {
  const Coverage& c = GetParam();
  NormalNoise normal(static_cast<std::uint64_t>(c.pixels) + 100);
  constexpr int experiments = 300;
  int held = 0;
  for (int i = 0; i < experiments; ++i) {
    const auto points = progressive_runs(normal, 10, c.pixels, ladder(1e3, 1e4, 6), c.exponent, no_bias);
    const auto fit = fit_rate(points, "mse", Model::power, {.resamples = 500, .seed = static_cast<std::uint64_t>(i) + 1});
    ASSERT_TRUE(fit && fit->exponent_interval);
    held += fit->exponent_interval->contains(c.exponent);
  }
  const double share = held / static_cast<double>(experiments), sd = std::sqrt(0.95 * 0.05 / experiments);
  EXPECT_GT(share, 0.93 - 2.94 * sd) << held;
  EXPECT_LT(share, 0.97 + 2.94 * sd) << held;
}

INSTANTIATE_TEST_SUITE_P(RateFit, RateFitCoverage,
                         ::testing::Values(Coverage{"independent", -1, 40}, Coverage{"memoryless", -2.0 / 3, 20},
                                           Coverage{"few_pixels", -1, 4}),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace etendue
