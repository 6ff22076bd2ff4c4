// The stages by which a cache is refined, when it goes on to the next one, and the mean of what it adds to the image meanwhile.
//
// Stages 0 and 1 fill it coarsely, with a sixteenth and a quarter of a record's rays: an overture, which gives an image early
// even if the time is short. Each begins without records: none of few rays stays, and none says where others lie. Stage 2 fills
// it at twice the accuracy asked for, since up to there the noise of records is the greater part of their error. Then t = 1,
// and with it the accuracy falls as t^(-1/6), so that records grow as t^(1/3), and passes per record grow as t^(2/3): this lets
// the squared interpolation error (t^(-2/3) with gradients) and the variance of the records fall at the same rate. t rises in
// steps, ten per doubling, and from 22 passes on so that each step adds one pass. Records change only at steps, because
// recomputing the validity radius of all of them costs as much as tracing some passes.
//
// Where light is rare, its noise outweighs the error of interpolation for long, and the work of a stage goes into rays alone:
// the accuracy stays that of an earlier stage while records state a squared error above c times the fourth power of it.
// ([Ward1988]'s error of a record is of first order; with gradients interpolation errs by its square, and the squared error by
// the fourth power.)
//
// Where rays end in a map of four times `first_map` photons or more, that takes further steps: stage 2 meets an eighth of them,
// but `first_map` at least, and each stage after it eight times as many until there are all. At such steps records are made
// anew: in a room that takes less time than the photons, and no blur of a coarser map stays in them.
//
// An iteration begins with the next stage if that lowers the error by more than as much work on camera samples would. Let S be
// the variance that the camera samples so far leave in a pixel and C the squared error that records state. Both fall about in
// proportion to the work w_s and w_c that made them, so the next bit of work is worth more in the cache where
// C / w_c > S / w_s. Work is counted in rays and samples, never in time: the choice depends on what was computed alone.
#pragma once

#include "framework/image/film.h"

#include <vector>

namespace etendue {

struct CacheProgress {
  float accuracy = 0.2f;  // asked for
  bool refines = true;
  int map_photons = 0;    // to which a map grows, in which rays end; 0: there is none
  int first_map = 50000;  // photons that all rays of a record meet first

  static constexpr std::uint32_t overture_stages = 2;  // with few rays
  static constexpr float coarse = 2;                   // accuracy of the first stage with all rays, over the one asked for
  static constexpr float overlap = 1.25f;              // at most, within that accuracy (irradiance_records.h)

  double time_at(std::uint32_t stage) const;
  // Over a record's hemisphere, if the accuracy is that of the stage, or still that of an earlier one, `spacing`.
  double passes_at(std::uint32_t stage) const { return passes_at(stage, stage); }
  double passes_at(std::uint32_t stage, std::uint32_t spacing) const;
  int rays_at(std::uint32_t stage, int samples) const;  // of a pass
  float photon_share_at(std::uint32_t stage) const;     // of the photons that rays meet
  float accuracy_at(std::uint32_t stage) const;
  // The weight of what the cache adds in a stage: about in proportion to the work behind its records, since what earlier
  // records knew is in them. Much more would leave the noise of the camera samples there.
  double weight_at(std::uint32_t stage) const;
  // The stage that a method with new photons in every iteration takes: t first doubles after 50 of them.
  std::uint32_t stage_after(std::uint32_t iterations) const;
  // Does this pixel ask for records? Few pixels do in each iteration, so that narrow slivers do not get many.
  bool asks(std::uint64_t pixel, std::uint32_t iteration) const;

 private:
  float share_at(std::uint32_t stage) const;  // that the overture leaves of rays and photons
  std::uint32_t map_steps() const;
  std::uint32_t map_steps_left(std::uint32_t stage) const;
};

// Holds what has been spent on records and on camera samples, and the error that each leaves (above).
struct EffortSplit {
  static constexpr double ray_work = 1.5, gather_ray_work = 4;       // of a ray of a hemisphere: its path; its look-up in a map
  static constexpr double photon_work = 5, caustic_photon_work = 3;  // of one that is emitted, its part of the map included

  static constexpr double least_share = 0.125;  // of the samples' work, whatever records state: they may have missed all light
  static constexpr double worth_neighbours = 0.25;  // c

  double record_work = 0, sample_work = 0;    // in camera samples
  double record_error = 0, sample_error = 0;  // relative mean squares

  bool next_to_records() const {
    return record_error * sample_work > sample_error * record_work || least_share * sample_work > record_work;
  }
  // Does a stage that goes to records make them finer? Else it traces more rays over those there are.
  bool next_to_neighbours(float accuracy) const { return record_error < worth_neighbours * square(square(accuracy)); }
};

// The error of the luminance of one of a cache's answers, as the cache takes it to be.
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
  // `is_signed`: the pixel filter is (framework/scene/pixel_filter.h); iterations weigh alike then.
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

  ivec2 resolution_;
  double forgetting_;
  std::vector<double> signed_;  // the filter's weight of each pixel so far, where it is signed
  std::vector<dvec3> sums_;     // of the cached part, weighted; where the filter is signed, of both
  std::vector<Scatter> scatter_;
  std::uint32_t iteration_ = 0;
  double weight_ = 0, weights_before_ = 0;  // of this iteration; sum of those before it
  double asked_weight_ = 0;                 // which begin() was given
  double shared_ = 1;                       // correlation of this iteration's answers with those of the last one
};

}  // namespace etendue
