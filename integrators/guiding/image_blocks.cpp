#include "integrators/guiding/image_blocks.h"

#include "framework/image/metrics.h"

#include <array>
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
      group_pixels_(2 * static_cast<std::size_t>(squares_.x) * squares_.y, 0),
      second_moment_(static_cast<std::size_t>(resolution.x) * resolution.y, 0) {
  begin_block();
  for (std::size_t i = 0; i < second_moment_.size(); ++i) ++group_pixels_[group_of(i)];
}

void ImageBlocks::begin_block() {
  blocks_.push_back({Image(size_), {}, 0});
  if (is_signed_) blocks_.back().weights.resize(second_moment_.size(), 0);
}

std::uint32_t ImageBlocks::block_of(std::uint32_t index) {
  return static_cast<std::uint32_t>(std::bit_width(std::uint64_t{index} + 2)) - 2;
}

bool ImageBlocks::begins_block(std::uint32_t index) { return std::has_single_bit(std::uint64_t{index} + 2); }

std::size_t ImageBlocks::group_of(std::size_t pixel) const {
  const ivec2 at(pixel % static_cast<std::size_t>(size_.x), pixel / static_cast<std::size_t>(size_.x));
  return 2 * pixel_index(at / square_edge, squares_) + colour_of(at);
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
  running.variance.assign(group_pixels_.size(), 0);
  for (std::size_t i = 0; i < second_moment_.size(); ++i) {
    const double sum = luminance(running.sum.pixels[i]);
    const std::size_t group = group_of(i);
    running.variance[group] +=
        std::max(0.0, second_moment_[i] - sum * sum / running.samples) / ((running.samples - 1) * group_pixels_[group]);
  }
}

std::vector<double> ImageBlocks::group_sums() const {
  std::vector<double> sums(group_pixels_.size(), 0);
  for (const Block& block : blocks_)
    for (std::size_t i = 0; i < second_moment_.size(); ++i) sums[group_of(i)] += luminance(block.sum.pixels[i]);
  return sums;
}

std::vector<double> ImageBlocks::weights(std::size_t colour, const std::vector<double>& group_sums) const {
  std::vector<double> out(blocks_.size(), 1);
  if (combination_ == BlockCombination::mean || is_signed_) return out;  // a few samples may weigh nothing, by their signs
  if (combination_ == BlockCombination::last) {
    std::fill(out.begin(), out.end() - 1, 0.0);
    return out;
  }
  std::vector<double> mean = group_sums;
  double samples = 0, level = 0, pixels = 0;
  for (const Block& block : blocks_) samples += block.samples;
  for (std::size_t g = 1 - colour; g < mean.size(); g += 2) {
    level += mean[g] / samples;
    pixels += group_pixels_[g];
    mean[g] /= samples * std::max(group_pixels_[g], 1.0);
  }
  level /= std::max(pixels, 1.0);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    double variance = 0;
    for (std::size_t g = 1 - colour; g < blocks_[b].variance.size(); g += 2)
      variance += group_pixels_[g] * blocks_[b].variance[g] / (mean[g] * mean[g] + relmse_epsilon * level * level + tiny);
    if (!blocks_[b].variance.empty()) out[b] = 1 / std::max(variance, 1e-12 * std::max(pixels, 1.0));
    if (b > 0) out[b] = blocks_[b].variance.empty() ? out[b - 1] : std::max(out[b], out[b - 1]);
  }
  return out;
}

void ImageBlocks::end_sample(std::uint32_t index, Film& film) {
  blocks_.back().samples += 1;
  if (blocks_.back().samples > 1) measure_running();
  const std::vector<double> sums = group_sums();
  const std::array<std::vector<double>, 2> weights_of{weights(0, sums), weights(1, sums)};
  for (int y = 0; y < size_.y; ++y)
    for (int x = 0; x < size_.x; ++x) {
      const std::vector<double>& weight = weights_of[colour_of({x, y})];
      dvec3 sum(0);
      double all = 0;
      for (std::size_t b = 0; b < blocks_.size(); ++b) {
        sum += weight[b] * blocks_[b].sum.at(x, y);
        all += weight[b] * (is_signed_ ? blocks_[b].weights[pixel_index({x, y}, size_)] : blocks_[b].samples);
      }
      film.set({x, y}, all != 0 ? sum / all : dvec3(0));
    }
  if (!begins_block(index + 1)) return;
  begin_block();
  std::fill(second_moment_.begin(), second_moment_.end(), 0.0);
}

}  // namespace etendue
