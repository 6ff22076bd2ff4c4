// Path guiding against closed forms; its image must not depend on threads.
#include "tests/image_checks.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::exact_image;
using testing::render;
using testing::RenderOptions;

// Guiding small images needs places of few records to learn anything.
ParamMap eager(std::initializer_list<std::pair<const char*, const char*>> more = {}) {
  ParamMap params{{"split", {std::int64_t{500}, {}}}};
  for (const auto& [key, value] : more) params[key] = parse_param_value(value, {});
  return params;
}

void expect_mean_exact(const std::string& scene_name, const ParamMap& params) {
  const Scene scene = load_scene(scene_name);
  RenderOptions options;
  options.params = params;
  options.iterations = 14;
  options.resolution = {20, 20};
  const auto b = testing::bias_over_seeds(scene, "guided", options, 8);
  // 12 such tests, 8 seeds each: Student's t of 7 degrees of freedom at 1e-3 (Sidak) is 6.2. The 4e-5 is single precision's.
  EXPECT_LT(std::abs(b.mean), 6.2 * b.deviation + 4e-5) << scene_name << ": bias " << b.mean << " +- " << b.deviation;
}

TEST(Guided, MatchesEveryClosedForm) {
  for (const char* scene : {"builtin:lambert-sphere", "builtin:lambert-sphere-off-centre", "builtin:furnace",
                            "builtin:white-furnace", "builtin:polygon-light", "builtin:sphere-light", "builtin:disc-light"})
    expect_mean_exact(scene, eager());
}

TEST(Guided, MatchesUnderEveryOption) {
  for (const auto& [key, value] : {std::pair{"combination", "mean"},
                                   {"combination", "last"},
                                   {"fraction", "fixed"},
                                   {"spatial_filter", "stochastic"},
                                   {"mis", "balance"}})
    expect_mean_exact("builtin:lambert-sphere-off-centre", eager({{key, value}}));
}

TEST(Guided, SameBitsAtAnyThreadCount) {
  RenderOptions options;
  options.iterations = 8;
  options.params = eager();
  testing::expect_same_bits_at_any_thread_count(load_scene("builtin:cornell-spheres"), "guided", options);
}

TEST(Guided, EveryParameterChangesTheImage) {
  RenderOptions options;
  options.iterations = 15;
  options.params = eager();
  const Scene scene = load_scene("builtin:cornell-spheres");
  const std::uint64_t plain = render(scene, "guided", options).hash;
  for (const auto& [key, value] : {std::pair{"max_depth", "3"},
                                   {"roulette_depth", "1"},
                                   {"bsdf_fraction", "0.7"},
                                   {"fraction", "fixed"},
                                   {"split", "100"},
                                   {"flux", "0.1"},
                                   {"spatial_filter", "stochastic"},
                                   {"combination", "mean"},
                                   {"mis", "balance"},
                                   {"sampler", "independent"}}) {
    options.params = eager({{key, value}});
    EXPECT_NE(render(scene, "guided", options).hash, plain) << key;
  }
}

// A room lit through a door ajar: at the same samples, guided paths find more of the light.
TEST(Guided, BeatsPathTracingWhereLightIsHardToFind) {
  const Scene scene = load_scene("builtin:two-rooms");
  RenderOptions options;
  options.resolution = {32, 24};
  options.iterations = 62;
  // Unbiased both: the mean squared difference of two images is twice a method's error.
  const auto error = [&](const char* integrator, const ParamMap& params) {
    options.params = params;
    options.seed = 1;
    const Image a = render(scene, integrator, options).image;
    options.seed = 2;
    return trimmed_relmse(render(scene, integrator, options).image, a);
  };
  EXPECT_LT(1.5 * error("guided", {}), error("path", {}));
}

}  // namespace
}  // namespace etendue
