// The numbers of camera samples that pixels take in an iteration: more where earlier ones scattered.
//
// Where a cache gives smooth light, the remaining noise is at outlines and in penumbrae. Each pixel takes one sample per
// iteration. At first, and as long as sharing them out would leave most of the variance, each pixel takes as many further
// samples as any other. Where samples hardly differ within pixels, none are taken, however much neighbours differ; where that
// is known beforehand, as of an even sky, not even at first, since points of one sequence even each other out best. Nor are
// any taken where iterations differ most by what all samples of one have in common, photons or records that are new in each:
// their noise is alike in neighbouring pixels, and camera samples do not lower it. Else further samples are shared out in
// proportion to the relative standard deviation sigma, because for a given total the sum of sigma_i^2 / n_i is least for n_i ~
// sigma_i. Sigma is estimated from the samples so far of the pixel and its eight neighbours, since an outline that just enters
// a pixel is often seen first beside it.
//
// The iteration's value of a pixel is the mean of its samples there, and iterations weigh the same: given those before, each
// has the right expectation, so that choosing numbers by what was found adds no bias ([Kirk1991] shows that else it does).
// That holds for independent samples. The points of a low-discrepancy sequence make up for those before them: a pixel on a
// lamp's outline that was found dark takes many samples of small weight, which will find the lamp, and one that was found
// bright goes on with few. So numbers change after 1, 2, 4, 8, ... iterations only, and each span between changes draws from a
// part of the sequence whose shuffle is independent of the parts before it (framework/core/sampler.h): points even each other
// out within a span, and owe nothing to another. Without spans the direct light of a Cornell box of 16 x 16 pixels was 1 % too
// dark after 32 iterations. They cost irradiance-cache 5 to 9 % of relMSE there at 64 x 64 pixels (two seeds).
#pragma once

#include "framework/core/parallel.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace etendue {

class SampleShares {
 public:
  // `extra`: samples beyond one per pixel, at most on the mean over an iteration's pixels, each of which takes whole ones; 0:
  // none. `measures`: noise() is wanted without extra samples too. `first`: number of the first sample of each pixel in each
  // span, in units of the most that an iteration takes; at most `most_first`.
  explicit SampleShares(ivec2 resolution = ivec2(0), float extra = 0, std::uint32_t first = 0, bool measures = false);

  static constexpr std::uint32_t most = 32;  // samples of a pixel in an iteration
  static constexpr double smooth = 0.04;     // relative deviation of samples below which one is enough
  static constexpr double common = 0.8;      // what iterations share of the variance over what samples add, likewise
  static constexpr std::uint32_t most_first = 1u << 20;  // which leaves a span's numbers for as many iterations

  // Before the first iteration: one sample of each pixel is enough for it, as far as can be told.
  void begin_with_one();

  // Before the first iteration: photons are new in each of them.
  void expect_common_noise() { expects_common_ = true; }

  // The numbers of a pixel's samples in the iteration under way are [begin, begin + count).
  struct Range {
    std::uint32_t begin, count;
  };
  Range range(std::size_t pixel) const { return {next_[pixel], count_[pixel]}; }
  // A sample's luminance; non-finite ones are left out. A pixel belongs to one thread at a time.
  void add(std::size_t pixel, float luminance);
  // Deviations of dark pixels are relative to the image's mean luminance: as given here, else as found.
  void know_mean(double luminance) { known_mean_ = luminance; }
  // Closes an iteration; where it was the last of a span, shares the samples of the next one's iterations out.
  void end_iteration();

  // The variance of the mean of the iterations so far, relative to each pixel's mean and so averaged over them; as if samples
  // were independent, and all iterations had the numbers of the last.
  double noise() const { return variance_ / std::max(iterations_, 1u); }
  // The square of an error of a pixel's luminance over that of the pixel, likewise.
  float relative_square(std::size_t pixel, float error) const;
  // Relative standard deviation of a pixel's samples and its neighbours', as the last span was chosen by.
  float deviation(std::size_t pixel) const { return deviation_[pixel]; }
  std::uint64_t samples() const { return samples_; }  // so far, of all pixels

 private:
  struct Moments {
    double count = 0, sum = 0, squares = 0;
  };
  struct Mean {
    float count = 0, mean = 0;
  };

  void measure();
  void choose_numbers();
  void remember();
  double common_over_own() const;
  std::uint32_t wanted_of_each() const;
  void share_out();
  double sample_variance(std::size_t pixel) const;
  double iteration_variance() const;

  ivec2 resolution_;
  float extra_;
  std::uint32_t first_, iterations_ = 0, span_ = 0;
  bool expects_common_ = false;
  std::uint32_t even_ = 1;  // samples of each pixel; 0: shared out
  std::optional<double> known_mean_;
  std::vector<Moments> moments_;
  std::vector<Mean> before_;  // of the first half of the iterations
  std::vector<std::uint32_t> next_, count_;
  std::vector<float> deviation_;  // relative
  double floor_ = 0;              // of the squares of means by which variances are divided
  double variance_ = 0;           // relative, of an iteration
  std::uint64_t samples_ = 0;
};

}  // namespace etendue
