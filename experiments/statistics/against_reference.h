// Does an estimator's image agree with one that others made? From images of the same scene by independent seeds and a
// reference: the mean, blocks of it, relMSE with bias and noise apart, and a test of each pixel.
//
// Each pixel's channel is held to the reference by a t-test over the seeds, all of them together to a false-alarm rate of 0.1 %
// by Sidak's correction ([Sidak1967]). The reference counts as exact: where its noise is not far below that of the seeds' mean,
// pixels fail for it. Differences below `indifference` of the image's mean pass, as other programs' rounding makes them.
//
// A t-test believes the spread that it sees, and few samples may have missed what a pixel's filter or a light shows rarely.
// What none of N samples did has a probability below ln(1 / level) / N at that level ([Hanley1983]): by so much of the
// brightest value among a pixel and its eight neighbours the pixel may differ besides.
#pragma once

#include "framework/image/film.h"

#include <cstdint>
#include <span>

namespace etendue {

inline constexpr int reference_blocks = 8;  // along either side of the image

struct AgainstReference {
  double ratio = 0, ratio_error = 0;  // of the images' mean to the reference's; its standard error
  struct Block {
    ivec2 at{0};  // among the 8 x 8
    double ratio = 0, error = 0;
  } worst;                     // the block whose mean differs most, of those that hold a thousandth of the light at least
  double relmse_of_bias = 0;   // of the images' expectation: without what noise adds; may fall below 0 by its own noise
  double relmse_of_noise = 0;  // of one image: its variance
  std::size_t tests = 0, failed = 0;  // pixels' channels
  double largest_t = 0, limit = 0;
  ivec2 largest_at{0};

  bool agrees() const { return failed == 0; }
};

// At least two images, all of the reference's size (CHECK).
// `samples`: per pixel, of all images together.
AgainstReference hold_against(std::span<const Image> images, const Image& reference, std::uint64_t samples,
                              double indifference = 1e-3);

}  // namespace etendue
