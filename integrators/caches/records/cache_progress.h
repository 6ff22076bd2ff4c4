// The schedule by which a cache is refined over the iterations, and the mean of what it adds to the image meanwhile.
//
// Iterations 0 to 4 fill it, each more finely than the one before: an overture, which gives an image early even if the time is
// short. With t = 1 + max(0, iteration - 4) / 50 the accuracy falls from there as t^(-1/6), so that records grow as t^(1/3),
// and passes per record grow as t^(2/3): with a constant effort per iteration this lets the squared interpolation error
// (t^(-2/3) with gradients) and the variance of the records fall at the same rate. Beyond the overture t rises in steps, ten
// per doubling, and from 22 passes on so that each step adds one pass. Records change only at steps, because recomputing the
// validity radius of all of them costs as much as tracing some passes.
#pragma once

#include "framework/image/film.h"

#include <vector>

namespace etendue {

struct CacheProgress {
  float accuracy = 0.2f;  // asked for
  bool refines = true;

  static constexpr std::uint32_t overture_rounds = 4;
  static constexpr float overlap = 1.25f;  // at most, within the requested accuracy (irradiance_records.h)

  double time_at(std::uint32_t iteration) const;
  double time_after(double time) const;  // that of the next step
  // Does an iteration after the overture begin with another refinement?
  bool steps_at(std::uint32_t iteration) const;
  double passes_at(std::uint32_t iteration) const;  // over a record's hemisphere
  float accuracy_at(std::uint32_t iteration) const;
  float accuracy_after(std::uint32_t iteration) const;  // of the refinement that comes next
  // The weight of what the cache adds in an iteration; its error falls as the square of the accuracy.
  double weight_at(std::uint32_t iteration) const;
  // Does this pixel ask for records? Few pixels do in each iteration, so that narrow slivers do not get many.
  bool asks(std::uint64_t pixel, std::uint32_t iteration) const;
};

// What a cache takes the luminance of one of its answers to be off by.
struct CachedError {
  float noise = 0;  // standard error
  float bias = 0;   // signed
};

// The part of each pixel that a cache adds: a weighted mean over iterations, in a film that weights them equally. Light found
// in place of the cache, where no record serves, belongs to this part. Otherwise light would be lost where coarse records of
// the first iterations answer and finer ones of later, heavier iterations leave a gap.
class CachedLight {
 public:
  // `states_error`: keeps what standard_error() takes. `forgetting`: in the noise of a pixel's answers of two iterations, of
  // weights v < w, the correlation is (v / w)^forgetting; 0 for records that stay what they are.
  // `is_signed`: the pixel filter is (framework/scene/pixel_filter.h).
  explicit CachedLight(ivec2 resolution = ivec2(0), bool states_error = false, double forgetting = 0, bool is_signed = false)
      : resolution_(resolution),
        forgetting_(forgetting),
        sums_(static_cast<std::size_t>(resolution.x) * resolution.y, dvec3(0)) {
    if (states_error) scatter_.resize(sums_.size());
    if (is_signed) signed_.resize(sums_.size());
  }

  void begin(std::uint32_t iteration, double weight);
  // To be called once per pixel and iteration, from any thread. `sampled` is the part that counts the same in every iteration;
  // `error` is that of `cached`.
  // `weight`: with a signed filter, what both parts have been multiplied by.
  void add(Film& film, ivec2 pixel, const Rgb& sampled, const Rgb& cached, const CachedError& error = {}, double weight = 1);
  // The standard error of the pixels' luminance, the same in all channels. The error of the sampled part falls with the number
  // of samples (with one sample it is unknown). The cached part comes from the same records in every iteration, or from ones
  // that have most of their values in common, so its noise is that of a sum of correlated answers; its bias is the mean over
  // iterations.
  Image standard_error() const;

 private:
  struct Scatter {
    double mean = 0, squares = 0;  // of the luminance; of its deviations, a sum ([Welford1962])
    double noise = 0;              // of the answers so far, weighted, so much of it as the latest one shares
    double noise_squares = 0;      // variance of their weighted sum
    double bias = 0;               // weighted sum
  };

  // Of one pixel where the filter is signed: its sampled part and the weights of both.
  struct Signed {
    dvec3 sampled{0};
    double of_sampled = 0, of_cached = 0;
  };

  ivec2 resolution_;
  double forgetting_;
  std::vector<Signed> signed_;
  std::vector<dvec3> sums_;  // weighted
  std::vector<Scatter> scatter_;
  std::uint32_t iteration_ = 0;
  double weight_ = 0, weights_before_ = 0;  // of this iteration; sum of those before it
  double shared_ = 1;                       // correlation of this iteration's answers with those of the last one
};

}  // namespace etendue
