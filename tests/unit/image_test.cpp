#include "framework/image/film.h"
#include "framework/image/metrics.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

TEST(Film, ManySamplesOfAConstantGiveThatConstant) {
  Film film({1, 1});
  for (std::uint32_t i = 0; i < 1u << 25; ++i) film.add({0, 0}, Rgb(0.1f), i);
  EXPECT_EQ(film.mean().at(0, 0), dvec3(0.1f));
}

TEST(Film, NonFiniteSamplesAreDroppedCountedAndKept) {
  Film film({2, 2});
  film.add({1, 0}, Rgb(1), 0);
  film.add({1, 0}, Rgb(std::nanf("")), 7);
  film.add({0, 1}, Rgb(infinity, 0, 0), 3);
  EXPECT_EQ(film.mean().at(1, 0), dvec3(0.5));
  EXPECT_EQ(film.non_finite_count(), 2u);
  ASSERT_EQ(film.non_finite().size(), 2u);
  EXPECT_EQ(film.non_finite()[0].iteration, 3u);
  EXPECT_EQ(film.non_finite()[1].pixel, ivec2(1, 0));
}

Image constant(double value) {
  Image image({10, 10});
  for (dvec3& p : image.pixels) p = dvec3(value);
  return image;
}

TEST(Metrics, MatchTheirFormulasOnConstants) {
  const Image x = constant(0.6), r = constant(0.5);
  EXPECT_NEAR(mse(x, r), 0.01, 1e-15);
  EXPECT_NEAR(relmse(x, r), 0.01 / (0.25 + 0.01), 1e-15);
  EXPECT_NEAR(smape(x, r), 0.1 / 1.1, 1e-15);
  EXPECT_NEAR(bias(x, r), 0.2, 1e-15);
}

TEST(Metrics, NoPixelIsSkipped) {
  Image r = constant(0.5), x = r;
  r.at(3, 3) = dvec3(0);
  x.at(3, 3) = dvec3(1);
  EXPECT_NEAR(relmse(x, r), 1 / 0.01 / 100, 1e-12);
  EXPECT_NEAR(smape(x, r), 1.0 / 100, 1e-12);
}

TEST(Metrics, TrimmingDropsTheWorstTenthOfAPercent) {
  Image r({50, 40}), x = r;
  x.at(0, 0) = x.at(1, 0) = dvec3(1000);
  x.at(2, 0) = dvec3(1);
  EXPECT_NEAR(trimmed_relmse(x, r), 1 / 0.01 / 1998, 1e-9);
}

TEST(Metrics, BiasOverABlackReferenceIsAbsolute) { EXPECT_NEAR(bias(constant(0.3), constant(0)), 0.3, 1e-15); }

TEST(Metrics, ErrorsOfOppositeSignCancelInTheBiasAlone) {
  Image x = constant(0.5);
  x.at(0, 0) = dvec3(0.9);
  x.at(1, 0) = dvec3(0.1);
  EXPECT_NEAR(bias(x, constant(0.5)), 0, 1e-15);
  EXPECT_NEAR(mse(x, constant(0.5)), 2 * 0.16 / 100, 1e-15);
}

TEST(Metrics, EqualImagesHaveNoError) {
  for (const Metric& metric : metrics()) EXPECT_EQ(metric.compute(constant(2), constant(2)), 0) << metric.name;
}

}  // namespace
}  // namespace etendue
