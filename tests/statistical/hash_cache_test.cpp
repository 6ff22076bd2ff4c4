// Path-space filtering against closed forms and path tracing; its image must not depend on threads.
#include "tests/block_agreement.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::exact_image;
using testing::params_of;
using testing::render;
using testing::RenderOptions;

// Where indirect light is even, a cell's size is no bias. The mean over seeds lies within its standard error, which is small
// enough to see half a percent.
TEST(HashCache, MatchesClosedForms) {
  constexpr int seeds = 16;
  const std::vector<const char*> names{"builtin:lambert-sphere", "builtin:lambert-sphere-off-centre",
                                       "builtin:furnace",        "builtin:white-furnace",
                                       "builtin:polygon-light",  "builtin:sphere-light"};
  const double limit = student_t_quantile(1 - sidak_level(1e-3, names.size()) / 2, seeds - 1);
  for (const char* name : names) {
    const Scene scene = load_scene(name);
    RenderOptions options;
    options.iterations = 12;
    const Image exact = exact_image(scene, options.resolution);
    std::vector<double> biases;
    for (options.seed = 1; options.seed <= seeds; ++options.seed) {
      const auto rendered = render(scene, "hash-cache", options);
      EXPECT_EQ(rendered.non_finite, 0u) << name;
      biases.push_back(bias(rendered.image, exact));
    }
    const double error = sample_sd(biases) / std::sqrt(double(seeds));
    EXPECT_LE(std::abs(mean(biases)), limit * error + 1e-4) << name << ": " << mean(biases) << " +- " << error;
    EXPECT_LT(limit * error, 5e-3) << name;
  }
}

TEST(HashCache, DepthLimitTruncatesTheSeries) {
  const Scene scene = load_scene("builtin:lambert-sphere");
  for (int depth = 1; depth <= 3; ++depth) {
    RenderOptions options;
    options.params["max_depth"] = {std::int64_t{depth}, {}};
    const auto image = render(scene, "hash-cache", options).image;
    double mean = 0;
    for (const dvec3& p : image.pixels) mean += p.x / static_cast<double>(image.pixels.size());
    EXPECT_NEAR(mean * static_cast<double>(pi) / (1 - std::pow(0.5, depth)), 1, 6e-3) << depth;
  }
}

TEST(HashCache, MakesThePathTracersImage) {
  for (const char* scene : {"builtin:cornell-box", "builtin:cornell-spheres", "builtin:glossy-cornell-box"})
    testing::expect_agreement(load_scene(scene), {.resolution = {24, 24}, .block = 12, .comparisons = 3}, {"path", {}, 128, 0},
                              {{"hash-cache", {}, 64, 0.02}});
}

// The metal reflects what the cache has smoothed: at the same samples, and in about the same time, a fraction of the
// error.
TEST(HashCache, BeatsPathTracingInTheGlossyBox) {
  const Scene scene = load_scene("builtin:glossy-cornell-box");
  RenderOptions options;
  options.resolution = {48, 48};
  options.iterations = 256;
  options.seed = 100;
  const Image reference = render(scene, "path", options).image;
  options.iterations = 16;
  options.seed = 1;
  const double path = relmse(render(scene, "path", options).image, reference);
  EXPECT_LT(3 * relmse(render(scene, "hash-cache", options).image, reference), path);
}

TEST(HashCache, SameBitsAtAnyThreadCount) {
  RenderOptions options;
  options.iterations = 4;
  std::uint64_t first = 0;
  for (const int threads : {1, 2, 3}) {
    options.threads = threads;
    const std::uint64_t hash = render(load_scene("builtin:cornell-spheres"), "hash-cache", options).hash;
    if (threads == 1) first = hash;
    EXPECT_EQ(hash, first) << threads;
  }
}

TEST(HashCache, EveryParameterChangesTheImage) {
  RenderOptions options;
  options.iterations = 4;
  options.resolution = {64, 64};
  const Scene scene = load_scene("builtin:cornell-spheres");
  const std::uint64_t plain = render(scene, "hash-cache", options).hash;
  for (const auto& [key, value] : {std::pair{"max_depth", "3"},
                                   {"roulette_depth", "1"},
                                   {"finest", "8"},
                                   {"enough", "400"},
                                   {"trace_on", "1"},
                                   {"light_samples", "1"},
                                   {"sampler", "independent"}}) {
    options.params = params_of({{key, value}});
    EXPECT_NE(render(scene, "hash-cache", options).hash, plain) << key;
  }
}

}  // namespace
}  // namespace etendue
