// Discs that are wider where photons lie evenly: what tells that they do, what noise they save, and what they cost at borders.
#include "integrators/photons/disc_moments.h"
#include "integrators/photons/photon_gather.h"
#include "tests/scene_context.h"
#include "tests/white_plane.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::origin;
using testing::SceneContext;
using testing::white_plane;

// Takes photons uniform in the disc of radius 1 / 2, whose power depends on where they are.
template <class Power>
float unevenness(int photons, Pcg32& random, const Power& power) {
  DiscMoments moments({0, 0, 1}, 0.25f);
  for (int i = 0; i < photons; ++i) {
    vec2 p;
    do p = vec2(random.next_float(), random.next_float()) - 0.5f;
    while (glm::dot(p, p) > 0.25f);
    moments.add(power(p), vec3(p, 0), glm::dot(p, p));
  }
  return moments.unevenness();
}

TEST(DiscMoments, OfEvenPhotonsAreChiSquaredOfFiveDegrees) {
  constexpr int trials = 10000;
  constexpr double limit = 11.070;  // exceeded by 5 %
  for (const float least : {1.0f, 0.2f}) {
    Pcg32 random(3, 5);
    double sum = 0, above = 0;
    for (int i = 0; i < trials; ++i) {
      const float q = unevenness(80, random, [&](const vec2&) { return Rgb(glm::mix(least, 1.0f, random.next_float())); });
      sum += q;
      above += q > limit;
    }
    EXPECT_NEAR(sum / trials, 5, 0.15) << least;
    EXPECT_NEAR(above / trials, 0.05, 0.015) << least;
  }
}

TEST(DiscMoments, DoNotDependOnTheUnitOfPower) {
  const auto of = [](float watt) {
    Pcg32 random(3, 5);
    return unevenness(80, random, [&](const vec2& p) { return watt * Rgb(0.3f + p.x * p.x, 0.5f, 0.1f); });
  };
  for (const float unit : {0x1p-80f, 0x1p-120f, 0x1p80f}) EXPECT_EQ(of(unit), of(1)) << unit;
}

TEST(DiscMoments, TellBordersRidgesPeaksAndColoursFromEvenLight) {
  Pcg32 random(7, 5);
  const auto lit = [](bool where) { return Rgb(where ? 1.0f : 0.1f); };
  for (int i = 0; i < 20; ++i) {
    EXPECT_GT(unevenness(160, random, [&](const vec2& p) { return lit(p.x < 0.1f); }), 20);
    EXPECT_GT(unevenness(160, random, [&](const vec2& p) { return lit(std::abs(p.x + p.y) < 0.15f); }), 20);
    EXPECT_GT(unevenness(160, random, [&](const vec2& p) { return lit(glm::dot(p, p) < 0.08f); }), 20);
    const auto two_colours = [](const vec2& p) { return p.y < 0 ? Rgb(1, 0, 0) : Rgb(0, 0.2973f, 0); };  // of one luminance
    EXPECT_GT(unevenness(160, random, two_colours), 20);
  }
}

// Estimates along the x axis from maps of random photons, one to a square metre on the mean, where x < border.
class RandomMaps {
 public:
  RandomMaps(bool widen, float border, std::vector<float> at) : at_(std::move(at)), sums_(at_.size()), squares_(at_.size()) {
    const SceneContext plane(white_plane());
    const Bsdf bsdf(plane.scene, origin);
    for (int trial = 0; trial < trials; ++trial) {
      Pcg32 random(29, static_cast<std::uint64_t>(trial));
      Photons photons;
      for (int i = 0; i < 4 * half * half; ++i) {
        const vec3 p((2 * random.next_float() - 1) * half, (2 * random.next_float() - 1) * half, 0);
        if (p.x < border) photons.add(p, Rgb(pi), {0, 0, 1}, 1, {0, 0, 1}, photon_caustic, 1);
      }
      PhotonMap map;
      map.build(std::move(photons), find_point_structure("hash-grid", {}).make(), {.k = 10, .widen = widen});
      for (std::size_t i = 0; i < at_.size(); ++i) {
        SurfacePoint point = origin;
        point.position.x = at_[i];
        const double e = map.radiance(plane.context, point, bsdf, {0, 0, 1}, photon_any, 64).x;
        sums_[i] += e;
        squares_[i] += e * e;
      }
    }
  }
  double mean(std::size_t i) const { return sums_[i] / trials; }
  double variance(std::size_t i) const { return squares_[i] / trials - mean(i) * mean(i); }

  static constexpr int trials = 400;

 private:
  static constexpr int half = 16;
  std::vector<float> at_;
  std::vector<double> sums_, squares_;
};

TEST(EvenDiscs, KeepTheMeanOfEvenLightAndShedItsNoise) {
  const std::vector<float> at{-6, -3, 0, 3, 6};
  const RandomMaps narrow(false, infinity, at), even(true, infinity, at);
  double mean = 0, variance = 0, of_narrow = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    mean += even.mean(i) / static_cast<double>(at.size());
    variance += even.variance(i);
    of_narrow += narrow.variance(i);
  }
  // It is as if all points of a map had one estimate.
  const double error = std::sqrt(variance / static_cast<double>(at.size()) / RandomMaps::trials);
  EXPECT_NEAR(mean, 1, 3 * error);
  EXPECT_LT(error, 0.0105);
  EXPECT_LT(variance, 0.3 * of_narrow);
}

// The square of the bias beside a straight border is what many iterations leave.
TEST(EvenDiscs, LoseHardlyMoreAtABorder) {
  std::vector<float> at(32);
  for (std::size_t i = 0; i < at.size(); ++i) at[i] = 0.3f * (static_cast<float>(i) - 24 + 0.5f);
  const RandomMaps narrow(false, 0, at), even(true, 0, at);
  double bias = 0, of_narrow = 0;
  const auto squared_bias = [&](const RandomMaps& maps, std::size_t i) {
    const double off = maps.mean(i) - (at[i] < 0 ? 1 : 0);
    return off * off - maps.variance(i) / RandomMaps::trials;
  };
  for (std::size_t i = 0; i < at.size(); ++i) {
    bias += squared_bias(even, i);
    of_narrow += squared_bias(narrow, i);
  }
  EXPECT_LT(bias, 1.05 * of_narrow) << bias << " of " << of_narrow;
}

}  // namespace
}  // namespace etendue
