// Radius policies of the progressive photon mappers against their formulas.
#include "accel/registry.h"
#include "framework/core/rng.h"
#include "framework/scene/builder.h"
#include "integrators/progressive/adaptive_bandwidth.h"
#include "integrators/progressive/chi_squared_radius.h"
#include "integrators/progressive/radius_policy.h"
#include "tests/scene_context.h"
#include "tests/white_plane.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace etendue {
namespace {

using testing::origin;
using testing::SceneContext;
using testing::white_plane;

int poisson(Pcg32& random, double mean) {
  int count = 0;
  for (; mean > 0; mean -= 16)
    for (double product = random.next_float(); product > std::exp(-std::min(mean, 16.0)); product *= random.next_float())
      ++count;
  return count;
}

// Photons of unit power on the plane z = 0, seen from above at its centre.
class PlanePhotons {
 public:
  PlanePhotons(const std::vector<vec2>& positions) : bsdf_(stage().scene, origin) {
    Photons photons;
    for (const vec2& p : positions) photons.add(vec3(p, 0), Rgb(1), {0, 0, 1}, 1, {0, 0, 1}, photon_indirect, 1);
    map_.build(std::move(photons), find_point_structure("brute", {}).make(), {0, 1, Kernel::box, true});
  }

  GatherSite site(std::uint32_t pass = 0) const { return {stage().context, 0, pass, map_, at_}; }

  template <class Observed>
  void observe(const GatherDisc& disc, Observed& observed) const {
    observed.begin(disc, at_, Rgb(1));
    map_.gather(at_, disc.reach, infinity, [&](const GatheredPhoton& photon, const auto& /*way*/) {
      observed.add(photon.reflected, photon.offset, photon.distance_squared);
    });
  }

  // Runs a pass of `policy` on these photons; returns the irradiance.
  template <RadiusPolicy Policy>
  double gather(Policy& policy, std::uint32_t pass, Kernel kernel = Kernel::box) const {
    const GatherDisc disc = policy.disc(site(pass));
    typename Policy::Observed observed;
    observed.begin(disc, at_, Rgb(1));
    double sum = 0;
    map_.gather(at_, disc.reach, infinity, [&](const GatheredPhoton& photon, const auto& /*way*/) {
      observed.add(photon.reflected, photon.offset, photon.distance_squared);
      const float x = photon.distance_squared / square(disc.radius);
      if (x <= 1) sum += photon.reflected.x * kernel_shape(kernel, x);
    });
    const double radiance = sum / (std::numbers::pi * square(disc.radius));
    policy.update(0, pass, observed);
    return radiance * std::numbers::pi;
  }

 private:
  static const SceneContext& stage() {
    static const SceneContext plane(white_plane());
    return plane;
  }

  Bsdf bsdf_;
  GatherPoint at_{origin, bsdf_, {0, 0, 1}, photon_any, 64};
  PhotonMap map_;
};

// Uniform over a square.
class UniformPhotons : public PlanePhotons {
 public:
  UniformPhotons(int count, float half, std::uint64_t seed) : PlanePhotons(positions(count, half, seed)) {}

 private:
  static std::vector<vec2> positions(int count, float half, std::uint64_t seed) {
    Pcg32 random(seed, 1);
    std::vector<vec2> all;
    for (int i = 0; i < count; ++i) {
      const float x = random.next_float() * 2 - 1;
      all.push_back(half * vec2(x, random.next_float() * 2 - 1));
    }
    return all;
  }
};

// Density scale (1 + 2 |d|^2) within 1.5 m.
class CurvedPhotons : public PlanePhotons {
 public:
  CurvedPhotons(double scale, std::uint64_t seed) : PlanePhotons(positions(scale, seed)) {}

 private:
  static std::vector<vec2> positions(double scale, std::uint64_t seed) {
    constexpr double half = 1.5, highest = 1 + 4 * half * half;
    Pcg32 random(seed, 2);
    std::vector<vec2> all;
    for (int left = poisson(random, scale * highest * 4 * half * half); left > 0; --left) {
      const float x = random.next_float() * 2 - 1;
      const vec2 p = static_cast<float>(half) * vec2(x, random.next_float() * 2 - 1);
      if (random.next_float() * highest < 1 + 2 * glm::dot(p, p)) all.push_back(p);
    }
    return all;
  }
};

TEST(RadiusPolicy, MemorylessSequenceFollowsItsRecurrenceAndItsLimit) {
  for (const double alpha : {0.3, 2.0 / 3, 0.9, 1.0}) {
    double squared = 1;
    for (std::uint32_t i = 1; i <= 1000; ++i) {
      EXPECT_NEAR(square(memoryless_shrinkage(i - 1, alpha)) / squared, 1, 2e-6) << i;
      squared *= (i + alpha) / (i + 1);
    }
    const double n = 1e6, limit = std::pow(n, alpha - 1) / std::tgamma(1 + alpha);
    EXPECT_NEAR(square(memoryless_shrinkage(999999, alpha)) / limit, 1, 1e-5);
  }
}

TEST(RadiusPolicy, SharedStatisticsKeepTheDensityAndShrinkAsThePaperHasIt) {
  // At even density d, M = d pi r^2 and, by induction, N = alpha-share of all found with N / (pi r^2) growing by d a pass.
  SharedStatistics policy(InitialRadii{1}, 0.7);
  const double d = 50;
  const UniformPhotons map(1, 1, 1);
  double radius = 1, kept = 0;
  for (std::uint32_t pass = 0; pass < 2000; ++pass) {
    ASSERT_NEAR(policy.disc(map.site(pass)).radius / radius, 1, 1e-4);
    const auto m = static_cast<std::uint32_t>(std::lround(1000 * d * std::numbers::pi * radius * radius));
    policy.update(0, pass, {m});
    radius *= std::sqrt((kept + 0.7 * m) / (kept + m));
    kept += 0.7 * m;
    ASSERT_NEAR(kept / (std::numbers::pi * radius * radius) / (1000 * d * (pass + 1)), 1, 1e-3) << "the density is kept";
  }
  // r_n^2 ~ n^(alpha - 1).
  const double before = radius;
  for (std::uint32_t pass = 2000; pass < 20000; ++pass) {
    const auto m =
        static_cast<std::uint32_t>(std::lround(1000 * d * std::numbers::pi * square(policy.disc(map.site(pass)).radius)));
    policy.update(0, pass, {m});
  }
  EXPECT_NEAR(2 * std::log(policy.disc(map.site()).radius / before) / std::log(10.0), -0.3, 0.005);
}

TEST(RadiusPolicy, SharedStatisticsKeepTheRadiusWhereNothingIsFound) {
  SharedStatistics policy(InitialRadii{0.5f}, 0.7);
  const UniformPhotons map(1, 1, 1);
  policy.update(0, 0, {0});
  EXPECT_EQ(policy.disc(map.site()).radius, 0.5f);
}

TEST(RadiusPolicy, NearestRadiusLeavesTheEstimateUnbiasedWithKnownVariance) {
  // n = 100 photons in 100 m^2: mean 1, variance (n - k + 1) / ((k - 2) n) (see NearestPhotons in photon_map_test.cpp).
  constexpr int trials = 4000, k = 20;
  double sum = 0, squares = 0;
  for (int trial = 0; trial < trials; ++trial) {
    NearestRadius policy(k, 100);
    const double d = UniformPhotons(100, 5, static_cast<std::uint64_t>(trial)).gather(policy, 0);
    sum += d;
    squares += d * d;
  }
  const double mean = sum / trials, variance = squares / trials - mean * mean;
  EXPECT_NEAR(mean, 1, 4.5 * std::sqrt(variance / trials));
  EXPECT_NEAR(variance * (k - 2) / 0.81, 1, 0.1);
}

TEST(RadiusPolicy, ProgressiveMeanOfUniformPhotonsIsUnbiasedWithTheVarianceOfTheory) {
  // Relative variance of the mean of n memoryless passes: V1 Gamma(1 + a) / (2 - a) n^-a, V1 = 1 / photons in the first disc.
  constexpr int trials = 300, passes = 50;
  constexpr double alpha = 2.0 / 3;
  double sum = 0, squares = 0, in_theory = 0;
  for (std::uint32_t pass = 0; pass < passes; ++pass) in_theory += 1 / square(memoryless_shrinkage(pass, alpha));
  in_theory /= std::numbers::pi * passes * passes;  // one photon per square metre, r_1 = 1
  for (int trial = 0; trial < trials; ++trial) {
    MemorylessRadius policy(InitialRadii{1}, alpha);
    double mean = 0;
    for (std::uint32_t pass = 0; pass < passes; ++pass) {
      policy.begin_pass(pass);
      const auto seed = static_cast<std::uint64_t>(trial * passes) + pass;
      Pcg32 random(seed, 9);
      mean += UniformPhotons(poisson(random, 16), 2, seed).gather(policy, pass) / passes;
    }
    sum += mean;
    squares += mean * mean;
  }
  const double mean = sum / trials, variance = squares / trials - mean * mean;
  EXPECT_NEAR(mean, 1, 4.5 * std::sqrt(variance / trials));
  EXPECT_NEAR(variance / in_theory, 1, 4.5 * std::sqrt(2.0 / trials));
  EXPECT_NEAR(in_theory * std::numbers::pi, std::tgamma(1 + alpha) / (2 - alpha) * std::pow(passes, -alpha), 0.01);
}

// --- Those that look at what they find.

TEST(AdaptiveBandwidth, FindsTheRadiusThatBalancesVarianceAndCurvature) {
  // Photons with density 1 + 2 |d|^2 per square metre (laplacian 8) in Poisson numbers, by rejection, and its box estimate: c =
  // 1 / pi in irradiance, so r_n^6 = (1 / pi) / (6 (8 / 8)^2 n) in the limit. Weight w per photon scales radiance, not r.
  constexpr std::uint32_t passes = 1000;
  constexpr double scale = 40;  // photons per unit of density
  AdaptiveBandwidth policy(InitialRadii{1.2f}, Kernel::box);
  double bias = 0;  // of the mean, by kappa laplacian r^2 = r^2
  for (std::uint32_t pass = 0; pass < passes; ++pass) {
    const CurvedPhotons map(scale, pass);
    bias += square(policy.disc(map.site(pass)).radius) / passes;
    map.gather(policy, pass);
  }
  const double c = 1 / (std::numbers::pi * scale), wanted = std::pow(c / (6 * 1.0 * passes), 1.0 / 6);
  const double radius = policy.disc(CurvedPhotons(scale, 0).site(passes)).radius;
  EXPECT_NEAR(radius / wanted, 1, 0.1);
  EXPECT_NEAR(bias / (1.5 * radius * radius), 1, 0.15) << "and a little for the first, wide ones";
}

TEST(AdaptiveBandwidth, FindsTheSameRadiusInAnyUnitOfLength) {
  const UniformPhotons map(1, 1, 1);
  const auto radius = [&](float unit) {
    AdaptiveBandwidth policy(InitialRadii{1.2f * unit}, Kernel::box);
    for (std::uint32_t pass = 0; pass < 100; ++pass) {
      const GatherDisc disc = policy.disc(map.site(pass));
      AdaptiveBandwidth::Observed observed;
      observed.begin(disc, map.site(pass).at, Rgb(1));
      for (int x = -10; x <= 10; ++x)
        for (int y = -10; y <= 10; ++y) {
          const float d2 = 0.01f * static_cast<float>(x * x + y * y);
          if (d2 * square(unit) <= square(disc.reach))
            observed.add(Rgb((1 + 2 * d2) * square(unit)), vec3(0), d2 * square(unit));
        }
      policy.update(0, pass, observed);
    }
    return policy.disc(map.site(100)).radius / unit;
  };
  EXPECT_LT(radius(1), 0.5f);
  for (const float unit : {0x1p-20f, 0x1p20f}) EXPECT_NEAR(radius(unit) / radius(1), 1, 1e-4) << unit;
}

TEST(ChiSquaredRadius, RefusesEvenCountsAsOftenAsStated) {
  constexpr int trials = 20000;
  for (const int photons : {ChiSquaredRadius::first_count, 600})
    for (const bool odd : {false, true})
      for (const int rings : {1, 2}) {
        int refused = 0;
        Pcg32 random(7, 1);
        for (int trial = 0; trial < trials; ++trial) {
          std::array<std::uint32_t, ChiSquaredRadius::parts> counts{};
          for (int i = 0; i < photons; ++i) ++counts[random.next() % ChiSquaredRadius::parts];
          refused += !ChiSquaredRadius::looks_even(counts, rings, odd);
        }
        EXPECT_NEAR(static_cast<double>(refused) / trials, 0.05, photons < 600 ? 0.025 : 0.006) << odd << " " << rings;
      }
}

TEST(ChiSquaredRadius, PartsAreOfEqualAreaAndCoverTheDisc) {
  const UniformPhotons map(40000, 1, 3);
  ChiSquaredRadius::Observed observed;
  map.observe(GatherDisc(0.9f), observed);
  const double expected = 40000 / 4.0 * std::numbers::pi * square(0.9f) / ChiSquaredRadius::parts;
  for (const auto count : observed.counts) EXPECT_NEAR(count / expected, 1, 5 / std::sqrt(expected));
}

TEST(ChiSquaredRadius, StaysWherePhotonsAreEvenAndShrinksAtAnEdge) {
  constexpr std::uint32_t passes = 100;
  int shrunk = 0;
  for (std::uint64_t trial = 0; trial < 50; ++trial) {
    ChiSquaredRadius policy(InitialRadii{1}, {});
    for (std::uint32_t pass = 0; pass < passes; ++pass) UniformPhotons(20, 1.2f, trial * passes + pass).gather(policy, pass);
    shrunk += policy.disc(UniformPhotons(1, 1, 1).site()).radius < 0.7f;
  }
  EXPECT_LT(shrunk, 20) << "each look at the counts may refuse by chance, so a few do";
  // The square ends within the disc: half of the rings' outer parts are empty.
  for (const bool odd : {false, true}) {
    ChiSquaredRadius policy(InitialRadii{1}, {1.5625f, odd});
    for (std::uint32_t pass = 0; pass < passes; ++pass) UniformPhotons(20, 0.5f, pass).gather(policy, pass);
    const float radius = policy.disc(UniformPhotons(1, 1, 1).site()).radius;
    EXPECT_LT(radius, 0.75f) << odd;
    EXPECT_GT(radius, 0.3f) << odd;
  }
}

}  // namespace
}  // namespace etendue
