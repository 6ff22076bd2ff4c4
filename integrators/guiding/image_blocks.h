// One image from blocks of samples of different variance, for methods whose sampling improves as they learn.
//
// Block b holds 2, 4, 8, ... samples of each pixel. Blocks are added with weights inverse to the variance of one sample of
// theirs ([Mueller2019], section 10.5.1: not one per pixel). There are three deviations. The variance is relative, that of a
// square of 8 x 8 pixels over its squared mean in all samples so far (plus a hundredth of the image's); else the brightest
// pixels would decide. And pixels are divided as a chessboard's fields, of which each colour has weights from the samples of
// the other: weights from a pixel's own samples would count a block less that met light by a rare chance, and the image would
// lack such light. What is left of this comes by way of the tree, which all pixels teach; `mean` and `last` have none of it.
// Nor does a sample weigh less than one before it: few samples that met no such light tell nothing of their variance. A running
// block of one sample takes the weight of the block before. In an image of one pixel, which has no other colour, all count
// alike.
#pragma once

#include "framework/image/film.h"

namespace etendue {

// inverse_variance; mean: all samples count the same; last: only the newest block.
enum class BlockCombination : std::uint8_t { inverse_variance, mean, last };
constexpr auto names_of(BlockCombination) { return std::array{"inverse-variance", "mean", "last"}; }

class ImageBlocks {
 public:
  // `is_signed`: samples have weights (pixel_filter.h), and all blocks count alike.
  ImageBlocks(ivec2 resolution, BlockCombination combination, bool is_signed = false);

  // Block that a sample belongs to, whether it is its first, and how many it has.
  static std::uint32_t block_of(std::uint32_t index);
  static bool begins_block(std::uint32_t index);
  static std::uint32_t block_samples(std::uint32_t block) { return 2u << block; }

  // A sample of a pixel, in the running block. A pixel belongs to one thread at a time. What is not finite counts as 0.
  void add(ivec2 pixel, const Rgb& value, float weight = 1);
  // After a sample of every pixel: the image so far.
  void end_sample(std::uint32_t index, Film& film);

 private:
  struct Block {
    Image sum;
    std::vector<double> variance;  // of one sample's luminance, mean over each group; empty where not known
    double samples = 0;
    std::vector<double> weights = {};  // of each pixel's samples, their sum; empty where that is `samples`
  };

  void begin_block();
  void measure_running();
  // The sums of what each group's pixels found in all samples, in luminance.
  std::vector<double> group_sums() const;
  // They weigh the blocks' samples for the pixels of a colour, from those of the other.
  std::vector<double> weights(std::size_t colour, const std::vector<double>& group_sums) const;
  static std::size_t colour_of(ivec2 pixel) { return static_cast<std::size_t>(pixel.x + pixel.y) % 2; }
  std::size_t group_of(std::size_t pixel) const;  // the pixels of a square and a colour: twice the square's number, plus that

  BlockCombination combination_;
  bool is_signed_;
  ivec2 size_, squares_;
  std::vector<double> group_pixels_;   // how many pixels a group has
  std::vector<Block> blocks_;          // the last one is running
  std::vector<double> second_moment_;  // of luminance, sums over the running block, per pixel
};

}  // namespace etendue
