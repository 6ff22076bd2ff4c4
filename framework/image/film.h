// The image an integrator adds to: the mean of each pixel's samples, sums in double precision. Which samples belong to a pixel,
// and what they count, is the pixel filter's (framework/scene/pixel_filter.h).
#pragma once

#include "framework/core/vec.h"

#include <cstdint>
#include <mutex>
#include <vector>

namespace etendue {

// A linear RGB image in double precision, row 0 at the top.
struct Image {
  ivec2 size{0};
  std::vector<dvec3> pixels;

  Image() = default;
  explicit Image(ivec2 s) : size(s), pixels(static_cast<std::size_t>(s.x) * s.y, dvec3(0)) {}
  dvec3& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * size.x + x]; }
  const dvec3& at(int x, int y) const { return pixels[static_cast<std::size_t>(y) * size.x + x]; }
};

// The pixels of a part of an image, half open.
Image part_of(const Image& image, ivec2 begin, ivec2 end);
std::uint64_t hash_of(const Image& image);  // XXH3 over its bits

struct NonFiniteSample {
  ivec2 pixel;
  std::uint32_t iteration;
};

class Film {
 public:
  explicit Film(ivec2 resolution) : sum_(resolution), weight_(sum_.pixels.size(), 0) {}

  ivec2 resolution() const { return sum_.size; }

  // Adds one sample to a pixel, of a weight that may be negative. A pixel belongs to one thread at a time. A non-finite value
  // is added as zero and counted; the first few are kept for replay.
  void add(ivec2 pixel, const Rgb& value, std::uint32_t iteration, double weight = 1);

  // Replaces a pixel's samples so far by one value, for methods whose image is not the mean of samples.
  void set(ivec2 pixel, const dvec3& value);

  Image mean() const;
  std::uint64_t non_finite_count() const { return non_finite_count_; }
  const std::vector<NonFiniteSample>& non_finite() const { return non_finite_; }
  std::uint64_t hash() const { return hash_of(mean()); }

 private:
  void record_non_finite(ivec2 pixel, std::uint32_t iteration);

  Image sum_;
  std::vector<double> weight_;
  std::mutex non_finite_mutex_;
  std::uint64_t non_finite_count_ = 0;
  std::vector<NonFiniteSample> non_finite_;  // the first 16 by (iteration, pixel)
};

}  // namespace etendue
