// Radiance caching against closed forms and path tracing; its image must not depend on threads.
#include "tests/block_agreement.h"
#include "tests/image_checks.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::exact_image;
using testing::params_of;
using testing::render;
using testing::RenderOptions;

TEST(RadianceCache, MatchesClosedForms) {
  for (const char* name : {"builtin:lambert-sphere", "builtin:furnace", "builtin:polygon-light"}) {
    const Scene scene = load_scene(name);
    RenderOptions options;
    options.iterations = 8;
    options.resolution = {16, 16};
    options.params = params_of({{"samples", "128"}});
    const auto rendered = render(scene, "radiance-cache", options);
    EXPECT_EQ(rendered.non_finite, 0u) << name;
    EXPECT_LT(std::abs(bias(rendered.image, exact_image(scene, options.resolution))), 1e-2) << name;
  }
}

TEST(RadianceCache, DepthLimitTruncatesTheSeries) {
  RenderOptions options;
  options.iterations = 8;
  options.resolution = {16, 16};
  options.params = params_of({{"samples", "128"}});
  testing::expect_truncated_series("radiance-cache", options, 1e-2);
}

TEST(RadianceCache, MakesThePathTracersImage) {
  testing::expect_agreement(load_scene("builtin:glossy-cornell-box?alpha=0.6"),
                            {.resolution = {16, 16}, .block = 8, .comparisons = 1}, {"path", {}, 128, 0},
                            {{"radiance-cache", params_of({{"samples", "128"}}), 32, 0.04}});
}

// At the same number of rays, for the time of a ray is nearly all of either's.
TEST(RadianceCache, BeatsThePathTracerOnAGlossyFloor) {
  const Scene scene = load_scene("builtin:glossy-cornell-box");
  const auto rendered = [&](const char* integrator, std::uint32_t iterations, std::uint64_t seed) {
    RenderOptions options;
    options.resolution = {32, 32};
    options.iterations = iterations;
    options.seed = seed;
    return render(scene, integrator, options).image;
  };
  const Image reference = rendered("path", 1024, 9);
  EXPECT_LT(relmse(rendered("radiance-cache", 32, 1), reference), 0.6 * relmse(rendered("path", 136, 1), reference));
}

TEST(RadianceCache, SameBitsAtAnyThreadCount) {
  RenderOptions options;
  options.iterations = 1;
  options.resolution = {20, 20};
  options.params = params_of({{"samples", "64"}});
  testing::expect_same_bits_at_any_thread_count(load_scene("builtin:glossy-cornell-box?alpha=0.6"), "radiance-cache", options);
}

TEST(RadianceCache, EveryParameterChangesTheImageButTheStructure) {
  RenderOptions options;
  options.iterations = 2;
  options.resolution = {20, 20};
  const auto with = [&](const char* key, const char* value) {
    options.params = params_of({{"samples", "64"}});
    options.params[key] = parse_param_value(value, {});
    return render(load_scene("builtin:glossy-cornell-box?alpha=0.6"), "radiance-cache", options).hash;
  };
  const std::uint64_t plain = with("samples", "64");
  for (const auto& [key, value] : {std::pair{"accuracy", "0.5"},
                                   {"samples", "512"},
                                   {"refine", "false"},
                                   {"order", "3"},
                                   {"left_out", "0.002"},
                                   {"lobe_samples", "9"},
                                   {"gradients", "false"},
                                   {"min_spacing", "9"},
                                   {"max_spacing", "0.03"},
                                   {"extra_samples", "0.5"},
                                   {"max_depth", "2"},
                                   {"sampler", "independent"}})
    EXPECT_NE(with(key, value), plain) << key;
  EXPECT_EQ(with("structure", "brute"), plain);
}

}  // namespace
}  // namespace etendue
