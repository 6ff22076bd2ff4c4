// Do integrators make the same image? Block means against a reference method's, by t-tests over independent seeds,
// Sidak-corrected to one false alarm in a thousand runs of a file. Biased methods are allowed the bias stated beside them.
#pragma once

#include "experiments/statistics/statistics.h"
#include "tests/render_scene.h"

#include <gtest/gtest.h>

namespace etendue::testing {

inline constexpr int agreement_seeds = 6;

struct AgreementMethod {
  const char* name;
  ParamMap params;
  std::uint32_t iterations;
  double allowed;  // bias of a block, relative to it
};

inline ParamMap params_of(std::initializer_list<std::pair<const char*, const char*>> list) {
  ParamMap params;
  for (const auto& [key, value] : list) params[key] = parse_param_value(value, {});
  return params;
}

// Says where the test looks: square blocks of a square image, and of how many comparisons of this size its file consists.
struct AgreementSettings {
  ivec2 resolution{24, 24};
  int block = 6;
  int comparisons = 3;
};

using BlockMeans = std::vector<dvec3>;

inline BlockMeans block_means(const Image& image, int block) {
  const int across = image.size.x / block;
  BlockMeans means(static_cast<std::size_t>(across) * across, dvec3(0));
  for (int y = 0; y < image.size.y; ++y)
    for (int x = 0; x < image.size.x; ++x)
      means[static_cast<std::size_t>(y / block * across + x / block)] += image.at(x, y) / double(block * block);
  return means;
}

inline std::vector<BlockMeans> replicates(const Scene& scene, const AgreementMethod& method, const AgreementSettings& settings,
                                          std::uint64_t first_seed) {
  std::vector<BlockMeans> out;
  for (std::uint64_t seed = first_seed; seed < first_seed + agreement_seeds; ++seed) {
    RenderOptions options;
    options.params = method.params;
    options.iterations = method.iterations;
    options.seed = seed;
    options.resolution = settings.resolution;
    const auto rendered = render(scene, method.name, options);
    EXPECT_EQ(rendered.non_finite, 0u) << method.name;
    EXPECT_LE(method.allowed > 0 ? 0.0 : rendered.expectation.bias_bound, 0.0) << method.name;
    out.push_back(block_means(rendered.image, settings.block));
  }
  return out;
}

inline void expect_agreement(const Scene& scene, const AgreementSettings& settings, const AgreementMethod& reference,
                             const std::vector<AgreementMethod>& methods) {
  const auto expected = replicates(scene, reference, settings, 1000);
  const double level =
      sidak_level(1e-3, methods.size() * expected[0].size() * 3 * static_cast<std::size_t>(settings.comparisons));
  const double limit = student_t_quantile(1 - level / 2, 2 * (agreement_seeds - 1));
  double image_mean = 0, image_error = 0;
  for (const AgreementMethod& method : methods) {
    const auto images = replicates(scene, method, settings, 1);
    for (std::size_t b = 0; b < expected[0].size(); ++b)
      for (int c = 0; c < 3; ++c) {
        std::vector<double> x, r;
        for (int s = 0; s < agreement_seeds; ++s) {
          x.push_back(images[static_cast<std::size_t>(s)][b][c]);
          r.push_back(expected[static_cast<std::size_t>(s)][b][c]);
        }
        const double difference = mean(x) - mean(r);
        const double error = std::hypot(sample_sd(x), sample_sd(r)) / std::sqrt(double(agreement_seeds));
        const double excess = std::max(0.0, std::abs(difference) - method.allowed * mean(r));
        EXPECT_LE(excess, limit * error + 1e-6 * mean(r)) << scene.name << " " << method.name << " block " << b << " channel "
                                                          << c << ": " << mean(x) << " against " << mean(r);
        image_mean += mean(r);
        image_error += error * error;
      }
    // How small a bias of the whole image the test would see, for whoever tunes it.
    ::testing::Test::RecordProperty(std::string("four_sigma_") + method.name,
                                    std::to_string(4 * std::sqrt(image_error) / image_mean));
  }
}

}  // namespace etendue::testing
