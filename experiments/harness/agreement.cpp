#include "experiments/harness/agreement.h"

#include "experiments/harness/statistics.h"
#include "framework/core/check.h"

#include <fmt/format.h>
#include <cmath>
#include <limits>

namespace etendue {

namespace {

constexpr int grid = 8;
constexpr double false_alarm_rate = 1e-3;

std::vector<dvec3> region_means(const Image& image) {
  std::vector<dvec3> sums(1 + grid * grid, dvec3(0));
  std::vector<double> counts(sums.size(), 0);
  for (int y = 0; y < image.size.y; ++y)
    for (int x = 0; x < image.size.x; ++x) {
      const int block = 1 + (y * grid / image.size.y) * grid + x * grid / image.size.x;
      for (const int region : {0, block}) {
        sums[static_cast<std::size_t>(region)] += image.at(x, y);
        counts[static_cast<std::size_t>(region)] += 1;
      }
    }
  for (std::size_t i = 0; i < sums.size(); ++i)
    if (counts[i] > 0) sums[i] /= counts[i];  // an image of few pixels leaves blocks empty
  return sums;
}

struct Sample {
  double mean = 0, variance_of_mean = 0;
};

Sample sample_of(const BatchStatistics& statistics, std::size_t region, int channel) {
  const auto n = static_cast<double>(statistics.batches());
  Sample sample;
  for (const auto& batch : statistics.regions()) sample.mean += batch[region][channel] / n;
  for (const auto& batch : statistics.regions())
    sample.variance_of_mean += (batch[region][channel] - sample.mean) * (batch[region][channel] - sample.mean) / (n * (n - 1));
  return sample;
}

}  // namespace

BatchStatistics::BatchStatistics(ivec2 resolution) : sum_(resolution), sum_of_squares_(resolution) {}

void BatchStatistics::add(const Image& batch) {
  CHECK(batch.size == sum_.size);
  for (std::size_t i = 0; i < batch.pixels.size(); ++i) {
    sum_.pixels[i] += batch.pixels[i];
    sum_of_squares_.pixels[i] += batch.pixels[i] * batch.pixels[i];
  }
  regions_.push_back(region_means(batch));
  ++batches_;
}

Image BatchStatistics::mean() const {
  CHECK_GT(batches_, 0);
  Image image = sum_;
  for (dvec3& pixel : image.pixels) pixel /= batches_;
  return image;
}

double BatchStatistics::mean_variance() const {
  CHECK_GT(batches_, 1);
  const double n = batches_;
  double sum = 0;
  for (std::size_t i = 0; i < sum_.pixels.size(); ++i) {
    const dvec3 mean = sum_.pixels[i] / n;
    const dvec3 spread = glm::max(sum_of_squares_.pixels[i] / n - mean * mean, dvec3(0)) / (n - 1);
    sum += (spread.x + spread.y + spread.z) / 3;
  }
  return sum / static_cast<double>(sum_.pixels.size());
}

std::string BatchStatistics::region_name(std::size_t region) {
  if (region == 0) return "the image";
  const auto block = static_cast<int>(region) - 1;
  return fmt::format("block ({}, {}) of {} x {}", block % grid, block / grid, grid, grid);
}

Agreement compare_means(const BatchStatistics& a, const BatchStatistics& b, double indifference) {
  const std::size_t regions = 1 + grid * grid, tests = 3 * regions;
  const double level = sidak_level(false_alarm_rate, tests);
  double image_mean = 0;
  for (int c = 0; c < 3; ++c) image_mean += (sample_of(a, 0, c).mean + sample_of(b, 0, c).mean) / 6;
  const double margin = indifference * std::abs(image_mean);

  // The worst test is the one that comes nearest to (or farthest over) its own critical value.
  double worst_ratio = 0, worst_difference = 0;
  std::size_t worst_region = 0;
  for (std::size_t region = 0; region < regions; ++region)
    for (int c = 0; c < 3; ++c) {
      const Sample x = sample_of(a, region, c), y = sample_of(b, region, c);
      const double variance = x.variance_of_mean + y.variance_of_mean;
      const double excess = std::abs(x.mean - y.mean) - margin;
      if (excess <= 0) continue;
      double ratio = std::numeric_limits<double>::infinity();  // a difference without any variance
      if (variance > 0) {
        // Welch and Satterthwaite's degrees of freedom.
        const double degrees = variance * variance /
                               (x.variance_of_mean * x.variance_of_mean / (a.batches() - 1) +
                                y.variance_of_mean * y.variance_of_mean / (b.batches() - 1));
        ratio = excess / std::sqrt(variance) / student_t_quantile(1 - level / 2, degrees);
      }
      if (ratio <= worst_ratio) continue;
      worst_ratio = ratio;
      worst_difference = image_mean != 0 ? (x.mean - y.mean) / image_mean : x.mean - y.mean;
      worst_region = region;
    }
  Agreement result;
  result.agree = worst_ratio <= 1;
  result.text = fmt::format(
      "{} t-tests of means (3 channels, image and {} x {} blocks, {} and {} batches, false-alarm rate {:g}): {}", tests, grid,
      grid, a.batches(), b.batches(), false_alarm_rate,
      result.agree ? fmt::format("agree, worst t at {:.0f} % of its limit", 100 * worst_ratio)
                   : fmt::format("DISAGREE in {} by {:+.3g} % of the image's mean, t at {:.0f} % of its limit",
                                 BatchStatistics::region_name(worst_region), 100 * worst_difference, 100 * worst_ratio));
  return result;
}

}  // namespace etendue
