// Do two unbiased estimators have the same mean? The test that a rendered reference must pass before anything is judged by it.
//
// Each estimator is run in independent batches. Per channel, the mean of the image and of the 64 blocks of an 8 x 8 grid are
// compared by Welch's t-test ([Welch1947]), held together to a false-alarm rate of 0.1 % by Sidak's correction ([Sidak1967]).
// Differences within `indifference` of the image's mean pass: depth limits and single precision differ by 0.05 %.
//
// A t-test believes the spread that it sees, and a pixel of few samples may not have seen the rare bright paths that carry part
// of its mean: no test of means is valid for all distributions ([Bahadur1956]). What makes this one valid at any size is a
// bound on the light that one path carries. If no path of N did something, its probability is below ln(1 / level) / N at that
// level ([Hanley1983]), so paths not yet seen can add at most `brightest` ln(1 / level) / N to the mean. A difference convicts
// only where it exceeds the t-test's limit by more than that allowance of the darker estimator. Between the two the data cannot
// tell, and the verdict says how many samples could. The bound is the brightest light's radiance (paths are MIS-weighted with
// each other so that none brings much more), or twice what the skewness of the noise says of the rare samples in it, if that is
// larger: delta lights have no radiance.
//
// Two estimators that have both missed the same light agree. Where what they may have missed is as much as the image's mean, or
// more, the verdict is that the data cannot tell: a lamp seen by way of glass alone leaves both of them black.
#pragma once

#include "framework/image/film.h"

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

inline constexpr int reference_batches = 16;

// Mean and variance of an estimator's image from its batches.
class BatchStatistics {
 public:
  explicit BatchStatistics(ivec2 resolution, std::uint64_t samples_per_batch = 1);  // samples: per pixel

  void add(const Image& batch);
  int batches() const { return batches_; }
  std::uint64_t samples() const { return samples_per_batch_ * static_cast<std::uint64_t>(batches_); }  // per pixel
  const Image& mean() const { return mean_; }
  double mean_variance() const;  // variance of mean(), averaged over pixels and channels
  // The same of variance over r^2 + relmse_epsilon: how much of a relMSE against r is the noise of mean(), which r holds.
  double relative_variance(const Image& r) const;
  // The value of the rare, bright events that the noise consists of: the third over the second cumulant of a pixel's sample, at
  // three standard errors above. For events in a Poisson process that is their value, or E[v^3] / E[v^2] if it varies.
  double rare_value() const;

  // The image's mean and its blocks' means, batch by batch: [batch][region], region 0 being the whole image.
  const std::vector<std::vector<dvec3>>& regions() const { return regions_; }
  const std::vector<std::uint64_t>& pixels() const { return pixels_; }  // of each region: 0 in blocks of a tiny image
  static std::string region_name(std::size_t region);

 private:
  template <class Scale>
  double variance_over(const Scale& scale) const;  // of mean(), each pixel's over scale(pixel)

  std::uint64_t samples_per_batch_;
  int batches_ = 0;
  Image mean_, squares_, cubes_;  // the last two: sums of the powers of deviations from the mean
  std::vector<std::uint64_t> pixels_;
  std::vector<std::vector<dvec3>> regions_;
};

struct AgreementOptions {
  double indifference = 5e-4;      // of the image's mean
  double brightest = 0;            // radiance that a sample may carry although none did yet, at least
  double false_alarm_rate = 1e-3;  // of `disagree`, over all tests together
};

struct Agreement {
  enum class Verdict : std::uint8_t { agree, cannot_tell, disagree } verdict = Verdict::agree;
  std::string text;              // what was compared and how it came out
  double times_the_samples = 1;  // so many more let one tell: only where this verdict cannot; infinity: nobody knows how many
  bool first_lacks = false;      // in some region it is the darker one by more than chance
  double may_lack = 0;  // radiance, on the image's mean, that both may have missed: not told apart from what they found
};

// Rounds so many times the samples up to a power of two.
inline std::uint64_t samples_needed(double samples, double times) {
  return std::bit_ceil(static_cast<std::uint64_t>(samples * times) + 1);
}

Agreement compare_means(const BatchStatistics& a, const BatchStatistics& b, const AgreementOptions& options = {});

// These words stand in the text of a verdict `cannot_tell`, and in no other; logs keep the text alone.
inline constexpr std::string_view undecided = "CANNOT TELL";

}  // namespace etendue
