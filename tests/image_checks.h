// Measurements that tests of every integrator make alike: bias against a closed form, truncation by the depth limit, the same
// bits at any number of threads.
#pragma once

#include "tests/render_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace etendue::testing {

// Relative bias of the image's mean over independent seeds.
struct BiasEstimate {
  double mean = 0, deviation = 0;  // over the seeds; standard error of that mean
  double bound = 0;                // what the method declares
  double largest_relmse = 0;       // of the seeds
};

// Renders with the seeds 1 to `seeds`; fails where a sample is not finite.
inline BiasEstimate bias_over_seeds(const Scene& scene, const std::string& integrator, RenderOptions options, int seeds,
                                    const Image& exact) {
  BiasEstimate estimate;
  double sum = 0, squares = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    options.seed = static_cast<std::uint64_t>(seed);
    const auto rendered = render(scene, integrator, options);
    EXPECT_EQ(rendered.non_finite, 0u) << scene.name << " " << integrator;
    const double b = bias(rendered.image, exact);
    sum += b;
    squares += b * b;
    estimate.bound = rendered.expectation.bias_bound;
    estimate.largest_relmse = std::max(estimate.largest_relmse, relmse(rendered.image, exact));
  }
  estimate.mean = sum / seeds;
  estimate.deviation = std::sqrt(std::max(0.0, squares / seeds - estimate.mean * estimate.mean) / (seeds - 1));
  return estimate;
}

inline BiasEstimate bias_over_seeds(const Scene& scene, const std::string& integrator, const RenderOptions& options,
                                    int seeds) {
  return bias_over_seeds(scene, integrator, options, seeds, exact_image(scene, options.resolution));
}

// In builtin:lambert-sphere (albedo 1/2), light of at most d scattering events has radiance (1 - 2^-d) / pi.
inline void expect_truncated_series(const std::string& integrator, RenderOptions options, double tolerance, int deepest = 3) {
  const Scene scene = load_scene("builtin:lambert-sphere");
  for (int depth = 1; depth <= deepest; ++depth) {
    options.params["max_depth"] = {std::int64_t{depth}, {}};
    const Image image = render(scene, integrator, options).image;
    double mean = 0;
    for (const dvec3& p : image.pixels) mean += p.x / static_cast<double>(image.pixels.size());
    EXPECT_NEAR(mean * std::numbers::pi / (1 - std::pow(0.5, depth)), 1, tolerance) << integrator << ", depth " << depth;
  }
}

inline void expect_same_bits_at_any_thread_count(const Scene& scene, const std::string& integrator, RenderOptions options) {
  options.threads = 1;
  const std::uint64_t one = render(scene, integrator, options).hash;
  for (options.threads = 2; options.threads <= 3; ++options.threads)
    EXPECT_EQ(render(scene, integrator, options).hash, one)
        << scene.name << ", " << integrator << ", " << options.threads << " threads";
}

}  // namespace etendue::testing
