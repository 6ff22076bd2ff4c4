#include "framework/core/arc.h"
#include "framework/core/counters.h"
#include "framework/core/elementary.h"
#include "framework/core/error.h"
#include "framework/core/parallel.h"
#include "framework/core/params.h"
#include "framework/core/sampler.h"
#include "framework/core/sampling.h"
#include "framework/core/units.h"
#include "tests/unit/io_helpers.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

namespace etendue {
namespace {

// The distance to `expected` in units in the last place of Number, those of the least normal one for smaller values.
template <class Number>
double units_off(Number value, long double expected) {
  const auto size = std::max(std::abs(static_cast<Number>(expected)), std::numeric_limits<Number>::min());
  const long double unit = std::nextafter(size, std::numeric_limits<Number>::infinity()) - size;
  return static_cast<double>(std::abs(value - expected) / unit);
}

// Compared with the C library's in 80 bits, over the arguments that transport gives them and beyond.
template <class Number>
void compare_elementary() {
  constexpr int count = 20000;
  double most = 0;
  for (int i = 0; i <= count; ++i) {
    const Number share = Number(i) / count, turn = 14 * share - 7, large = 80 * share - 40, positive = std::exp(large);
    const auto see = [&](const char* name, Number value, long double expected) {
      const double off = units_off(value, expected);
      EXPECT_LE(off, 4) << name << " at " << i;
      most = std::max(most, off);
    };
    const auto wide = [](Number x) { return static_cast<long double>(x); };
    see("sin", math::sin(turn), std::sin(wide(turn)));
    see("cos", math::cos(turn), std::cos(wide(turn)));
    see("tan", math::tan(turn), std::tan(wide(turn)));
    see("asin", math::asin(2 * share - 1), std::asin(wide(2 * share - 1)));
    see("acos", math::acos(2 * share - 1), std::acos(wide(2 * share - 1)));
    see("atan", math::atan(large), std::atan(wide(large)));
    see("atan2", math::atan2(turn, share - 1), std::atan2(wide(turn), wide(share - 1)));
    see("exp", math::exp(large), std::exp(wide(large)));
    see("exp2", math::exp2(large), std::exp2(wide(large)));
    see("log", math::log(positive), std::log(wide(positive)));
    see("log2", math::log2(positive), std::log2(wide(positive)));
    see("pow", math::pow(positive, turn / 7), std::pow(wide(positive), wide(turn / 7)));
    see("hypot", math::hypot(large, turn), std::hypot(wide(large), wide(turn)));
    if constexpr (std::is_same_v<Number, double>) {
      see("expm1", math::expm1(turn), std::expm1(wide(turn)));
      see("log1p", math::log1p(share), std::log1p(wide(share)));
      see("cbrt", math::cbrt(large), std::cbrt(wide(large)));
      see("sinh", math::sinh(turn), std::sinh(wide(turn)));
      see("cosh", math::cosh(turn), std::cosh(wide(turn)));
      see("asinh", math::asinh(large), std::asinh(wide(large)));
      see("lgamma", math::lgamma(3 + 100 * share), std::lgamma(wide(3 + 100 * share)));
    }
  }
  EXPECT_GT(most, 0.5);  // they are rounded, and were compared
}

TEST(Elementary, FunctionsAreWithinFourUnitsInTheLastPlace) {
  compare_elementary<float>();
  compare_elementary<double>();
}

TEST(Elementary, SpecialValuesAreTheirs) {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  EXPECT_EQ(math::exp(-infinite), 0);
  EXPECT_EQ(math::exp(infinite), infinite);
  EXPECT_EQ(math::log(0.0f), -infinite);
  EXPECT_TRUE(std::isnan(math::log(-1.0f)));
  EXPECT_TRUE(std::isnan(math::acos(1.5f)));
  EXPECT_EQ(math::acos(1.0f), 0);
  EXPECT_EQ(math::atan2(0.0f, 0.0f), 0);
  EXPECT_FLOAT_EQ(math::atan2(0.0f, -1.0f), 3.14159265f);
  EXPECT_EQ(math::pow(0.0f, 2.4f), 0);
  EXPECT_EQ(math::sin(0.0), 0);
}

TEST(Units, KnownSuffixesScale) {
  EXPECT_DOUBLE_EQ(parse_seconds("60s"), 60);
  EXPECT_DOUBLE_EQ(parse_seconds("1.5min"), 90);
  EXPECT_DOUBLE_EQ(parse_seconds("1.5"), 1.5);
  EXPECT_DOUBLE_EQ(parse_seconds("250 ms"), 0.25);
  EXPECT_EQ(parse_count("200k"), 200000);
  EXPECT_EQ(parse_count("1.5M"), 1500000);
  EXPECT_EQ(parse_bytes("512MiB"), 512ll << 20);
  EXPECT_EQ(parse_bytes("64MB"), 64'000'000);
  EXPECT_EQ(parse_bytes("1.5 GiB"), 3ll << 29);
}

TEST(Units, BadInputNamesTheUnits) {
  EXPECT_EQ(error_of([] { parse_seconds("60sec"); }),
            "unknown unit in '60sec': expected a time such as \"60s\" (units: s, ms, min, h)");
  for (const char* text : {"", "s", "-1s", "nan", "1e400", "inf s", "1e308h"}) EXPECT_THROW(parse_seconds(text), Error) << text;
  EXPECT_EQ(error_of([] { parse_bytes("512Mb"); }),
            "unknown unit in '512Mb': expected a size such as \"512MiB\" (units: B, kB, KB, MB, GB, KiB, MiB, GiB)");
  EXPECT_THROW(parse_bytes("512"), Error);
  EXPECT_THROW(parse_count("1.5"), Error);
  EXPECT_THROW(parse_count("1e30"), Error);
}

TEST(Names, NearestComeFirst) {
  const std::vector<std::string> names{"photon-map", "path", "irradiance-cache"};
  EXPECT_EQ(nearest_names("pth", names).front(), "path");
  EXPECT_EQ(nearest_names("photon-mpa", names).front(), "photon-map");
  EXPECT_EQ(nearest_names("PATH", names).front(), "path");
  EXPECT_TRUE(nearest_names("zzzz", names).empty());
}

struct SampleParams {
  int photons = 100;
  float radius = 0.5f;
  bool gather = false;
  std::string kernel = "box";
};
template <class Visitor>
void describe(Visitor& v, SampleParams& p) {
  v.integer("photons", p.photons, 1, 1000000, "photons", "how many");
  v.number("radius", p.radius, 0, 10, "metres", "how far");
  v.flag("gather", p.gather, "whether");
  v.choice("kernel", p.kernel, {"box", "cone"}, "which");
}

TEST(Names, OfManyAHundredAreShown) {
  std::vector<std::string> names;
  for (int i = 0; i < 120; ++i) names.push_back(std::to_string(1000 + i));
  EXPECT_TRUE(unknown_name("id", "elsewhere", names).ends_with(" 1098 1099 and 20 more"))
      << unknown_name("id", "elsewhere", names);
}

TEST(Names, ThoseWithSpacesAreToldApart) {
  const std::vector<std::string> names{"path tracing", "photon map", "vcm"};
  EXPECT_EQ(unknown_name("method", "zzzz", names), "unknown method 'zzzz'; available: 'path tracing', 'photon map', 'vcm'");
}

TEST(Params, ValuesAreReadByType) {
  const Location here{"x.toml", 3, 5};
  const ParamMap map{{"photons", {std::string("200k"), here}},
                     {"radius", {std::int64_t{2}, here}},
                     {"gather", {true, here}},
                     {"kernel", {std::string("cone"), here}}};
  const auto p = read_params<SampleParams>(map, "sample");
  EXPECT_EQ(p.photons, 200000);
  EXPECT_EQ(p.radius, 2);
  EXPECT_TRUE(p.gather);
  EXPECT_EQ(p.kernel, "cone");
}

TEST(Params, MistakesSayWhereAndWhatWasExpected) {
  const Location here{"x.toml", 3, 5};
  const auto read = [&](const char* name, const ParamValue& value) {
    return error_of([&] { read_params<SampleParams>({{name, value}}, "sample"); });
  };
  EXPECT_EQ(
      read("photon", {std::int64_t{1}, here}),
      "x.toml:3:5: sample: unknown parameter 'photon'; did you mean 'photons'? (available: photons radius gather kernel)");
  EXPECT_EQ(read("photons", {2.5, here}),
            "x.toml:3:5: sample: photons = 2.5 is a number; expected an integer such as 1000 or \"200k\"");
  EXPECT_EQ(read("radius", {std::int64_t{11}, here}),
            "x.toml:3:5: sample: radius = 11 is out of range; expected 0 .. 10 metres");
  EXPECT_NE(read("radius", {std::nan(""), here}), "");
  EXPECT_EQ(read("gather", {std::int64_t{1}, here}), "x.toml:3:5: sample: gather = 1 is an integer; expected true or false");
  EXPECT_EQ(read("kernel", {std::string("cnoe"), here}),
            "x.toml:3:5: sample: unknown kernel 'cnoe'; did you mean 'cone'? (available: box cone)");
}

TEST(Arc, TurnOfIsTheArcTangentAtAllSizes) {
  for (int i = 0; i < 40000; ++i) {
    const double angle = 2 * std::numbers::pi * i / 40000, size = std::pow(10.0, i % 61 - 30);
    const auto x = static_cast<float>(size * std::cos(angle)), y = static_cast<float>(size * std::sin(angle));
    double exact = std::atan2(double(y), double(x)) / (2 * std::numbers::pi);
    if (exact < 0) exact += 1;
    EXPECT_NEAR(turn_of(x, y), exact, 8e-8) << x << ' ' << y;
  }
  EXPECT_EQ(turn_of(0, 0), 0);
  EXPECT_EQ(turn_of(-1, 0), 0.5f);
  EXPECT_EQ(turn_of(0, -1), 0.75f);
}

TEST(Sampler, SobolPointsFillElementaryIntervals) {
  // 2^8 points of a scrambled (0,2)-sequence: each box of area 2^-8, whatever its shape, holds exactly one.
  for (int pixel = 0; pixel < 4; ++pixel) {
    for (int bits_x = 0; bits_x <= 8; ++bits_x) {
      std::set<int> boxes;
      for (std::uint32_t i = 0; i < 256; ++i) {
        const vec2 u = Sampler(SamplerKind::sobol, 7, Stream::test, pixel, i).get_2d();
        ASSERT_TRUE(u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1);
        boxes.insert(static_cast<int>(u.x * static_cast<float>(1 << bits_x)) << (8 - bits_x) |
                     static_cast<int>(u.y * static_cast<float>(1 << (8 - bits_x))));
      }
      EXPECT_EQ(boxes.size(), 256u) << bits_x;
    }
  }
}

TEST(Sampler, KeysGiveDifferentNumbersAndSameKeysTheSame) {
  const auto first = [](SamplerKind kind, std::uint64_t seed, Stream stream, std::uint64_t pixel, std::uint32_t iteration) {
    return Sampler(kind, seed, stream, pixel, iteration).get_1d();
  };
  for (const SamplerKind kind : {SamplerKind::sobol, SamplerKind::independent}) {
    const float base = first(kind, 1, Stream::camera, 5, 9);
    EXPECT_EQ(base, first(kind, 1, Stream::camera, 5, 9));
    EXPECT_NE(base, first(kind, 2, Stream::camera, 5, 9));
    EXPECT_NE(base, first(kind, 1, Stream::light_path, 5, 9));
    EXPECT_NE(base, first(kind, 1, Stream::camera, 6, 9));
    EXPECT_NE(base, first(kind, 1, Stream::camera, 5, 10));
  }
}

TEST(Sampler, DimensionsAreUncorrelated) {
  for (const SamplerKind kind : {SamplerKind::sobol, SamplerKind::independent}) {
    constexpr int n = 1 << 14;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      Sampler s(kind, 3, Stream::test, i, 0);
      const float a = s.get_1d(), b = s.get_2d().x, c = s.get_1d();
      sum += (a - 0.5) * (b - 0.5) + (b - 0.5) * (c - 0.5);
    }
    EXPECT_LT(std::abs(sum / n), 5 * std::sqrt(2.0) / 12 / std::sqrt(n));
  }
}

TEST(Sampler, PairsOfDimensionsAreUncorrelatedAlongIterations) {
  // Pairs that are shuffled alike would rise and fall together, from one iteration of a pixel to the next.
  for (const SamplerKind kind : {SamplerKind::sobol, SamplerKind::independent}) {
    constexpr int n = 1 << 6, pixels = 1 << 8;
    double square = 0;
    for (int pixel = 0; pixel < pixels; ++pixel) {
      double sum = 0;
      for (std::uint32_t i = 0; i < n; ++i) {
        Sampler s(kind, 3, Stream::test, static_cast<std::uint64_t>(pixel), i);
        const float a = s.get_1d(), b = s.get_1d();
        sum += (a - 0.5) * (b - 0.5);
      }
      square += sum * sum;
    }
    // Independent numbers give n / 144. A shuffle within blocks keeps neighbours together, which makes it up to twice as much;
    // equal shuffles would make it some n^2 / 144.
    EXPECT_LT(square / pixels, 3 * n / (12.0 * 12.0));
  }
}

TEST(Parallel, EveryPixelOnceAtAnyThreadCount) {
  for (const int threads : {1, 2, 3}) {
    std::vector<std::atomic<int>> visits(37 * 21);
    with_threads(threads, [&] {
      parallel_pixels({37, 21}, [&](ivec2 p) { ++visits[static_cast<std::size_t>(p.y) * 37 + p.x]; });
    });
    for (const auto& v : visits) ASSERT_EQ(v, 1);
  }
}

TEST(Counters, SumOverThreads) {
  reset_counters();
  with_threads(3, [] { parallel_for(1000, 1, [](std::size_t) { count(Counter::rays, 2); }); });
  EXPECT_EQ(read_counters()[static_cast<std::size_t>(Counter::rays)], 2000u);
  reset_counters();
  EXPECT_EQ(read_counters()[static_cast<std::size_t>(Counter::rays)], 0u);
}

// The cosine of a narrow cone's directions has few values as a float; the sine must not.
TEST(Sampling, NarrowConesAreFilledEvenly) {
  for (const float height : {1e-9f, 1e-6f, 1e-4f, 0.5f}) {
    constexpr int steps = 4096;
    double inner = 0, nearest = 1, mean = 0;
    for (int i = 0; i < steps; ++i) {
      const float u = (static_cast<float>(i) + 0.5f) / steps;
      const vec3 d = sample_cone(vec2(u, 0.3f), height);
      const double share = (static_cast<double>(d.x) * d.x + static_cast<double>(d.y) * d.y) / (height * (2.0 - height));
      mean += share / steps;
      inner += share < 0.25 ? 1.0 / steps : 0;
      nearest = std::min(nearest, share);
    }
    EXPECT_LT(nearest, 1e-3) << height;
    if (height > 0.1f) continue;  // there the square of the sine goes with the height no more
    EXPECT_NEAR(mean, 0.5, 1e-3) << height;
    EXPECT_NEAR(inner, 0.25, 1e-3) << height;
  }
}

}  // namespace
}  // namespace etendue
