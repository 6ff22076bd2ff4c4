// Radius policies against their formulas, and the progressive photon mappers against closed forms.
#include "framework/scene/builder.h"
#include "framework/structure_names.h"
#include "integrators/adaptive_bandwidth.h"
#include "integrators/chi_squared_radius.h"
#include "tests/render_scene.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::exact_image;
using testing::render;
using testing::RenderOptions;

constexpr const char* methods[] = {"ppm", "sppm", "ppm-memoryless", "appm", "cppm"};

// --- The policies.

const SurfacePoint origin{vec3(0), {0, 0, 1}, {0, 0, 1}, {1, 0, 0}, vec2(0), 0, no_id};

Scene white_plane() {
  SceneBuilder builder("white plane");
  builder.mesh(quad({-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}), builder.material(Diffuse{Rgb(1)}));
  return builder.finish();
}

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
  PlanePhotons(const std::vector<vec2>& positions) : scene_(white_plane()), bsdf_(scene_, origin) {
    Photons photons;
    for (const vec2& p : positions) photons.add(vec3(p, 0), Rgb(1), {0, 0, 1}, {0, 0, 1}, photon_indirect, 1);
    map_.build(std::move(photons), find_point_structure("brute", {}).make(), {0, 1, Kernel::box, true});
  }

  GatherSite site(std::uint32_t pass = 0) const { return {0, pass, map_, at_}; }

  template <class Observed>
  void observe(const GatherDisc& disc, Observed& observed) const {
    observed.begin(disc, at_, Rgb(1));
    map_.gather(at_, disc.reach, [&](const auto&... photon) { observed.add(photon...); });
  }

  // Runs a pass of `policy` on these photons; returns the irradiance.
  template <RadiusPolicy Policy>
  double gather(Policy& policy, std::uint32_t pass, Kernel kernel = Kernel::box) const {
    const GatherDisc disc = policy.disc(site(pass));
    typename Policy::Observed observed;
    observed.begin(disc, at_, Rgb(1));
    double sum = 0;
    map_.gather(at_, disc.reach, [&](const Rgb& reflected, const vec3& offset, float distance_squared) {
      observed.add(reflected, offset, distance_squared);
      const float x = distance_squared / square(disc.radius);
      if (x <= 1) sum += reflected.x * kernel_shape(kernel, x);
    });
    const double radiance = sum / (std::numbers::pi * square(disc.radius));
    policy.update(0, pass, observed);
    return radiance * std::numbers::pi;
  }

 private:
  Scene scene_;
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

// --- The methods.

struct BiasEstimate {
  double mean = 0, deviation = 0, bound = 0;
};

BiasEstimate bias_over_seeds(const Scene& scene, const char* method, RenderOptions options, int seeds) {
  const Image exact = exact_image(scene, options.resolution);
  double sum = 0, squares = 0, bound = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    options.seed = static_cast<std::uint64_t>(seed);
    const auto rendered = render(scene, method, options);
    EXPECT_EQ(rendered.non_finite, 0u);
    const double b = bias(rendered.image, exact);
    sum += b;
    squares += b * b;
    bound = rendered.expectation.bias_bound;
  }
  const double mean = sum / seeds;
  return {mean, std::sqrt(std::max(0.0, squares / seeds - mean * mean) / (seeds - 1)), bound};
}

RenderOptions options_for(std::int64_t photons, std::uint32_t iterations, ParamMap more = {}) {
  RenderOptions options;
  options.params = std::move(more);
  options.params["photons"] = {photons, {}};
  options.iterations = iterations;
  return options;
}

const ParamMap by_photons{{"direct", {std::string("photons"), {}}}};

TEST(ProgressivePhotons, MatchClosedFormsWithinTheirDeclaredBias) {
  for (const char* name : {"builtin:lambert-sphere", "builtin:lambert-sphere-off-centre", "builtin:furnace"})
    for (const char* method : methods)
      for (const ParamMap& params : {ParamMap{}, by_photons}) {
        RenderOptions options = options_for(2000, 4, params);
        options.resolution = {12, 12};
        const auto b = bias_over_seeds(load_scene(name), method, options, 10);
        EXPECT_LT(std::abs(b.mean), b.bound + 4 * b.deviation) << name << " " << method;
        // No edge; only direct light off the centre is uneven.
        if (!params.empty() && name == std::string("builtin:lambert-sphere-off-centre")) continue;
        EXPECT_LT(std::abs(b.mean), 0.003 + 4 * b.deviation) << name << " " << method;
      }
}

TEST(ProgressivePhotons, SphereHasNoKernelBiasAtAnyRadius) {
  // A ball of radius r cuts pi r^2 out of a sphere, evenly in d^2.
  const Scene scene = load_scene("builtin:lambert-sphere");
  for (const char* method : methods)
    for (const double radius : {0.2, 1.0}) {
      RenderOptions options = options_for(2000, 8, by_photons);
      options.params["radius"] = {radius, {}};
      options.resolution = {16, 16};
      const auto b = bias_over_seeds(scene, method, options, 6);
      EXPECT_LT(std::abs(b.mean), 0.001 + 5 * b.deviation) << method << " " << radius;
    }
}

TEST(ProgressivePhotons, MeasuredDiscsLoseNoLightAtEdges) {
  // Even light to the border of a surface two metres wide.
  const Scene scene = load_scene("builtin:edge");
  for (const char* method : methods)
    for (const char* edges : {"disc", "measured"}) {
      RenderOptions options = options_for(3000, 8, by_photons);
      options.params["radius"] = {0.4, {}};
      options.params["edges"] = {std::string(edges), {}};
      options.resolution = {24, 24};
      const double bias = etendue::bias(render(scene, method, options).image, exact_image(scene, options.resolution));
      if (edges == std::string("disc"))
        EXPECT_LT(bias, -0.06) << method;
      else
        EXPECT_NEAR(bias, 0, 0.015) << method;
    }
}

TEST(ProgressivePhotons, DiscsEndAtWallsThatHideBrightLight) {
  // Two rooms on one floor, a wall of 4 cm between them; kernels narrower than that leak nothing.
  const Scene scene = load_scene("builtin:keyhole");
  const auto mean = [&](const char* name, const decltype(ParamValue::value)& value) {
    RenderOptions options = options_for(8000, 16, {{name, {value, {}}}});
    options.resolution = {48, 48};
    const Image image = render(scene, "sppm", options).image;
    dvec3 sum(0);
    for (const dvec3& pixel : image.pixels) sum += pixel;
    return sum.y / static_cast<double>(image.pixels.size());
  };
  const double narrow = mean("radius", 0.03), leaking = mean("clear_radius", false), clear = mean("clear_radius", true);
  EXPECT_GT(leaking, 1.15 * narrow);
  EXPECT_LT(std::abs(clear - narrow), 0.4 * (leaking - narrow));
}

TEST(ProgressivePhotons, ErrorFallsPassByPass) {
  // Light off the centre, all by photons: blur and noise both.
  const Scene scene = load_scene("builtin:lambert-sphere-off-centre");
  for (const char* method : methods) {
    RenderOptions options = options_for(4000, 4, by_photons);
    const Image exact = exact_image(scene, options.resolution);
    const double after_4 = relmse(render(scene, method, options).image, exact);
    options.iterations = 64;
    const double after_64 = relmse(render(scene, method, options).image, exact);
    EXPECT_LT(after_64, after_4 / 3) << method;  // 16^(-2/3) = 0.16 in theory; fixed points keep their aliasing
    EXPECT_LT(after_64, 2e-2) << method;
  }
}

TEST(ProgressivePhotons, DepthLimitTruncatesTheSeries) {
  const Scene scene = load_scene("builtin:lambert-sphere");
  for (const char* method : methods)
    for (const ParamMap& params : {ParamMap{}, by_photons})
      for (int depth = 1; depth <= 3; ++depth) {
        RenderOptions options = options_for(10000, 4, params);
        options.params["max_depth"] = {std::int64_t{depth}, {}};
        const Image image = render(scene, method, options).image;
        double mean = 0;
        for (const dvec3& p : image.pixels) mean += p.x / static_cast<double>(image.pixels.size());
        EXPECT_NEAR(mean * std::numbers::pi / (1 - std::pow(0.5, depth)), 1, 0.02) << depth << " " << method;
      }
}

TEST(ProgressivePhotons, WhiteFurnaceStaysWhite) {
  // Glass, mirror, plastic and white; direct light off the white parts, caustics by the others.
  for (const char* method : methods) {
    RenderOptions options = options_for(10000, 8);
    const auto b = bias_over_seeds(load_scene("builtin:white-furnace"), method, options, 4);
    EXPECT_LT(std::abs(b.mean), 0.01 + 4 * b.deviation) << method;
  }
}

TEST(ProgressivePhotons, SameBitsAtAnyThreadCount) {
  for (const char* name : {"builtin:cornell-spheres", "builtin:glossy-cornell-box"}) {
    const Scene scene = load_scene(name);
    for (const char* method : methods) {
      RenderOptions options = options_for(10000, 3);
      std::uint64_t first = 0;
      for (const int threads : {1, 2, 3}) {
        options.threads = threads;
        const std::uint64_t hash = render(scene, method, options).hash;
        if (threads == 1) first = hash;
        EXPECT_EQ(hash, first) << name << " " << method << " " << threads;
      }
    }
  }
}

TEST(ProgressivePhotons, EveryParameterChangesTheImage) {
  const Scene rough = load_scene("builtin:veach-mis");
  const Scene spheres = load_scene("builtin:cornell-spheres");
  using Value = decltype(ParamValue::value);
  const auto made = [&](const Scene& scene, const char* method, const char* name, const Value& value) {
    RenderOptions options = options_for(2000, 6);
    options.resolution = {12, 12};
    options.params[name] = {value, {}};
    return render(scene, method, options);
  };
  const std::pair<const char*, Value> changes[] = {
      {"photons", std::int64_t{3000}},
      {"neighbours", std::int64_t{9}},
      {"radius", 0.05},
      {"direct", "photons"},
      {"kernel", "box"},
      {"side_test", false},
      {"edges", "disc"},
      {"max_depth", std::int64_t{2}},
      {"sampler", "independent"},
  };
  for (const char* method : methods) {
    const auto plain = made(spheres, method, "photons", std::int64_t{2000});
    for (const auto& [name, value] : changes)
      EXPECT_NE(made(spheres, method, name, value).hash, plain.hash) << method << " " << name;
    EXPECT_NE(made(rough, method, "carry_below", 0.01).hash, made(rough, method, "carry_below", 0.25).hash) << method;
    EXPECT_NE(made(rough, method, "flanks", "followed").hash, made(rough, method, "flanks", "gathered").hash) << method;
    for (const char* structure : point_structure_names)  // the order of photons, and so of sums, is theirs
      EXPECT_LT(relmse(made(spheres, method, "structure", structure).image, plain.image), 1e-8) << method << structure;
  }
  const auto by_pixels = [&](double photons) {
    RenderOptions options = options_for(0, 1, {{"photons_per_pixel", {photons, {}}}});
    options.resolution = {12, 12};
    return render(spheres, "sppm", options).hash;
  };
  EXPECT_EQ(by_pixels(1), by_pixels(2)) << "20000 at least";
  EXPECT_NE(by_pixels(1), by_pixels(200));
  for (const char* method : {"ppm", "sppm", "ppm-memoryless"})
    EXPECT_NE(made(spheres, method, "alpha", 0.5).hash, made(spheres, method, "alpha", 0.9).hash) << method;
  EXPECT_NE(made(spheres, "cppm", "hypothesis", "odd").hash, made(spheres, "cppm", "hypothesis", "even").hash);
  const auto with_beta = [&](double beta) {
    RenderOptions options = options_for(4000, 24, {{"beta", {beta, {}}}});
    options.resolution = {12, 12};
    return render(spheres, "cppm", options).hash;
  };
  EXPECT_NE(with_beta(1), with_beta(4)) << "felt from the second refusal on";
  EXPECT_NE(made(spheres, "ppm", "points", std::int64_t{1}).hash, made(spheres, "ppm", "points", std::int64_t{2}).hash);
}

}  // namespace
}  // namespace etendue
