// Path-space filtering against closed forms and path tracing; its image must not depend on threads.
#include "framework/core/counters.h"
#include "tests/block_agreement.h"
#include "tests/image_checks.h"

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

// Whatever share of the paths is followed to the limit.
TEST(HashCache, DepthLimitTruncatesTheSeries) {
  RenderOptions options;
  for (const char* trace_on : {"0", "0.05", "1"}) {
    options.params = params_of({{"trace_on", trace_on}});
    testing::expect_truncated_series("hash-cache", options, 6e-3, 6);
  }
}

// Where depths have cells of their own, a path that goes on where it could end asks no further ones: that of its pixel and one
// more at most are asked.
TEST(HashCache, PathsThatGoOnAskNoFurtherCells) {
  const Scene scene = load_scene("builtin:lambert-sphere");
  const auto lookups_a_path = [&](std::int64_t max_depth) {
    RenderOptions options;
    options.iterations = 16;
    options.params = params_of({{"trace_on", "1"}});
    options.params["max_depth"] = {max_depth, {}};
    options.params["roulette_depth"] = {max_depth, {}};
    reset_counters();
    render(scene, "hash-cache", options);
    const auto lookups = static_cast<double>(read_counters()[static_cast<std::size_t>(Counter::lookups)]);
    return lookups / (16.0 * options.resolution.x * options.resolution.y);
  };
  const double apart = lookups_a_path(16), shared = lookups_a_path(17);
  EXPECT_LT(apart, 0.5 * shared) << "the first samples find cells without a value, and ask on";
  EXPECT_GT(shared, 10);
}

TEST(HashCache, MakesThePathTracersImage) {
  for (const char* scene : {"builtin:cornell-box", "builtin:cornell-spheres", "builtin:glossy-cornell-box"})
    testing::expect_agreement(load_scene(scene), {.resolution = {24, 24}, .block = 12, .comparisons = 3}, {"path", {}, 128, 0},
                              {{"hash-cache", {}, 64, 0.02}});
}

RenderOptions longer() {
  RenderOptions options;
  options.resolution = {48, 48};
  options.iterations = 64;
  return options;
}

// A path that ends with a cell beside the lamp's rim samples its light there. Light samples alone have no bound, and one of
// them stood in its cell for a hundred samples: of eight seeds the worst had 1.5e-3, half of them 1.5e-4.
TEST(HashCache, LearnsNoFirefliesBesideALamp) {
  const Scene scene = load_scene("builtin:cavity");
  RenderOptions options = longer();
  const Image exact = exact_image(scene, options.resolution);
  for (options.seed = 1; options.seed <= 4; ++options.seed)
    EXPECT_LT(relmse(render(scene, "hash-cache", options).image, exact), 3e-4) << options.seed;
}

// A twentieth of the paths that end with a cell meets light there, and it counts for all.
TEST(HashCache, CountsLightThatFewPathsMeet) {
  const Scene scene = load_scene("builtin:concentric-spheres");
  const RenderOptions options = longer();
  const Image exact = exact_image(scene, options.resolution);
  EXPECT_LT(std::abs(testing::bias_over_seeds(scene, "hash-cache", options, 4, exact).mean), 0.0015);
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
  testing::expect_same_bits_at_any_thread_count(load_scene("builtin:cornell-spheres"), "hash-cache", options);
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
