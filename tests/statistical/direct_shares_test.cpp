// Further camera paths of photon mappers where emission and direct light scatter: less noise, and no bias.
#include "framework/image/metrics.h"
#include "tests/image_checks.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::bias_over_seeds;
using testing::render;
using testing::RenderOptions;

RenderOptions options_for(double further_paths, std::uint32_t iterations) {
  return {.params = {{"photons", {std::int64_t{2000}, {}}}, {"further_paths", {further_paths, {}}}}, .iterations = iterations};
}

// Four lamps seen directly and in glossy plates.
TEST(DirectShares, TakeTheNoiseOfOutlines) {
  const Scene scene = load_scene("builtin:veach-mis");
  const Image reference = render(scene, "path", {.params = {}, .iterations = 1024}).image;
  for (const char* method : {"sppm", "photon-map"}) {
    const double without = bias_over_seeds(scene, method, options_for(0, 8), 3, reference).largest_relmse,
                 with = bias_over_seeds(scene, method, options_for(4, 8), 3, reference).largest_relmse;
    EXPECT_LT(with, 0.7 * without) << method;
  }
}

// Where they are shared out is decided before, so that no pixel is told from another by what its average holds.
TEST(DirectShares, AddNoBias) {
  const Scene scene = load_scene("builtin:veach-mis");
  const Image reference = render(scene, "path", {.params = {}, .iterations = 2048}).image;
  for (const char* sampler : {"sobol", "independent"}) {
    RenderOptions options = options_for(2, 2);
    options.params["sampler"] = {std::string(sampler), {}};
    const auto b = bias_over_seeds(scene, "sppm", options, 12, reference);
    EXPECT_LT(std::abs(b.mean), 0.001 + 4 * b.deviation) << sampler << " " << b.mean << " " << b.deviation;
  }
}

// Light that does not scatter takes no further path, and the image keeps its bits.
TEST(DirectShares, LeaveEvenLightAlone) {
  const Scene scene = load_scene("builtin:lambert-sphere");
  EXPECT_EQ(render(scene, "sppm", options_for(2, 3)).hash, render(scene, "sppm", options_for(0, 3)).hash);
}

}  // namespace
}  // namespace etendue
