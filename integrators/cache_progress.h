// How a cache is refined as iterations go on, and the mean of what it adds to an image meanwhile.
//
// Iterations 0 to 4 fill it, each more finely than the one before: an overture that a budget of time can cut short. With
// t = 1 + max(0, iteration - 4) / 50 the accuracy falls from there as t^(-1/6), so that records grow as t^(1/3), and passes per
// record grow as t^(2/3): of all splits of a constant effort per iteration this lets the squares of interpolation error
// (t^(-2/3) with gradients) and of the records' noise fall alike. Beyond the overture t rises in steps, ten to its doubling
// or, where that is less, as far as one pass more, and records change at steps alone: to find anew how far all of them reach
// costs as much as tracing some passes.
#pragma once

#include "framework/image/film.h"

#include <vector>

namespace etendue {

struct CacheProgress {
  float accuracy = 0.2f;  // asked for
  bool refines = true;

  static constexpr std::uint32_t overture_rounds = 4;
  static constexpr float overlap = 1.25f;  // at most, as far as the accuracy asked for allows (irradiance_records.h)

  double time_at(std::uint32_t iteration) const;
  double time_after(double time) const;  // that of the next step
  // Does an iteration after the overture begin with another refinement?
  bool steps_at(std::uint32_t iteration) const;
  double passes_at(std::uint32_t iteration) const;  // over a record's hemisphere
  float accuracy_at(std::uint32_t iteration) const;
  float accuracy_after(std::uint32_t iteration) const;  // of the refinement that comes next
  // Of what the cache adds in an iteration: its error falls as the square of the accuracy.
  double weight_at(std::uint32_t iteration) const;
  // Does this pixel ask for records? Few do in each iteration: slivers shall not have many.
  bool asks(std::uint64_t pixel, std::uint32_t iteration) const;
};

// The part of each pixel that a cache adds: a mean over iterations of different weights, in a film that has equal ones. Light
// that is found in place of the cache, where no record serves, belongs to that part: else what coarse records of the first
// iterations answered and finer ones leave open would be lost by as much as their weights differ.
class CachedLight {
 public:
  // `states_error`: keeps what standard_error() takes.
  explicit CachedLight(ivec2 resolution = ivec2(0), bool states_error = false)
      : resolution_(resolution), sums_(static_cast<std::size_t>(resolution.x) * resolution.y, dvec3(0)) {
    if (states_error) scatter_.resize(sums_.size());
  }

  void begin(std::uint32_t iteration, double weight);
  // Once per pixel and iteration, from any thread; `sampled` is the part of which each iteration weighs the same,
  // `cached_error` the standard error of `cached`, of its luminance.
  void add(Film& film, ivec2 pixel, const Rgb& sampled, const Rgb& cached, float cached_error = 0);
  // Of the pixels' luminance, in all channels. The scatter of samples falls with their number (for one sample it is not known);
  // the cache's error is that of records which serve again and again, so that its mean over iterations stands.
  Image standard_error() const;

 private:
  struct Scatter {
    double mean = 0, squares = 0;  // of the luminance; of its deviations, a sum ([Welford1962])
    double cached_error = 0;       // weighted sum
  };

  ivec2 resolution_;
  std::vector<dvec3> sums_;  // weighted
  std::vector<Scatter> scatter_;
  std::uint32_t iteration_ = 0;
  double weight_ = 0, weights_before_ = 0;  // of this iteration; sum of those before it
};

}  // namespace etendue
