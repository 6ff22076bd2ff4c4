#include "integrators/guiding/image_blocks.h"

#include "framework/image/metrics.h"

#include <bit>

namespace etendue {

namespace {

constexpr int square_edge = 8;
constexpr double tiny = 1e-30;

double luminance(const dvec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

}  // namespace

ImageBlocks::ImageBlocks(ivec2 resolution, BlockCombination combination, bool is_signed)
    : combination_(combination),
      is_signed_(is_signed),
      size_(resolution),
      squares_((resolution + square_edge - 1) / square_edge),
      square_pixels_(static_cast<std::size_t>(squares_.x) * squares_.y, 0),
      second_moment_(static_cast<std::size_t>(resolution.x) * resolution.y, 0) {
  begin_block();
  for (std::size_t i = 0; i < second_moment_.size(); ++i) ++square_pixels_[square_of(i)];
}

void ImageBlocks::begin_block() {
  blocks_.push_back({Image(size_), {}, 0});
  if (is_signed_) blocks_.back().weights.resize(second_moment_.size(), 0);
}

std::uint32_t ImageBlocks::block_of(std::uint32_t index) {
  return static_cast<std::uint32_t>(std::bit_width(std::uint64_t{index} + 2)) - 2;
}

bool ImageBlocks::begins_block(std::uint32_t index) { return std::has_single_bit(std::uint64_t{index} + 2); }

std::size_t ImageBlocks::square_of(std::size_t pixel) const {
  const auto width = static_cast<std::size_t>(size_.x);
  return pixel / width / square_edge * static_cast<std::size_t>(squares_.x) + pixel % width / square_edge;
}

void ImageBlocks::add(ivec2 pixel, const Rgb& value, float weight) {
  const std::size_t i = pixel_index(pixel, size_);
  if (is_signed_) blocks_.back().weights[i] += weight;
  if (!is_finite(value)) return;
  blocks_.back().sum.pixels[i] += static_cast<double>(weight) * dvec3(value);
  const double y = luminance(dvec3(value));
  second_moment_[i] += y * y;
}

void ImageBlocks::measure_running() {
  Block& running = blocks_.back();
  running.variance.assign(square_pixels_.size(), 0);
  for (std::size_t i = 0; i < second_moment_.size(); ++i) {
    const double sum = luminance(running.sum.pixels[i]);
    const std::size_t square = square_of(i);
    running.variance[square] +=
        std::max(0.0, second_moment_[i] - sum * sum / running.samples) / ((running.samples - 1) * square_pixels_[square]);
  }
}

std::vector<double> ImageBlocks::weights() const {
  std::vector<double> out(blocks_.size(), 1);
  if (combination_ == BlockCombination::mean) return out;
  if (combination_ == BlockCombination::last) {
    std::fill(out.begin(), out.end() - 1, 0.0);
    return out;
  }
  std::vector<double> mean(square_pixels_.size(), 0);
  double samples = 0, level = 0;
  for (const Block& block : blocks_) {
    samples += block.samples;
    for (std::size_t i = 0; i < second_moment_.size(); ++i) mean[square_of(i)] += luminance(block.sum.pixels[i]);
  }
  for (std::size_t s = 0; s < mean.size(); ++s) {
    level += mean[s] / (samples * static_cast<double>(second_moment_.size()));
    mean[s] /= samples * square_pixels_[s];
  }
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    double variance = 0;
    for (std::size_t s = 0; s < blocks_[b].variance.size(); ++s)
      variance += square_pixels_[s] * blocks_[b].variance[s] / (mean[s] * mean[s] + relmse_epsilon * level * level + tiny);
    if (blocks_[b].variance.empty())
      out[b] = b > 0 ? out[b - 1] : 1;
    else
      out[b] = 1 / std::max(variance, 1e-12 * static_cast<double>(second_moment_.size()));
  }
  return out;
}

void ImageBlocks::end_sample(std::uint32_t index, Film& film) {
  blocks_.back().samples += 1;
  if (blocks_.back().samples > 1) measure_running();
  const std::vector<double> weight = weights();
  double all = 0;
  for (std::size_t b = 0; b < blocks_.size(); ++b) all += weight[b] * blocks_[b].samples;
  for (int y = 0; y < size_.y; ++y)
    for (int x = 0; x < size_.x; ++x) {
      dvec3 sum(0);
      for (std::size_t b = 0; b < blocks_.size(); ++b) sum += weight[b] * blocks_[b].sum.at(x, y);
      if (is_signed_) {
        all = 0;
        for (std::size_t b = 0; b < blocks_.size(); ++b) all += weight[b] * blocks_[b].weights[pixel_index({x, y}, size_)];
      }
      film.set({x, y}, all != 0 ? sum / all : dvec3(0));
    }
  if (!begins_block(index + 1)) return;
  begin_block();
  std::fill(second_moment_.begin(), second_moment_.end(), 0.0);
}

}  // namespace etendue
