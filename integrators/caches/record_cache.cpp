#include "integrators/caches/record_cache.h"

#include "framework/core/check.h"
#include "integrators/paths/path_choices.h"

namespace etendue {

RecordSettings record_settings(const RecordParams& params, const std::string& structure) {
  return {.accuracy = (params.refine ? CacheProgress::coarse : 1) * params.accuracy,
          .min_spacing = params.min_spacing,
          .max_spacing = params.max_spacing,
          .strata = HemisphereStrata::of(params.samples),
          .sampler = params.sampler,
          .structure = structure};
}

CacheSettings cache_settings(const CacheParams& params, const std::string& structure) {
  CacheSettings settings;
  static_cast<RecordSettings&>(settings) = record_settings(params, structure);
  settings.metric = params.metric;
  settings.gradients = params.gradients;
  settings.clamping = params.neighbour_clamping;
  return settings;
}

std::vector<RecordShape> RecordCache::record_shapes() const {
  std::vector<RecordShape> shapes;
  if (cache_) shapes = cache_->shapes();
  if (rough_) rough_->add_shapes(shapes);
  return shapes;
}

std::vector<CachePoint> RecordCache::seen_points(const RenderContext& context, int deepest,
                                                 const RoughMaterials* rough_materials) const {
  const ivec2 size = context.resolution;
  std::vector<CachePoint> seen(static_cast<std::size_t>(size.x) * size.y);
  parallel_pixels(size, [&](ivec2 pixel) {
    seen[pixel_index(pixel, size)] = find_cache_point(context, pixel, deepest, sampler_, rough_materials);
  });
  return seen;
}

void RecordCache::start(const RenderContext& context, const CacheSettings& settings, std::vector<CachePoint> seen,
                        float extra_samples) {
  wanted_.assign(seen.size(), {});
  if (rough_) wanted_rough_.assign(seen.size(), {});
  cached_ = CachedLight(context.resolution, context.states_error, 0, has_signed_filter(context));
  // Samples out of their sequence's order could weigh less than nothing in all, where a filter has negative parts.
  shares_ = SampleShares(context.resolution, has_signed_filter(context) ? 0 : extra_samples,
                         progress_.refines ? standing_.first_round() : 0, progress_.refines);
  direct_ = choose_direct(context);
  if (extra_samples > 0 && is_smooth(context, SampleShares::smooth)) shares_.begin_with_one();
  if (photon_work() > 0) shares_.expect_common_noise();
  if (progress_.refines) stated_.assign(seen.size(), -1);
  cache_ = std::make_unique<CacheLevels>(context, settings, std::move(seen), shares_levels());
}

void RecordCache::fill(const RenderContext& context, float accuracy) {
  cache_->fill(context, radiance_, accuracy);
  if (rough_) rough_->fill(context, radiance_, accuracy);
}

void RecordCache::clear(const RenderContext& context) {
  cache_->clear(context);
  if (rough_) rough_->clear(context);
}

void RecordCache::take_rays() {
  const int rays = progress_.rays_at(stage(), samples_);
  cache_->take_rays(rays);
  if (rough_) rough_->take_rays(rays);
}

void RecordCache::fill_before(const RenderContext& context) {
  take_rays();
  if (standing_.loaded()) {
    cache_->resume(context, std::move(saved_), standing_.accuracy(), standing_.key_salt());
    if (rough_) rough_->resume(context, standing_.accuracy(), standing_.key_salt(), progress_.refines);
    if (standing_.cut_short()) clear(context);
    const float accuracy = records_wanted_ > 0 ? standing_.accuracy() : standing_.accuracy_wanted(progress_);
    if (standing_.cut_short() || standing_.needs_filling(accuracy)) fill(context, accuracy);
  } else if (records_wanted_ > 0) {
    cache_->fill_to(context, radiance_, static_cast<std::size_t>(records_wanted_));
  } else if (!progress_.refines) {
    fill(context, progress_.accuracy);
  } else {
    return;
  }
  filled_stage_ = stage();
}

void RecordCache::refine_records(const RenderContext& context, bool anew, double passes) {
  if (filled_stage_ == stage() && !anew) return;
  const float accuracy = records_wanted_ > 0 ? cache_->accuracy() : progress_.accuracy_at(standing_.spacing());
  if (anew || (has_overture() && stage() <= CacheProgress::overture_stages)) {
    clear(context);
    take_rays();
    fill(context, accuracy);
  } else {
    // A step of the overture's accuracy that comes late is a large one.
    if (accuracy < cache_->accuracy() && standing_.spacing() <= CacheProgress::overture_stages) fill(context, accuracy);
    cache_->refine(context, radiance_, accuracy, passes, wanted_, stage());
    if (rough_) rough_->refine(context, radiance_, accuracy, passes, wanted_rough_, stage());
  }
  filled_stage_ = stage();
  std::fill(wanted_.begin(), wanted_.end(), CachePoint{});
  std::fill(wanted_rough_.begin(), wanted_rough_.end(), CachePoint{});
}

// Whether the iteration begins with the next stage.
void RecordCache::choose_stage(std::uint32_t index) {
  if (!progress_.refines) return;
  if (made_anew()) {
    const std::uint32_t next = progress_.stage_after(round_of(index));
    standing_.enter(next, next);
  } else if (index > 0 && split_.next_to_records()) {
    // Rays do not lower the noise of photons that records have in common.
    const bool finer = records_wanted_ > 0 || photon_record_work() > 0 || split_.next_to_neighbours(cache_->accuracy());
    standing_.enter(stage() + 1, standing_.spacing() + (finer ? 1 : 0));
  }
}

// After an iteration: what it and the records have taken so far, and what errors they leave.
void RecordCache::measure_split() {
  iterations_work_ += photon_work();
  split_.sample_work = static_cast<double>(shares_.samples()) + iterations_work_;
  split_.sample_error = shares_.noise();
  const std::uint64_t passes = cache_->passes() + (rough_ ? rough_->passes() : 0);
  split_.record_work = ray_work() * static_cast<double>(passes) * progress_.rays_at(stage(), samples_) + photon_record_work();
  double sum = 0, asked = 0;
  for (std::size_t i = 0; i < stated_.size(); ++i) {
    if (!(stated_[i] >= 0)) continue;
    sum += shares_.relative_square(i, stated_[i]);
    asked += 1;
  }
  if (asked > 0) split_.record_error = sum / asked;
  std::fill(stated_.begin(), stated_.end(), -1.0f);
}

void RecordCache::iteration(RenderContext& context, std::uint32_t index, Film& film) {
  const std::uint32_t round = round_of(index);
  choose_stage(index);
  refine(context, index);
  if (progress_.refines) standing_.reached(round + 1);
  const auto timed = context.phases.measure("gather");
  const bool fixed = records_wanted_ > 0;
  const float next_accuracy = fixed ? infinity : progress_.accuracy_at(standing_.spacing() + 1);
  cached_.begin(index, fixed ? 1 : progress_.weight_at(stage()));
  parallel_tiles(context.resolution, tile_size, [&](const Tile& tile) {
    static thread_local std::vector<CameraSample> samples;  // for its memory
    samples.clear();
    for_pixels(tile, [&](ivec2 pixel) {
      const auto key = pixel_index(pixel, context.resolution);
      const SampleShares::Range range = shares_.range(key);
      const bool states_error = context.states_error || (progress_.refines && progress_.asks(key, round));
      for (std::uint32_t i = range.begin; i < range.begin + range.count; ++i) {
        samples.push_back({pixel, key, i, Sampler(sampler_, context.seed, Stream::camera, key, i)});
        samples.back().states_error = states_error;
      }
    });
    camera_samples(context, next_accuracy, samples);
    auto sample = samples.cbegin();
    for_pixels(tile, [&](ivec2 pixel) {
      const auto key = pixel_index(pixel, context.resolution);
      Rgb sampled(0), cached(0);
      float cached_error = 0, weights = 0;
      CachePoint wanted, wanted_rough;
      const std::uint32_t count = shares_.range(key).count;
      for (std::uint32_t i = 0; i < count; ++i, ++sample) {
        shares_.add(key, luminance(sample->sampled + sample->cached));
        const float weight = sample_weight(context, pixel, sample->index);
        sampled += weight * sample->sampled;
        cached += weight * sample->cached;
        weights += weight;
        cached_error += sample->cached_error;
        if (!wanted) wanted = sample->wanted;
        if (!wanted_rough) wanted_rough = sample->wanted_rough;
      }
      const float share = 1 / static_cast<float>(count);
      if (progress_.refines && progress_.asks(key, round)) {
        if (!fixed && wanted) wanted_[key] = wanted;
        if (!fixed && wanted_rough) wanted_rough_[key] = wanted_rough;
        stated_[key] = share * cached_error;
      }
      cached_.add(film, pixel, share * sampled, share * cached, {share * cached_error}, share * weights);
    });
  });
  shares_.end_iteration();
  if (progress_.refines) measure_split();
}

void RecordCache::write(ByteWriter& body) const {
  CHECK(cache_ != nullptr);
  standing_.write(body, cache_->accuracy());
  write_levels(body, cache_->histories());
  if (rough_) rough_->write(body);
}

void RecordCache::read(const RenderContext& context, ByteReader& body) {
  const bool one_level = context.max_depth(asked_depth_) > shared_above;
  standing_.read(body);
  if (progress_.refines && standing_.rounds() > 0) refuse_signed_filter(context, body);
  saved_ = read_levels(body, one_level, IrradianceEstimate{});
  if (rough_) rough_->read(context, body, one_level);
}

}  // namespace etendue
