// The hash grid of path-space filtering.
#include "integrators/path_space/path_space_grid.h"
#include "framework/core/parallel.h"
#include "framework/core/sampler.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

const Bounds room{vec3(0), vec3(1)};
constexpr vec3 up{0, 1, 0};
const vec3 aslant = glm::normalize(vec3(-1, 1, 0));

// Values on the floor of the room, or on the slope across it, one per vector's turn.
template <class Value>
std::vector<std::vector<CachedValue>> floor_values(std::uint32_t count, std::uint64_t seed, const Value& value,
                                                   const vec3& normal = up) {
  std::vector<std::vector<CachedValue>> values(4);
  for (std::uint32_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, seed, Stream::test, i, 0);
    const vec2 u = sampler.get_2d();
    const vec3 position(u.x, normal == up ? 0 : u.x, u.y);
    values[i % 4].push_back({position, normal, 0, value(position)});
  }
  return values;
}

PathSpaceGridOptions eye_above(float finest_edge, float enough) { return {{0.5f, 1, 0.5f}, finest_edge, 1, enough}; }

TEST(PathSpaceGrid, AnswersOnlyWhereEnoughWasSeen) {
  PathSpaceGrid grid(room, eye_above(0.02f, 16));
  EXPECT_FALSE(grid.mean({0.5f, 0, 0.5f}, up, 0));
  grid.add(std::vector<std::vector<CachedValue>>{std::vector<CachedValue>(15, {{0.5f, 0, 0.5f}, up, 0, Rgb(2)})});
  EXPECT_FALSE(grid.mean({0.5f, 0, 0.5f}, up, 0));
  grid.add(std::vector<std::vector<CachedValue>>{{{{0.5f, 0, 0.5f}, up, 0, Rgb(18)}}});
  EXPECT_NEAR(grid.mean({0.5f, 0, 0.5f}, up, 0).value().x, 3, 1e-5);
  grid.begin(7);  // 8 samples: four times as many are enough
  EXPECT_FALSE(grid.mean({0.5f, 0, 0.5f}, up, 0));
  EXPECT_NEAR(grid.smooth_mean({0.5f, 0, 0.5f}, up, 0, vec2(0.5f)).value().x, 3, 1e-5);  // few are better than none
  EXPECT_FALSE(grid.smooth_mean({0.5f, 0, 0.5f}, -up, 0, vec2(0.5f)));
}

// The blur of the first samples' large cells must not stay: of 64 samples the first would weigh a 64th, and leave 2.55.
TEST(PathSpaceGrid, ForgetsItsFirstValues) {
  PathSpaceGrid grid(room, eye_above(0.02f, 1));
  for (std::uint32_t sample = 0; sample < 64; ++sample) {
    grid.begin(sample);
    grid.add(floor_values(2000, sample, [&](const vec3&) { return Rgb(sample == 0 ? 100.0f : 1.0f); }));
  }
  EXPECT_NEAR(grid.smooth_mean({0.5f, 0, 0.5f}, up, 0, vec2(0.5f)).value().x, 1, 0.15);
}

TEST(PathSpaceGrid, ScatterIsThatOfValuesWithinCells) {
  PathSpaceGrid grid(room, eye_above(0.02f, 16));
  EXPECT_EQ(grid.scatter(), 0);
  // Two places, one a hundred times as bright: of values 0 and 4, and of 400 throughout.
  std::vector<CachedValue> values;
  for (int i = 0; i < 100; ++i) {
    values.push_back({{0.1f, 0, 0.1f}, up, 0, Rgb(i % 4 == 0 ? 4.0f : 0.0f)});
    values.push_back({{0.9f, 0, 0.9f}, up, 0, Rgb(400)});
  }
  grid.add(std::vector<std::vector<CachedValue>>{values});
  EXPECT_NEAR(grid.scatter(), 0.5f * std::sqrt(3.0f), 1e-3f);
}

TEST(PathSpaceGrid, ConstantIsItsOwnMeanEverywhere) {
  PathSpaceGrid grid(room, eye_above(0.02f, 16));
  grid.add(floor_values(50000, 1, [](const vec3&) { return Rgb(0.5f, 1, 2); }));
  for (std::uint32_t i = 0; i < 500; ++i) {
    Sampler sampler(SamplerKind::sobol, 9, Stream::test, 0, i);
    const vec2 u = 0.1f + 0.8f * sampler.get_2d();
    const Rgb error = grid.smooth_mean({u.x, 0, u.y}, up, 0, sampler.get_2d()).value() - Rgb(0.5f, 1, 2);
    EXPECT_LT(max_component(glm::abs(error)), 1e-5f) << i;
  }
}

TEST(PathSpaceGrid, NormalsSidesAndDepthsAreApart) {
  PathSpaceGrid grid(room, eye_above(0.02f, 1));
  const vec3 p{0.5f, 0, 0.5f};
  grid.add(std::vector<std::vector<CachedValue>>{
      {{p, up, 0, Rgb(1)}, {p, -up, 0, Rgb(2)}, {p, {1, 0, 0}, 0, Rgb(3)}, {p, up, 1, Rgb(4)}}});
  EXPECT_EQ(grid.smooth_mean(p, up, 0, vec2(0.5f)).value(), Rgb(1));
  EXPECT_EQ(grid.smooth_mean(p, -up, 0, vec2(0.5f)).value(), Rgb(2));
  EXPECT_EQ(grid.smooth_mean(p, {1, 0, 0}, 0, vec2(0.5f)).value(), Rgb(3));
  EXPECT_EQ(grid.smooth_mean(p, up, 1, vec2(0.5f)).value(), Rgb(4));
}

// A slope is answered as it is up to the floor's edge, beyond which nothing was seen: cells' means err there by a half of their
// size, what the ridge leaves of that is little.
TEST(PathSpaceGrid, FollowsASlopeToItsEnd) {
  for (const float x : {0.002f, 0.3f, 0.998f}) {
    PathSpaceGrid grid(room, eye_above(0.1f, 400));
    grid.add(floor_values(100000, 2, [](const vec3& p) { return Rgb(1 + p.x); }));
    for (std::uint32_t i = 0; i < 200; ++i) {
      Sampler sampler(SamplerKind::sobol, 9, Stream::test, 1, i);
      const vec2 u = sampler.get_2d();
      const vec3 place(x, 0, 0.1f + 0.8f * u.x);
      const float jitter = 0.2f * std::abs(u.y - 0.5f);  // up to half a cell, of whose place the answer is
      EXPECT_NEAR(grid.smooth_mean(place, up, 0, {0.5f, u.y}).value().x, 1 + x, 0.01f + jitter) << x;
    }
    double sum = 0;
    constexpr std::uint32_t lookups = 4000;
    for (std::uint32_t i = 0; i < lookups; ++i) {
      Sampler sampler(SamplerKind::sobol, 9, Stream::test, 2, i);
      sum += grid.smooth_mean({x, 0, 0.5f}, up, 0, sampler.get_2d()).value().x / lookups;
    }
    if (x == 0.3f) {
      EXPECT_NEAR(sum, 1 + x, 0.003);
    }
  }
}

// Where much falls to nothing within a cell, answers stay positive, and their mean is that of the values.
TEST(PathSpaceGrid, KeepsTheMeanOfWhatNearlyVanishes) {
  const auto peak = [](const vec3& p) { return Rgb(std::exp(-40 * p.x)); };
  for (const vec3& normal : {up, aslant}) {
    PathSpaceGrid grid(room, eye_above(0.3f, 1000));
    const auto values = floor_values(50000, 3, peak, normal);
    grid.add(values);
    double given = 0, answered = 0;
    for (const auto& some : values)
      for (const CachedValue& value : some) {
        const float answer = grid.smooth_mean(value.position, normal, 0, vec2(0.5f)).value().x;
        EXPECT_GE(answer, -1e-6f);
        given += value.value.x;
        answered += answer;
      }
    EXPECT_NEAR(answered / given, 1, 1e-3);
  }
}

// The error of a lookup falls with the cell's size, which shrinks as values come in.
TEST(PathSpaceGrid, BlursWithinCellsThatShrink) {
  double before = infinity;
  for (const std::uint32_t count : {2000u, 32000u, 512000u}) {
    PathSpaceGrid grid(room, eye_above(0.002f, 32));
    grid.add(floor_values(count, 2, [](const vec3& p) { return Rgb(1 + std::sin(6 * p.x)); }));
    double squares = 0;
    constexpr std::uint32_t lookups = 4000;
    for (std::uint32_t i = 0; i < lookups; ++i) {
      Sampler sampler(SamplerKind::sobol, 9, Stream::test, 1, i);
      const vec2 u = 0.1f + 0.8f * sampler.get_2d();
      const double error = grid.smooth_mean({u.x, 0, u.y}, up, 0, sampler.get_2d()).value().x - 1 - std::sin(6 * u.x);
      squares += error * error / lookups;
    }
    EXPECT_LT(squares, 0.2 * before) << count;
    before = squares;
  }
}

// The variance that is stated of noisy values at places in cells of their own, against the scatter of their means over seeds:
// before older values lose half of their weight, when they have, and when others have come. Sums of weights, taken for numbers
// of values, would state 1.2, 2.4 and 1.7 times the variance.
TEST(PathSpaceGrid, StatesTheVarianceOfItsAnswers) {
  constexpr double over_jitter = 32.0 / 45;  // what is stated is of the mean over jitter, of which there is none here
  constexpr int seeds = 400, stages = 3, places = 16, values = 20;
  constexpr std::uint32_t halved = 8;
  double sum[stages][places] = {}, squares[stages][places] = {}, stated[stages] = {};
  const auto place = [](int i) { return vec3(0.1f, 0, 0.1f) + 0.25f * vec3(i % 4, 0, i / 4); };
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    PathSpaceGrid grid(room, eye_above(1, 1));
    const auto add = [&](std::uint32_t sample) {
      Sampler sampler(SamplerKind::independent, seed, Stream::test, sample, 0);
      std::vector<std::vector<CachedValue>> all(places);
      for (int i = 0; i < values * places; ++i)
        all[i % places].push_back({place(i % places), up, 0, Rgb(sampler.get_1d() < 0.25f ? 4.0f : 0.0f)});
      grid.add(all);
    };
    const auto ask = [&](int stage) {
      for (int i = 0; i < places; ++i) {
        const double answer = grid.smooth_mean(place(i), up, 0, vec2(0.5f)).value().x;
        sum[stage][i] += answer;
        squares[stage][i] += answer * answer;
        stated[stage] += square(grid.error(place(i), up, 0, vec2(0.5f), Rgb(1)).noise);
      }
    };
    for (std::uint32_t sample = 0; sample < halved; ++sample) {
      grid.begin(sample);
      add(sample);
    }
    ask(0);
    grid.begin(halved);
    ask(1);
    add(halved);
    ask(2);
  }
  for (int stage = 0; stage < stages; ++stage) {
    double scattered = 0;
    for (int i = 0; i < places; ++i)
      scattered += (squares[stage][i] - sum[stage][i] * sum[stage][i] / seeds) * seeds / (seeds - 1);
    EXPECT_NEAR(stated[stage] / scattered, over_jitter, 0.08 * over_jitter) << stage;
  }
}

// The mean of a pixel's answers to all samples, of which each rests on all values so far, against its scatter over seeds. Taken
// for fully correlated they would have twice the variance.
TEST(PathSpaceGrid, StatesTheVarianceOfTheMeanOfItsAnswers) {
  constexpr double over_jitter = 32.0 / 45;
  constexpr int seeds = 600;
  const vec3 place(0.3f, 0, 0.3f);
  for (const std::uint32_t samples : {24u, 64u}) {
    const double weights = 0.5 * samples * (samples + 1);
    double sum = 0, squares = 0, stated = 0;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      PathSpaceGrid grid(room, eye_above(1, 1));
      CachedLight light(ivec2(1), true, PathSpaceGrid::forgetting);
      Film film(ivec2(1));
      double mean = 0;
      for (std::uint32_t sample = 0; sample < samples; ++sample) {
        Sampler sampler(SamplerKind::independent, seed, Stream::test, sample, 0);
        std::vector<CachedValue> values;
        for (int i = 0; i < 20; ++i) values.push_back({place, up, 0, Rgb(sampler.get_1d() < 0.25f ? 4.0f : 0.0f)});
        grid.begin(sample);
        grid.add(std::vector<std::vector<CachedValue>>{values});
        light.begin(sample, sample + 1.0);
        // The answers are left out: their own scatter from sample to sample would be stated as well.
        light.add(film, ivec2(0), Rgb(0), Rgb(0), grid.error(place, up, 0, vec2(0.5f), Rgb(1)));
        mean += (sample + 1) / weights * grid.smooth_mean(place, up, 0, vec2(0.5f)).value().x;
      }
      sum += mean;
      squares += mean * mean;
      stated += square(light.standard_error().pixels[0].x);
    }
    const double scattered = (squares - sum * sum / seeds) * seeds / (seeds - 1);
    EXPECT_NEAR(stated / scattered, over_jitter, 0.15 * over_jitter) << samples;
  }
}

// Where light bends, cells say by how much they blur it, and with which sign.
TEST(PathSpaceGrid, StatesTheBiasOfItsAnswers) {
  for (const float bend : {-1.0f, 1.0f}) {
    PathSpaceGrid grid(room, eye_above(0.1f, 400));
    const auto light = [bend](float x) { return 2 + bend * square(x - 0.5f); };
    grid.add(floor_values(200000, 2, [&](const vec3& p) { return Rgb(light(p.x)); }));
    double error = 0, stated = 0;
    constexpr std::uint32_t lookups = 20000;
    for (std::uint32_t i = 0; i < lookups; ++i) {
      Sampler sampler(SamplerKind::sobol, 9, Stream::test, 1, i);
      const vec2 u = 0.2f + 0.6f * sampler.get_2d(), jitter = sampler.get_2d();
      const vec3 place(u.x, 0, u.y);
      error += (grid.smooth_mean(place, up, 0, jitter).value().x - light(u.x)) / lookups;
      stated += grid.error(place, up, 0, jitter, Rgb(1)).bias / lookups;
    }
    EXPECT_GT(bend * error, 1e-5);
    EXPECT_GT(stated / error, 0.4);
    EXPECT_LT(stated / error, 1.6);
  }
}

TEST(PathSpaceGrid, DependsOnNoThread) {
  float first = 0;
  for (const int threads : {1, 2, 3}) {
    PathSpaceGrid grid(room, eye_above(0.01f, 8));
    float sum = 0;
    with_threads(threads, [&] {
      for (std::uint32_t round = 0; round < 3; ++round) {
        grid.begin(round);
        grid.add(floor_values(5000, round, [](const vec3& p) { return Rgb(0.1f + p.x * p.z); }));
      }
    });
    for (std::uint32_t i = 0; i < 500; ++i) {
      Sampler sampler(SamplerKind::sobol, 9, Stream::test, 2, i);
      const vec2 u = sampler.get_2d();
      sum += grid.smooth_mean({u.x, 0, u.y}, up, 0, sampler.get_2d()).value_or(Rgb(7)).x;
    }
    if (threads == 1) first = sum;
    EXPECT_EQ(sum, first) << threads;
  }
}

}  // namespace
}  // namespace etendue
