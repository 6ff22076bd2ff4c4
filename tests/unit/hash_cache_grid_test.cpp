// The hash grid of path-space filtering.
#include "integrators/hash_cache_grid.h"
#include "framework/core/parallel.h"
#include "framework/core/sampler.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

const Bounds room{vec3(0), vec3(1)};
constexpr vec3 up{0, 1, 0};

// Values on the floor of the room, one per vector's turn.
template <class Value>
std::vector<std::vector<CachedValue>> floor_values(std::uint32_t count, std::uint64_t seed, const Value& value) {
  std::vector<std::vector<CachedValue>> values(4);
  for (std::uint32_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, seed, Stream::test, i, 0);
    const vec2 u = sampler.get_2d();
    const vec3 position(u.x, 0, u.y);
    values[i % 4].push_back({position, up, 0, value(position)});
  }
  return values;
}

HashGridOptions eye_above(float finest_edge, float enough) { return {{0.5f, 1, 0.5f}, finest_edge, 1, enough}; }

TEST(HashGrid, AnswersOnlyWhereEnoughWasSeen) {
  HashGrid grid(room, eye_above(0.02f, 16));
  EXPECT_FALSE(grid.mean({0.5f, 0, 0.5f}, up, 0, vec2(0.5f)));
  grid.add(std::vector<std::vector<CachedValue>>{std::vector<CachedValue>(15, {{0.5f, 0, 0.5f}, up, 0, Rgb(2)})});
  EXPECT_FALSE(grid.mean({0.5f, 0, 0.5f}, up, 0, vec2(0.5f)));
  grid.add(std::vector<std::vector<CachedValue>>{{{{0.5f, 0, 0.5f}, up, 0, Rgb(18)}}});
  EXPECT_EQ(grid.mean({0.5f, 0, 0.5f}, up, 0, vec2(0.5f)).value(), Rgb(3));
  grid.begin(7);  // 8 samples: four times as many are enough
  EXPECT_FALSE(grid.mean({0.5f, 0, 0.5f}, up, 0, vec2(0.5f)));
}

TEST(HashGrid, ConstantIsItsOwnMeanEverywhere) {
  HashGrid grid(room, eye_above(0.02f, 16));
  grid.add(floor_values(50000, 1, [](const vec3&) { return Rgb(0.5f, 1, 2); }));
  for (std::uint32_t i = 0; i < 500; ++i) {
    Sampler sampler(SamplerKind::sobol, 9, Stream::test, 0, i);
    const vec2 u = 0.1f + 0.8f * sampler.get_2d();
    EXPECT_EQ(grid.mean({u.x, 0, u.y}, up, 0, sampler.get_2d()).value(), Rgb(0.5f, 1, 2)) << i;
  }
}

TEST(HashGrid, NormalsSidesAndDepthsAreApart) {
  HashGrid grid(room, eye_above(0.02f, 1));
  const vec3 p{0.5f, 0, 0.5f};
  grid.add(std::vector<std::vector<CachedValue>>{
      {{p, up, 0, Rgb(1)}, {p, -up, 0, Rgb(2)}, {p, {1, 0, 0}, 0, Rgb(3)}, {p, up, 1, Rgb(4)}}});
  EXPECT_EQ(grid.mean(p, up, 0, vec2(0.5f)).value(), Rgb(1));
  EXPECT_EQ(grid.mean(p, -up, 0, vec2(0.5f)).value(), Rgb(2));
  EXPECT_EQ(grid.mean(p, {1, 0, 0}, 0, vec2(0.5f)).value(), Rgb(3));
  EXPECT_EQ(grid.mean(p, up, 1, vec2(0.5f)).value(), Rgb(4));
}

// A slope: the mean over the jittered cells is the value at the point, and the error of one lookup is within the cell's edge,
// which shrinks as values come in.
TEST(HashGrid, BlursWithinCellsThatShrink) {
  double before = infinity;
  for (const std::uint32_t count : {2000u, 32000u, 512000u}) {
    HashGrid grid(room, eye_above(0.002f, 32));
    grid.add(floor_values(count, 2, [](const vec3& p) { return Rgb(p.x); }));
    double sum = 0, squares = 0;
    constexpr int lookups = 4000;
    for (std::uint32_t i = 0; i < lookups; ++i) {
      Sampler sampler(SamplerKind::sobol, 9, Stream::test, 1, i);
      const double error = grid.mean({0.5f, 0, 0.5f}, up, 0, sampler.get_2d()).value().x - 0.5;
      sum += error / lookups;
      squares += error * error / lookups;
    }
    EXPECT_LT(std::abs(sum), 0.3 * std::sqrt(squares)) << count;
    EXPECT_LT(squares, 0.2 * before) << count;
    before = squares;
  }
}

TEST(HashGrid, DependsOnNoThread) {
  float first = 0;
  for (const int threads : {1, 2, 3}) {
    HashGrid grid(room, eye_above(0.01f, 8));
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
      sum += grid.mean({u.x, 0, u.y}, up, 0, sampler.get_2d()).value_or(Rgb(7)).x;
    }
    if (threads == 1) first = sum;
    EXPECT_EQ(sum, first) << threads;
  }
}

}  // namespace
}  // namespace etendue
