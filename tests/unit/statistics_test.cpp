#include "experiments/statistics/statistics.h"
#include "experiments/log/products.h"
#include "experiments/statistics/rate_fit.h"

#include "framework/core/rng.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace etendue {
namespace {

class Normal {
 public:
  explicit Normal(std::uint64_t seed) : rng_(seed, 7) {}
  double operator()() {
    const double u = 1 - rng_.next_float(), v = rng_.next_float();
    return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
  }

 private:
  Pcg32 rng_;
};

std::vector<double> normals(Normal& normal, std::size_t count, double centre = 0, double sd = 1) {
  std::vector<double> values(count);
  for (double& value : values) value = centre + sd * normal();
  return values;
}

TEST(Statistics, QuantilesInterpolateBetweenOrderStatistics) {
  const std::vector<double> values{4, 1, 3, 2};
  EXPECT_DOUBLE_EQ(quantile(values, 0.25), 1.75);
  EXPECT_DOUBLE_EQ(median(values), 2.5);
  EXPECT_DOUBLE_EQ(quantile(values, 0), 1);
  EXPECT_DOUBLE_EQ(quantile(values, 1), 4);
  EXPECT_DOUBLE_EQ(quantile(std::vector<double>{7}, 0.05), 7);
}

TEST(Statistics, MeansOfEqualValuesAreThatValueExactly) {
  const std::vector<double> values(3, 0.1);
  EXPECT_EQ(mean(values), 0.1);
  EXPECT_EQ(geometric_mean(values), 0.1);
  EXPECT_DOUBLE_EQ(geometric_mean(std::vector<double>{1, 100}), 10);
  EXPECT_EQ(geometric_mean(std::vector<double>{0, 1}), 0);
  EXPECT_DOUBLE_EQ(sample_sd(std::vector<double>{1, 2, 3, 4}), std::sqrt(5.0 / 3));
}

TEST(Statistics, StudentQuantilesMatchTheTables) {
  EXPECT_NEAR(student_t_quantile(0.975, 1), 12.70620474, 1e-7);
  EXPECT_NEAR(student_t_quantile(0.975, 2), 4.302652730, 1e-8);
  EXPECT_NEAR(student_t_quantile(0.975, 9), 2.262157163, 1e-8);
  EXPECT_NEAR(student_t_quantile(0.95, 30), 1.697260887, 1e-8);
  EXPECT_NEAR(student_t_quantile(0.995, 5), 4.032142983, 1e-8);
  EXPECT_NEAR(student_t_quantile(0.025, 9), -2.262157163, 1e-8);
  EXPECT_NEAR(student_t_quantile(0.975, 1e6), 1.959966, 1e-5);
  EXPECT_EQ(student_t_quantile(0.5, 3), 0);
}

// The report says this of four standard errors (declared.cpp).
TEST(Statistics, FourStandardErrorsOfFewSeedsAreExceededByChance) {
  EXPECT_NEAR(student_t_quantile(1 - 0.5 / 17.5, 2), 4, 0.02);
  EXPECT_NEAR(student_t_quantile(1 - 0.5 / 320, 9), 4, 0.02);
}

TEST(Statistics, SidakLevelKeepsTheLevelOfAllTestsTogether) {
  const double each = sidak_level(0.05, 10);
  EXPECT_NEAR(1 - std::pow(1 - each, 10), 0.05, 1e-12);
  EXPECT_EQ(sidak_level(0.05, 1), 0.05);
}

TEST(Statistics, StudentIntervalCoversAtItsLevel) {
  Normal normal(1);
  int covered = 0;
  constexpr int trials = 4000;
  for (int i = 0; i < trials; ++i) covered += signed_estimate(normals(normal, 5, 3, 2)).interval.contains(3);
  EXPECT_NEAR(covered / double{trials}, 0.95, 0.014);  // four standard errors
}

TEST(Statistics, EstimateSaysHowItsIntervalWasMade) {
  EXPECT_EQ(geometric_estimate(std::vector<double>{2}).spread, Spread::none);
  const Estimate two = geometric_estimate(std::vector<double>{1, 4});
  EXPECT_EQ(two.spread, Spread::min_max);
  EXPECT_DOUBLE_EQ(two.centre, 2);
  EXPECT_DOUBLE_EQ(two.interval.low, 1);
  EXPECT_DOUBLE_EQ(two.interval.high, 4);
  const Estimate three = geometric_estimate(std::vector<double>{1, 2, 4});
  EXPECT_EQ(three.spread, Spread::t95);
  EXPECT_DOUBLE_EQ(three.centre, 2);
  EXPECT_NEAR(three.interval.high, 2 * std::exp(4.302652730 * std::log(2) / std::sqrt(3)), 1e-8);
  const Estimate zero = geometric_estimate(std::vector<double>{0, 2, 4});
  EXPECT_EQ(zero.spread, Spread::min_max);
  EXPECT_EQ(zero.interval.low, 0);
}

TEST(Statistics, RatioIntervalHoldsTheTrueRatioAtItsLevel) {
  Normal normal(2);
  int covered = 0;
  constexpr int trials = 2000;
  for (int i = 0; i < trials; ++i) {
    std::vector<double> a = normals(normal, 6, std::log(2), 0.3), b = normals(normal, 4, 0, 0.1);
    for (auto* values : {&a, &b})
      for (double& value : *values) value = std::exp(value);
    covered += geometric_ratio(a, b)->interval.contains(2);
  }
  EXPECT_NEAR(covered / double{trials}, 0.95, 0.02);
  EXPECT_FALSE(geometric_ratio(std::vector<double>{1, 2}, std::vector<double>{1, 2, 3}));
  EXPECT_FALSE(geometric_ratio(std::vector<double>{0, 1, 2}, std::vector<double>{1, 2, 3}));
}

TEST(Bootstrap, EqualSeedsGiveEqualIntervals) {
  Normal normal(3);
  const auto values = normals(normal, 60);
  const auto statistic = [&](std::span<const std::size_t> chosen) {
    double sum = 0;
    for (const std::size_t i : chosen) sum += values[i];
    return sum / static_cast<double>(chosen.size());
  };
  const auto a = bootstrap_interval(values.size(), statistic), b = bootstrap_interval(values.size(), statistic);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->low, b->low);
  EXPECT_EQ(a->high, b->high);
  // Close to the normal interval of the mean at this size.
  const double half = 1.96 * sample_sd(values) / std::sqrt(60.0);
  EXPECT_NEAR(a->high - a->low, 2 * half, 0.15 * 2 * half);
  EXPECT_TRUE(a->contains(mean(values)));
}

TEST(Bootstrap, NonFiniteResultsAreLeftOut) {
  const auto mostly = [](std::span<const std::size_t> chosen) { return chosen[0] == 0 ? NAN : 1.0; };
  const auto interval = bootstrap_interval(4, mostly);
  ASSERT_TRUE(interval);
  EXPECT_EQ(interval->low, 1);
  EXPECT_FALSE(bootstrap_interval(4, [](auto) { return std::numeric_limits<double>::infinity(); }));
}

TEST(Curve, PowerLawIsInterpolatedExactly) {
  const Curve curve{{1, 4, 64}, {1, 0.5, 0.125}};  // x^(-1/2)
  for (const double x : {1.0, 2.0, 4.0, 9.0, 64.0}) EXPECT_NEAR(*value_at(curve, x), 1 / std::sqrt(x), 1e-12) << x;
  EXPECT_FALSE(value_at(curve, 0.9));
  EXPECT_FALSE(value_at(curve, 65));
  EXPECT_FALSE(value_at({}, 1));
}

TEST(Curve, ZeroAtAnEndIsInterpolatedLinearly) {
  const Curve curve{{1, 4}, {1, 0}};
  EXPECT_DOUBLE_EQ(*value_at(curve, 2), 0.5);  // halfway in log x
  EXPECT_EQ(*value_at(curve, 4), 0);
}

TEST(Arrival, IsInterpolatedCensoredOrBeforeTheFirstCheckpoint) {
  const Curve curve{{1, 4, 16}, {1, 0.5, 0.25}};
  const Arrival at = time_to(curve, std::sqrt(0.5));
  EXPECT_EQ(at.kind, Arrival::Kind::at);
  EXPECT_NEAR(at.time, 2, 1e-12);
  const Arrival before = time_to(curve, 2);
  EXPECT_EQ(before.kind, Arrival::Kind::before);
  EXPECT_EQ(before.time, 1);
  const Arrival never = time_to(curve, 0.1);
  EXPECT_EQ(never.kind, Arrival::Kind::never);
  EXPECT_EQ(never.time, 16);
  const Arrival at_zero = time_to({{1, 4}, {1, 0}}, 0.0);
  EXPECT_EQ(at_zero.kind, Arrival::Kind::at);
  EXPECT_DOUBLE_EQ(at_zero.time, 4);
}

TEST(Arrival, MedianIsATimeOnlyIfMoreThanHalfArrived) {
  using Kind = Arrival::Kind;
  const std::vector<Arrival> three_of_five{{Kind::never, 9}, {Kind::at, 3}, {Kind::never, 9}, {Kind::at, 1}, {Kind::at, 2}};
  const ArrivalMedian most = median_arrival(three_of_five);
  EXPECT_EQ(most.median.kind, Kind::at);
  EXPECT_EQ(most.median.time, 3);
  EXPECT_EQ(most.arrived, 3u);
  const std::vector<Arrival> two_of_four{{Kind::never, 9}, {Kind::at, 3}, {Kind::never, 8}, {Kind::at, 1}};
  const ArrivalMedian half = median_arrival(two_of_four);
  EXPECT_EQ(half.median.kind, Kind::never);
  EXPECT_EQ(half.arrived, 2u);
  EXPECT_EQ(half.count, 4u);
  // If one arrived earlier than it was looked for, its mean with another is a bound.
  for (const auto& [first, second] : {std::pair{1.0, 3.0}, {3.0, 1.0}}) {
    const ArrivalMedian early = median_arrival(std::vector<Arrival>{{Kind::before, first}, {Kind::at, second}});
    EXPECT_EQ(early.median.kind, Kind::before);
    EXPECT_EQ(early.median.time, 2);
  }
}

TEST(Arrival, LateIsWhenNineteenOfTwentyHaveArrived) {
  using Kind = Arrival::Kind;
  std::vector<Arrival> arrivals;
  for (int i = 1; i <= 4; ++i) arrivals.push_back({Kind::at, static_cast<double>(i)});
  EXPECT_EQ(median_arrival(arrivals).late.time, 4) << "of few, the last";
  for (int i = 5; i <= 19; ++i) arrivals.push_back({Kind::at, static_cast<double>(i)});
  arrivals.push_back({Kind::never, 7});
  EXPECT_EQ(median_arrival(arrivals).late.time, 19);
  arrivals.push_back({Kind::never, 7});
  EXPECT_EQ(median_arrival(arrivals).late.kind, Kind::never);
}

TEST(Statistics, SharesHaveIntervalsThatHoldThem) {
  EXPECT_EQ(share_interval(0, 10).low, 0);
  EXPECT_NEAR(share_interval(0, 10).high, 0.3085, 1e-4);  // 1 - 0.025^(1/10)
  EXPECT_NEAR(share_interval(5, 10).low, 0.1871, 1e-4);
  EXPECT_NEAR(share_interval(5, 10).high, 0.8129, 1e-4);
  EXPECT_EQ(share_interval(10, 10).high, 1);
}

TEST(Statistics, TailIndexIsThatOfAPowerLaw) {
  Pcg32 rng(5, 3);
  for (const double index : {0.7, 1.5, 4.0}) {
    std::vector<double> values(40000);
    for (double& value : values) value = std::pow(1 - rng.next_float(), -1 / index);
    EXPECT_NEAR(tail_index(values, 0.05), index, 0.1 * index);
    for (double& value : values) value *= 1000;
    EXPECT_NEAR(tail_index(values, 0.05), index, 0.1 * index) << "whatever the unit";
  }
  EXPECT_EQ(tail_index(std::vector<double>(100, 3.0), 0.05), lightest_tail);
  std::vector<double> few(100, 0.0);
  few[7] = 1e9;
  EXPECT_EQ(tail_index(few, 0.05), 0) << "one pixel has all the light";
}

TEST(ParetoFront, HoldsWhatNothingBeats) {
  const std::vector<dvec2> points{{3, 1}, {1, 3}, {2, 2}, {2, 2}, {2.5, 2}, {4, 1}, {1, 5}};
  EXPECT_EQ(pareto_front(points), (std::vector<std::size_t>{1, 2, 0}));
  EXPECT_TRUE(pareto_front({}).empty());
}

struct Replicates {
  std::vector<Image> images;
  Image reference;
};

Replicates noisy(double bias, double sd, std::size_t count, std::uint64_t seed) {
  Normal normal(seed);
  Replicates result{{}, Image(ivec2(64, 48))};
  for (dvec3& pixel : result.reference.pixels) pixel = dvec3(1, 2, 3);
  for (std::size_t r = 0; r < count; ++r) {
    Image& image = result.images.emplace_back(ivec2(64, 48));
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
      image.pixels[i] = result.reference.pixels[i] + bias + sd * dvec3(normal(), normal(), normal());
  }
  return result;
}

BiasVariance split_of(const Replicates& r, double reference_variance) {
  std::vector<std::size_t> pixels(r.reference.pixels.size());
  std::iota(pixels.begin(), pixels.end(), std::size_t{0});
  return bias_variance(r.images.size(), error_products(r.images, r.reference, pixels), reference_variance);
}

TEST(BiasVariance, SplitsTheErrorOfReplicates) {
  const Replicates r = noisy(0.1, 0.5, 8, 5);
  const BiasVariance split = split_of(r, 0);
  EXPECT_NEAR(split.variance, 0.25, 0.01);
  EXPECT_NEAR(split.bias_squared, 0.01, 5 * split.standard_error);
  EXPECT_GT(split.bias_squared, 3 * split.standard_error);
  EXPECT_EQ(split.count, 8u);
  // The reference's own variance is no bias.
  EXPECT_NEAR(split_of(r, 0.01).bias_squared, split.bias_squared - 0.01, 1e-12);
}

TEST(BiasVariance, OfAnUnbiasedMethodIsZeroWithinItsError) {
  double sum = 0, squares = 0;
  constexpr int trials = 40;
  for (int t = 0; t < trials; ++t) {
    const auto split = split_of(noisy(0, 0.5, 4, 100 + static_cast<std::uint64_t>(t)), 0);
    sum += split.bias_squared;
    squares += split.bias_squared * split.bias_squared;
  }
  EXPECT_LT(std::abs(sum), 4 * std::sqrt(squares));
}

}  // namespace
}  // namespace etendue
