// Does an estimator's image agree with one that others made? From images of the same scene by independent seeds and a
// reference: the mean, blocks of it, relMSE with bias and noise apart, and a test of each pixel.
//
// The image's mean, the means of 8 x 8 blocks and each pixel's channel are held to the reference by t-tests over the seeds. All
// of them together have a false-alarm rate of 0.1 % by Sidak's correction ([Sidak1967]), of which the mean, the blocks and the
// pixels have a third each: few seeds leave each of many pixels uncertain, and yet tell the mean. The reference counts as
// exact: where its noise is not far below that of the seeds' mean, tests fail for it. Differences below a thousandth of the
// image's mean pass, as other programs' rounding makes them.
//
// A t-test believes the spread that it sees, and few samples may have missed what a pixel's filter or a light shows rarely.
// What none of N samples did has a probability below ln(1 / level) / N at that level ([Hanley1983]): by so much of the
// brightest value among a pixel and its eight neighbours the pixel may differ besides, and likewise the mean of M pixels, of
// which M N samples are, by the brightest value of a block.
#pragma once

#include "framework/image/film.h"

#include <string_view>

#include <cstdint>
#include <span>

namespace etendue {

inline constexpr int reference_blocks = 8;  // along either side of the image

struct AgainstReference {
  double ratio = 0, ratio_error = 0;  // of the images' mean to the reference's; its standard error
  double mean_allowed = 0;            // what that ratio may be off by, its error apart
  double mean_t = 0, mean_limit = 0;  // the means' difference beyond that, in standard errors; above mean_limit it fails
  dvec3 channel_ratio{0};             // of each channel's mean; 1 where both are black
  struct Block {
    ivec2 at{0};  // among the 8 x 8
    double ratio = 1, error = 0;
  } worst;                     // the block whose mean differs most, of those that hold a thousandth of the light at least
  double relmse_of_bias = 0;   // of the images' expectation: without what noise adds; may fall below 0 by its own noise
  double relmse_of_noise = 0;  // of one image: its variance
  std::size_t blocks = 0, blocks_failed = 0;  // all blocks, dark ones too
  double largest_block_t = 0, block_limit = 0;
  std::size_t tests = 0, failed = 0;  // pixels' channels
  double largest_t = 0, limit = 0;
  ivec2 largest_at{0};

  bool mean_agrees() const { return mean_t <= mean_limit; }
  bool agrees() const { return mean_agrees() && blocks_failed == 0 && failed == 0; }
};

// At least two images, all of the reference's size (CHECK).
// `samples`: per pixel, of all images together.
AgainstReference hold_against(std::span<const Image> images, const Image& reference, std::uint64_t samples);

// The mean of each `factor` x `factor` pixels, of an image whose sides are multiples of it (CHECK).
Image averaged(const Image& image, int factor);

// How `image` lies where the reference resembles it turned or mirrored at least twice as closely as it is: "mirrored left to
// right", "upside down", "turned by half"; empty where it lies as the reference does. By the means of 8 x 8 blocks, so that
// noise hardly counts. Symmetric images tell nothing.
std::string_view turned_against(const Image& image, const Image& reference);

}  // namespace etendue
