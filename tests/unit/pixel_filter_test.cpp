// Pixel filters: places are drawn as their functions say, negative parts included, and weights are spread evenly.
#include "framework/scene/pixel_filter.h"
#include "framework/core/rng.h"

#include <gtest/gtest.h>

#include <cmath>

namespace etendue {
namespace {

const std::vector<FilterShape> filter_shapes{{.radius = {1.5f, 0.75f}},
                                             {.kind = FilterKind::triangle, .radius = {1, 2}},
                                             {.kind = FilterKind::gaussian, .radius = vec2(2), .sigma = 0.6f},
                                             {.kind = FilterKind::mitchell, .radius = {2, 1.5f}},
                                             {.kind = FilterKind::mitchell, .radius = vec2(2), .b = 0, .c = 0.5f},
                                             {.kind = FilterKind::sinc, .radius = vec2(3), .tau = 3}};

// The mean of a function of the offset, by the filter's own values on a grid and by weighted samples.
template <class Function>
void expect_mean(const PixelFilter& filter, const Function& function) {
  const vec2 radius = filter.shape().radius;
  constexpr int side = 400, samples = 200'000;
  double exact = 0, integral = 0, sum = 0, weights = 0;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const vec2 at = radius * (2.0f * (vec2(i, j) + 0.5f) / float(side) - 1.0f);
      const double share = filter.density(at) * 4.0 * radius.x * radius.y / (side * side);
      integral += share;
      exact += share * function(at);
    }
  Pcg32 rng(3, 1);
  for (std::uint32_t i = 0; i < samples; ++i) {
    const float x = rng.next_float();
    const vec2 at = filter.place({x, rng.next_float()}, i / 50, i % 50) - 0.5f;
    EXPECT_LE(std::abs(at.x), radius.x);
    EXPECT_LE(std::abs(at.y), radius.y);
    const double weight = filter.weight(i / 50, i % 50);
    sum += weight * function(at);
    weights += weight;
  }
  EXPECT_NEAR(integral, 1, 2e-3) << filter.shape().text();
  EXPECT_NEAR(sum / weights, exact, 0.012) << filter.shape().text();
}

TEST(PixelFilter, PlacesAreDrawnFromIt) {
  for (const FilterShape& shape : filter_shapes) {
    const PixelFilter filter(shape);
    expect_mean(filter, [](const vec2& at) { return at.x < 0.3f ? 1.0 : 0.0; });
    expect_mean(filter, [](const vec2& at) { return at.y < -0.2f && at.x > 0.1f ? 1.0 : 0.0; });
    expect_mean(filter, [](const vec2& at) { return std::cos(at.x) * std::cos(2.0f * at.y); });
  }
}

TEST(PixelFilter, ABoxOfOnePixelIsNone) {
  EXPECT_EQ(make_pixel_filter({}), nullptr);
  EXPECT_EQ(make_pixel_filter(named_filter("box")), nullptr);
  const PixelFilter box(FilterShape{});
  EXPECT_NEAR(box.place({0.25f, 0.75f}, 7, 3).x, 0.25f, 1e-6f);
  EXPECT_NEAR(box.place({0.25f, 0.75f}, 7, 3).y, 0.75f, 1e-6f);
}

// Among any first samples of a pixel, as many are negative as the filter has of negative parts, to within one.
TEST(PixelFilter, NegativeSamplesAreSpreadEvenly) {
  const PixelFilter lanczos(filter_shapes.back());
  double expected = 0;
  for (std::uint64_t pixel = 0; pixel < 1000; ++pixel) expected += (1 - lanczos.weight(pixel, 64)) / 2 / 1000;
  for (std::uint64_t pixel = 0; pixel < 20; ++pixel) {
    double negative = 0;
    for (std::uint32_t i = 0; i < 64; ++i) {
      negative += (1 - lanczos.weight(pixel, i)) / 2;
      EXPECT_NEAR(negative, expected * (i + 1), 1 + 0.05 * (i + 1));
    }
  }
  EXPECT_FALSE(PixelFilter(filter_shapes[2]).is_signed());
}

TEST(PixelFilter, WeightsOfTheFirstSamplesNeverCancel) {
  for (const FilterShape& shape : filter_shapes) {
    const PixelFilter filter(shape);
    for (std::uint64_t pixel = 0; pixel < 200; ++pixel) {
      double sum = 0;
      for (std::uint32_t i = 0; i < 40; ++i) EXPECT_GT(sum += filter.weight(pixel, i), 0) << i;
    }
  }
}

TEST(PixelFilter, UnknownNamesAreErrors) {
  try {
    named_filter("gausian");
    FAIL();
  } catch (const std::exception& e) {
    EXPECT_TRUE(std::string(e.what()).starts_with("--pixel-filter: unknown pixel filter 'gausian'; did you mean 'gaussian'?"));
  }
}

}  // namespace
}  // namespace etendue
