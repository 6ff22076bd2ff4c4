#include "integrators/caches/irradiance_cache.h"

#include "framework/core/check.h"
#include "framework/core/error.h"
#include "framework/core/parallel.h"
#include "framework/transport/ray_tools.h"
#include "framework/transport/roulette.h"
#include "integrators/caches/cache_fill.h"
#include "integrators/caches/closed_form_irradiance.h"
#include "integrators/caches/file_cache.h"
#include "integrators/caches/records/cache_progress.h"
#include "integrators/caches/records/record_file.h"
#include "integrators/caches/terminate_in_cache.h"
#include "integrators/paths/emission.h"
#include "integrators/paths/sample_shares.h"

#include <fmt/format.h>

namespace etendue {

namespace {

constexpr int roulette_depth = 5;
constexpr float gap_stretch = 4;  // of accuracy, where the number of records is given

PathSettings paths_to(int max_depth) { return {max_depth, roulette_depth, MisMode::power}; }

// The result of a camera sample.
struct CameraSample {
  Rgb sampled{0}, cached{0};  // by paths and light samples; by the cache, or by paths where it does not answer
  float cached_error = 0;     // standard error of the cache's, of its luminance
  CachePoint wanted;          // the first point that the next accuracy leaves uncovered
  CachePoint wanted_rough;    // likewise, of rough surfaces
};

// A camera path at a surface where a cache may answer.
struct Visit {
  const SurfacePoint& point;
  const Bsdf& bsdf;
  vec3 wo;
  int depth;       // events before it
  float distance;  // of the path from the camera, metres
  Rgb throughput;
};

class IrradianceCache final : public Integrator, public FileCache {
 public:
  IrradianceCache(const IrradianceCacheParams& params, const std::optional<RoughExtension>& rough)
      : params_(params), extension_(rough), sampler_(parse_sampler(params.sampler)), progress_{params.accuracy, params.refine} {
    if (rough) rough_.emplace(rough->settings);
  }

  void prepare(RenderContext& context) override;
  void iteration(RenderContext& context, std::uint32_t index, Film& film) override;
  Expectation expectation() const override;
  SavableCache* savable_cache() override { return this; }
  std::optional<std::vector<RecordShape>> record_shapes() const override {
    std::vector<RecordShape> shapes;
    if (cache_) shapes = cache_->shapes();
    if (rough_) rough_->add_shapes(shapes);
    return shapes;
  }
  std::optional<Image> standard_error() const override { return cached_.standard_error(); }

 private:
  Identity identity() const override;
  void write(ByteWriter& body) const override;
  void read(const RenderContext& context, ByteReader& body) override;
  void fill_by_closed_form(const RenderContext& context, CacheSettings& settings) const;
  void fill_before(const RenderContext& context);
  float accuracy_at(std::uint32_t index) const {
    return params_.records > 0 ? cache_->accuracy() : progress_.accuracy_at(index);
  }
  void refine(const RenderContext& context, std::uint32_t index);
  bool add_irradiance(const RenderContext& context, const Visit& at, float next_accuracy, CameraSample& out) const;
  bool add_rough(const RenderContext& context, const Visit& at, Sampler& sampler, float next_accuracy, CameraSample& out) const;
  CameraSample camera_sample(const RenderContext& context, Ray ray, Sampler& sampler, float next_accuracy) const;

  IrradianceCacheParams params_;
  std::optional<RoughExtension> extension_;
  SamplerKind sampler_;
  CacheProgress progress_;
  int max_depth_ = 0;
  bool by_closed_form_ = false;
  int cached_below_ = 0;  // events before a point at which light is cached
  std::unique_ptr<CacheLevels> cache_;
  HemisphereRadiance radiance_;
  Rgb kept_{1};                                    // share of a record's light that a limit of one event less would leave
  std::vector<CachePoint> wanted_, wanted_rough_;  // by pixel
  std::optional<RoughCache> rough_;
  CachedLight cached_;
  SampleShares shares_;
  CacheStanding standing_;
  std::vector<std::vector<RecordHistory>> saved_;  // by level, until they are used
};

void IrradianceCache::prepare(RenderContext& context) {
  const auto timed = context.phases.measure("initial_pass");
  max_depth_ = context.max_depth(params_.max_depth);
  // Direct light takes one scattering event, indirect light two at least.
  cached_below_ = max_depth_ - (params_.cache_direct ? 0 : 1);
  CacheSettings settings = cache_settings(params_, sampler_, params_.structure);
  by_closed_form_ = params_.fill == "closed-form";
  if (by_closed_form_ || params_.fill == "exact-values") fill_by_closed_form(context, settings);
  if (params_.refine && params_.records == 0) settings.overlap = CacheProgress::overlap;
  if (params_.records > 0 || by_closed_form_) settings.stretch = gap_stretch;
  // Loaded records keep the spacings of their own accuracy if it was found for a number of records, or if no new records will
  // fill the gaps that a coarser accuracy would leave.
  if (standing_.loaded() && params_.records > 0)
    settings.accuracy = standing_.accuracy();
  else if (standing_.loaded() && !params_.refine && !by_closed_form_)
    settings.accuracy = std::min(settings.accuracy, standing_.accuracy());
  settings.overture = params_.overture;
  const ivec2 size = context.resolution;
  std::vector<CachePoint> seen(static_cast<std::size_t>(size.x) * size.y);
  parallel_pixels(
      size, [&](ivec2 pixel) { seen[pixel_index(pixel, size)] = find_cache_point(context, pixel, cached_below_, sampler_); });
  if (params_.fill == "records") kept_ = kept_below_limit(context, settings, seen, paths_to(max_depth_), params_.cache_direct);
  cached_ = CachedLight(size, context.states_error);
  wanted_.assign(seen.size(), {});
  cache_ = std::make_unique<CacheLevels>(context, settings, std::move(seen), max_depth_ > shared_above);
  radiance_ = [this, &context](std::span<PathSample> paths, int depth) {
    const TerminateInCache end(*cache_, depth - 1, params_.cache_direct, kept_);
    trace_paths(context, paths, depth, paths_to(max_depth_), params_.cache_direct, params_.fill == "records" ? &end : nullptr);
  };
  if (rough_) rough_->prepare(context, cached_below_, max_depth_ > shared_above);
  if (rough_ && !rough_->active()) rough_.reset();
  if (rough_) wanted_rough_.assign(wanted_.size(), {});
  fill_before(context);
  shares_ = SampleShares(size, by_closed_form_ ? 0 : params_.extra_samples, params_.refine ? standing_.first_round() : 0);
}

void IrradianceCache::fill_by_closed_form(const RenderContext& context, CacheSettings& settings) const {
  if (!context.scene.closed_form)
    throw Error(fmt::format("irradiance-cache: fill = {}: the image of {} is not known; expected an exact scene", params_.fill,
                            context.scene.name));
  if (!params_.cache_direct)
    throw Error(fmt::format("irradiance-cache: fill = {} holds all light; expected cache_direct = true", params_.fill));
  settings.at_point = [&context](const CachePoint& point, int) { return closed_form_irradiance(context, point); };
  settings.judges_by_rays = !by_closed_form_;
  if (settings.judges_by_rays) return;
  const CacheMetric metric = cache_metric(params_.metric);
  if (metric == CacheMetric::geometric_hessian || metric == CacheMetric::tabellion || metric == CacheMetric::split_sphere)
    throw Error(
        fmt::format("irradiance-cache: fill = closed-form has no hemispheres, by which metric = {} judges", params_.metric));
}

// What is done before the first iteration.
void IrradianceCache::fill_before(const RenderContext& context) {
  standing_.begin(context, params_.refine);
  if (standing_.loaded()) {
    cache_->resume(context, std::move(saved_), standing_.accuracy(), standing_.key_salt());
    if (rough_) rough_->resume(context, standing_.accuracy(), standing_.key_salt(), params_.refine);
    const float accuracy = params_.records > 0 ? standing_.accuracy() : standing_.accuracy_wanted(progress_);
    if (!standing_.needs_filling(accuracy)) return;
    cache_->fill(context, radiance_, accuracy);
    if (rough_) rough_->fill(context, radiance_, accuracy);
  } else if (params_.records > 0) {
    cache_->fill_to(context, radiance_, static_cast<std::size_t>(params_.records));
  } else if (!params_.refine) {
    cache_->fill(context, radiance_, params_.accuracy);
    if (rough_) rough_->fill(context, radiance_, params_.accuracy);
  }
}

FileCache::Identity IrradianceCache::identity() const {
  // With a given number of records, `accuracy` is where the search for it began, so it must agree.
  const std::string_view free_accuracy = params_.records > 0 ? "structure" : "accuracy";
  Identity own{"irradiance-cache", {}, {free_accuracy, "extra_samples", "lobe_samples", "refine", "structure"}};
  own.params = extension_ ? extension_->params : param_texts(params_);
  if (extension_) own.integrator = extension_->integrator;
  return own;
}

void IrradianceCache::write(ByteWriter& body) const {
  CHECK(cache_ != nullptr);
  standing_.write(body, cache_->accuracy());
  write_levels(body, cache_->histories());
  if (rough_) rough_->write(body);
}

void IrradianceCache::read(const RenderContext& context, ByteReader& body) {
  const bool one_level = context.max_depth(params_.max_depth) > shared_above;
  standing_.read(body);
  saved_ = read_levels(body, one_level, IrradianceEstimate{});
  if (rough_) rough_->read(context, body, one_level);
}

void IrradianceCache::refine(const RenderContext& context, std::uint32_t index) {
  const auto timed = context.phases.measure("initial_pass");
  const float accuracy = accuracy_at(index);
  if (params_.records == 0 && index <= CacheProgress::overture_rounds) {
    cache_->fill(context, radiance_, accuracy);
    if (rough_) rough_->fill(context, radiance_, accuracy);
  } else if (progress_.steps_at(index)) {
    cache_->refine(context, radiance_, accuracy, progress_.passes_at(index), wanted_, index);
    if (rough_) rough_->refine(context, radiance_, accuracy, progress_.passes_at(index), wanted_rough_, index);
  } else {
    return;
  }
  std::fill(wanted_.begin(), wanted_.end(), CachePoint{});
  std::fill(wanted_rough_.begin(), wanted_rough_.end(), CachePoint{});
}

void IrradianceCache::iteration(RenderContext& context, std::uint32_t index, Film& film) {
  const std::uint32_t stage = standing_.first_round() + index;
  const std::uint32_t round = params_.refine ? stage : index;  // of random numbers: none are drawn again after loading
  if (params_.refine) {
    refine(context, stage);
    standing_.reached(stage + 1);
  }
  const auto timed = context.phases.measure("gather");
  const float next_accuracy = params_.records > 0 ? infinity : progress_.accuracy_after(stage);
  cached_.begin(index, params_.records > 0 ? 1 : progress_.weight_at(stage));
  parallel_pixels(context.resolution, [&](ivec2 pixel) {
    const auto key = pixel_index(pixel, context.resolution);
    const SampleShares::Range samples = shares_.range(key);
    CameraSample mean;
    for (std::uint32_t i = samples.begin; i < samples.begin + samples.count; ++i) {
      Sampler sampler(sampler_, context.seed, Stream::camera, key, i);
      const Ray ray = by_closed_form_ ? context.scene.camera.ray(context.resolution, vec2(pixel) + 0.5f, vec2(0.5f))
                                      : sample_camera_ray(context, pixel, sampler);
      const CameraSample sample = camera_sample(context, ray, sampler, next_accuracy);
      shares_.add(key, luminance(sample.sampled + sample.cached));
      mean.sampled += sample.sampled;
      mean.cached += sample.cached;
      mean.cached_error += sample.cached_error;
      if (!mean.wanted) mean.wanted = sample.wanted;
      if (!mean.wanted_rough) mean.wanted_rough = sample.wanted_rough;
    }
    const float share = 1 / static_cast<float>(samples.count);
    if (params_.records == 0 && progress_.asks(key, round)) {
      if (mean.wanted) wanted_[key] = mean.wanted;
      if (mean.wanted_rough) wanted_rough_[key] = mean.wanted_rough;
    }
    cached_.add(film, pixel, share * mean.sampled, share * mean.cached, {share * mean.cached_error});
  });
  shares_.end_iteration();
}

// Adds the light that a cached surface reflects by its records; false where none covers it.
bool IrradianceCache::add_irradiance(const RenderContext& context, const Visit& at, float next_accuracy,
                                     CameraSample& out) const {
  const vec3 normal = towards(at.point.shading_normal, at.point.normal, at.wo);
  const auto record = cache_->interpolate(at.depth, at.point.position, normal, context.states_error);
  if (record) {
    const Rgb reflected = at.throughput * base_reflectance(context.scene, at.point, at.bsdf, at.wo) * inv_pi;
    out.cached += reflected * record->irradiance;
    out.cached_error += luminance(reflected) * record->standard_error;
  }
  if (!out.wanted && !(record && record->error < next_accuracy))
    out.wanted = cache_point(context, at.point, at.wo, at.distance, at.depth);
  return record.has_value();
}

// The same of a rough surface, by its radiance cache.
bool IrradianceCache::add_rough(const RenderContext& context, const Visit& at, Sampler& sampler, float next_accuracy,
                                CameraSample& out) const {
  const auto reflected = rough_->reflected(at.point, at.bsdf, at.wo, at.depth, sampler, context.states_error);
  if (reflected) {
    out.cached += at.throughput * reflected->radiance;
    out.cached_error += luminance(at.throughput) * reflected->standard_error;
  }
  if (!out.wanted_rough && !(reflected && reflected->error < next_accuracy))
    out.wanted_rough = cache_point(context, at.point, at.wo, at.distance, at.depth);
  return reflected.has_value();
}

CameraSample IrradianceCache::camera_sample(const RenderContext& context, Ray ray, Sampler& sampler,
                                            float next_accuracy) const {
  // Light samples at a cached surface: all of its direct light, or only that of lights no ray can find.
  const MisMode cached_mode = params_.cache_direct ? MisMode::bsdf : MisMode::light;
  CameraSample out;
  Rgb throughput(1);
  float eta_scale = 1, pdf_bsdf = 0, distance = 0;
  bool count_emission = true, only_emission = false;
  // What the path finds, and what it finds in place of the cache, which has no say as to lights that rough lobes meet.
  Rgb *found_light = &out.sampled, *met_light = &out.sampled;
  for (int depth = 0;; ++depth) {
    const Hit hit = trace(context, ray);
    if (!hit) {
      if (count_emission) *met_light += throughput * emitted_with_mis(context, ray, nullptr, pdf_bsdf);
      return out;
    }
    const SurfacePoint point = context.scene.surface_at(ray, hit);
    if (count_emission) *met_light += throughput * emitted_with_mis(context, ray, &point, pdf_bsdf);
    if (depth >= max_depth_ || only_emission) return out;

    const vec3 wo = -ray.direction;
    distance += glm::length(point.position - ray.origin);
    const Bsdf bsdf(context.scene, point);
    const bool cached = is_cached(bsdf);
    *found_light += throughput * direct_light(context, point, bsdf, wo, sampler, cached ? cached_mode : MisMode::power);
    met_light = found_light;
    const Visit visit{point, bsdf, wo, depth, distance, throughput};
    const bool found = cached && depth < cached_below_ && add_irradiance(context, visit, next_accuracy, out);
    if (found && !bsdf.has_specular()) return out;
    bool rough_misses = false;
    if (rough_ && rough_->answers(point.material) && depth < cached_below_) {
      // The BSDF's sample only finds lights from here on, against which the light sample was weighed.
      only_emission = add_rough(context, visit, sampler, next_accuracy, out);
      rough_misses = !only_emission;
    }

    const float u_lobe = sampler.get_1d();
    const BsdfSample scattered = bsdf.sample(wo, u_lobe, sampler.get_2d());
    if (!scattered || is_black(scattered.weight) || (found && !scattered.specular)) return out;
    if (cached && !scattered.specular && depth < cached_below_) found_light = met_light = &out.cached;
    if (rough_misses) found_light = &out.cached;
    // A cached surface has had all of its direct light from the light sample, or none.
    count_emission = !cached || scattered.specular || params_.cache_direct;
    throughput *= scattered.weight;
    if (scattered.transmitted) eta_scale *= scattered.eta * scattered.eta;
    pdf_bsdf = cached ? 0 : scattered.pdf_solid_angle;
    ray = spawn_ray(point, scattered.wi);
    if (depth + 1 >= roulette_depth && !survives_roulette(throughput, survival_of(throughput, eta_scale), sampler)) return out;
  }
}

Expectation IrradianceCache::expectation() const {
  if (extension_)
    return {Bias::biased, -1, 0.05, "interpolation, the records' own noise, and the order of the harmonics [Krivanek2005]"};
  return {Bias::biased, -1, 0.05, "interpolation within the accuracy a, and the records' own noise [Ward1988]"};
}

}  // namespace

std::unique_ptr<Integrator> make_irradiance_cache(const IrradianceCacheParams& params,
                                                  const std::optional<RoughExtension>& rough) {
  return std::make_unique<IrradianceCache>(params, rough);
}

IntegratorEntry irradiance_cache_entry() {
  return {
      "irradiance-cache", "irradiance caching with rotation and translation gradients", list_params<IrradianceCacheParams>(),
      [](const ParamMap& map) { return make_irradiance_cache(read_params<IrradianceCacheParams>(map, "irradiance-cache")); }};
}

}  // namespace etendue
