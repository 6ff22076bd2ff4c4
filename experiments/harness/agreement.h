// Do two unbiased estimators have the same mean? The test that a rendered reference must pass before anything is judged by it.
//
// Each estimator is run in independent batches. Per channel, the mean of the image and of the 64 blocks of an 8 x 8 grid are
// compared by Welch's t-test ([Welch1947]), held together to a false-alarm rate of 0.1 % by Sidak's correction ([Sidak1967]).
// Differences within `indifference` of the image's mean pass: depth limits and single precision differ by 0.05 %.
#pragma once

#include "framework/image/film.h"

#include <string>
#include <vector>

namespace etendue {

inline constexpr int reference_batches = 16;

// Mean and variance of an estimator's image from its batches.
class BatchStatistics {
 public:
  explicit BatchStatistics(ivec2 resolution);

  void add(const Image& batch);
  int batches() const { return batches_; }
  Image mean() const;
  double mean_variance() const;  // variance of mean(), averaged over pixels and channels

  // The image's mean and its blocks' means, batch by batch: [batch][region], region 0 being the whole image.
  const std::vector<std::vector<dvec3>>& regions() const { return regions_; }
  static std::string region_name(std::size_t region);

 private:
  int batches_ = 0;
  Image sum_, sum_of_squares_;
  std::vector<std::vector<dvec3>> regions_;
};

struct Agreement {
  bool agree = true;
  std::string text;  // what was compared and how it came out
};

Agreement compare_means(const BatchStatistics& a, const BatchStatistics& b, double indifference = 5e-4);

}  // namespace etendue
