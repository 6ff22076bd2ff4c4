// Integrators that share nothing but scene, BSDFs and light sampling must make the same image: block means against the path
// tracer's, by t-tests over independent seeds, Sidak-corrected to one false alarm in a thousand runs of the file. Biased
// methods are allowed the bias stated beside them.
#include "experiments/harness/statistics.h"
#include "tests/render_scene.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::render;
using testing::RenderOptions;

constexpr ivec2 resolution{24, 24};
constexpr int seeds = 6;

struct Method {
  const char* name;
  ParamMap params;
  std::uint32_t iterations;
  double allowed;  // bias of a block, relative to it
};

ParamMap params_of(std::initializer_list<std::pair<const char*, const char*>> list) {
  ParamMap params;
  for (const auto& [key, value] : list) params[key] = parse_param_value(value, {});
  return params;
}

using BlockMeans = std::vector<dvec3>;

BlockMeans block_means(const Image& image, int block) {
  const int across = resolution.x / block;
  BlockMeans means(static_cast<std::size_t>(across) * across, dvec3(0));
  for (int y = 0; y < image.size.y; ++y)
    for (int x = 0; x < image.size.x; ++x)
      means[static_cast<std::size_t>(y / block * across + x / block)] += image.at(x, y) / double(block * block);
  return means;
}

std::vector<BlockMeans> replicates(const Scene& scene, const Method& method, int block, std::uint64_t first_seed) {
  std::vector<BlockMeans> out;
  for (std::uint64_t seed = first_seed; seed < first_seed + seeds; ++seed) {
    RenderOptions options;
    options.params = method.params;
    options.iterations = method.iterations;
    options.seed = seed;
    options.resolution = resolution;
    const auto rendered = render(scene, method.name, options);
    EXPECT_EQ(rendered.non_finite, 0u) << method.name;
    EXPECT_LE(method.allowed > 0 ? 0.0 : rendered.expectation.bias_bound, 0.0) << method.name;
    out.push_back(block_means(rendered.image, block));
  }
  return out;
}

void expect_agreement(const char* scene_name, int block, const Method& reference, const std::vector<Method>& methods) {
  const Scene scene = load_scene(scene_name);
  const auto truth = replicates(scene, reference, block, 1000);
  const double level = sidak_level(1e-3, methods.size() * truth[0].size() * 3 * 3);
  const double limit = student_t_quantile(1 - level / 2, 2 * (seeds - 1));
  for (const Method& method : methods) {
    const auto images = replicates(scene, method, block, 1);
    for (std::size_t b = 0; b < truth[0].size(); ++b)
      for (int c = 0; c < 3; ++c) {
        std::vector<double> x, r;
        for (int s = 0; s < seeds; ++s) {
          x.push_back(images[static_cast<std::size_t>(s)][b][c]);
          r.push_back(truth[static_cast<std::size_t>(s)][b][c]);
        }
        const double difference = mean(x) - mean(r);
        const double error = std::hypot(sample_sd(x), sample_sd(r)) / std::sqrt(double(seeds));
        const double excess = std::max(0.0, std::abs(difference) - method.allowed * mean(r));
        EXPECT_LE(excess, limit * error + 1e-6 * mean(r)) << scene_name << " " << method.name << " block " << b << " channel "
                                                          << c << ": " << mean(x) << " against " << mean(r);
      }
  }
}

TEST(IntegratorAgreement, CornellBox) {
  expect_agreement("builtin:cornell-box", 6, {"path", {}, 128, 0},
                   {{"light-trace", {}, 128, 0},
                    {"photon-map", params_of({{"photons", "20000"}, {"final_gather", "4"}, {"retrace", "true"}}), 4, 0.03},
                    {"photon-map", params_of({{"photons", "20000"}, {"retrace", "true"}}), 4, 0.06},
                    {"sppm", {}, 16, 0.04},
                    {"ppm-memoryless", {}, 16, 0.04},
                    {"appm", {}, 16, 0.04},
                    {"cppm", {}, 16, 0.04},
                    {"irradiance-cache", params_of({{"samples", "256"}}), 32, 0.03}});
}

TEST(IntegratorAgreement, CornellBoxCutAtTwoEvents) {
  const auto cut = [](std::initializer_list<std::pair<const char*, const char*>> list) {
    ParamMap params = params_of(list);
    params["max_depth"] = {std::int64_t{2}, {}};
    return params;
  };
  expect_agreement("builtin:cornell-box", 6, {"path", cut({}), 128, 0},
                   {{"light-trace", cut({}), 128, 0},
                    {"photon-map", cut({{"photons", "20000"}, {"final_gather", "4"}, {"retrace", "true"}}), 4, 0.03},
                    {"irradiance-cache", cut({{"samples", "256"}}), 32, 0.03}});
}

// Mirror and glass: light tracing cannot see into them, so it sits out.
TEST(IntegratorAgreement, CornellSpheres) {
  expect_agreement(
      "builtin:cornell-spheres", 12, {"path", {}, 128, 0},
      {{"photon-map",
        params_of({{"photons", "20000"}, {"caustic_photons", "20000"}, {"final_gather", "4"}, {"retrace", "true"}}), 4, 0.05},
       {"sppm", {}, 16, 0.05},
       {"irradiance-cache", params_of({{"samples", "256"}}), 64, 0.05}});
}

}  // namespace
}  // namespace etendue
