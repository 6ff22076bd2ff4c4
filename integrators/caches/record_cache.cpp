#include "integrators/caches/record_cache.h"

#include "framework/core/check.h"

namespace etendue {

RecordSettings record_settings(const RecordParams& params, const std::string& structure) {
  return {.accuracy = params.accuracy,
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
  shares_ = SampleShares(context.resolution, extra_samples, progress_.refines ? standing_.first_round() : 0);
  cache_ = std::make_unique<CacheLevels>(context, settings, std::move(seen), shares_levels());
}

void RecordCache::fill(const RenderContext& context, float accuracy) {
  cache_->fill(context, radiance_, accuracy);
  if (rough_) rough_->fill(context, radiance_, accuracy);
}

void RecordCache::fill_before(const RenderContext& context) {
  if (standing_.loaded()) {
    cache_->resume(context, std::move(saved_), standing_.accuracy(), standing_.key_salt());
    if (rough_) rough_->resume(context, standing_.accuracy(), standing_.key_salt(), progress_.refines);
    const float accuracy = records_wanted_ > 0 ? standing_.accuracy() : standing_.accuracy_wanted(progress_);
    if (standing_.needs_filling(accuracy)) fill(context, accuracy);
  } else if (records_wanted_ > 0) {
    cache_->fill_to(context, radiance_, static_cast<std::size_t>(records_wanted_));
  } else if (!progress_.refines) {
    fill(context, progress_.accuracy);
  }
}

void RecordCache::refine_records(const RenderContext& context, std::uint32_t stage, bool anew, double passes) {
  const float accuracy = records_wanted_ > 0 ? cache_->accuracy() : progress_.accuracy_at(stage);
  const bool initial = progress_.refines && records_wanted_ == 0 && stage <= CacheProgress::overture_rounds;
  if (anew || initial) {
    fill(context, accuracy);
  } else if (progress_.steps_at(stage)) {
    cache_->refine(context, radiance_, accuracy, passes, wanted_, stage);
    if (rough_) rough_->refine(context, radiance_, accuracy, passes, wanted_rough_, stage);
  } else {
    return;
  }
  std::fill(wanted_.begin(), wanted_.end(), CachePoint{});
  std::fill(wanted_rough_.begin(), wanted_rough_.end(), CachePoint{});
}

void RecordCache::iteration(RenderContext& context, std::uint32_t index, Film& film) {
  const std::uint32_t stage = stage_of(index), round = round_of(index);
  refine(context, index);
  if (progress_.refines) standing_.reached(stage + 1);
  const auto timed = context.phases.measure("gather");
  const bool fixed = records_wanted_ > 0;
  const float next_accuracy = fixed ? infinity : progress_.accuracy_after(stage);
  cached_.begin(index, fixed ? 1 : progress_.weight_at(stage));
  parallel_tiles(context.resolution, tile_size, [&](const Tile& tile) {
    static thread_local std::vector<CameraSample> samples;  // for its memory
    samples.clear();
    for_pixels(tile, [&](ivec2 pixel) {
      const auto key = pixel_index(pixel, context.resolution);
      const SampleShares::Range range = shares_.range(key);
      for (std::uint32_t i = range.begin; i < range.begin + range.count; ++i)
        samples.push_back({pixel, key, i, Sampler(sampler_, context.seed, Stream::camera, key, i)});
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
      if (!fixed && progress_.asks(key, round)) {
        if (wanted) wanted_[key] = wanted;
        if (wanted_rough) wanted_rough_[key] = wanted_rough;
      }
      cached_.add(film, pixel, share * sampled, share * cached, {share * cached_error}, share * weights);
    });
  });
  shares_.end_iteration();
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
  saved_ = read_levels(body, one_level, IrradianceEstimate{});
  if (rough_) rough_->read(context, body, one_level);
}

}  // namespace etendue
