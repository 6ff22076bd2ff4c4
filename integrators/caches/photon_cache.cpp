#include "integrators/caches/photon_cache.h"

#include "framework/core/check.h"
#include "framework/core/parallel.h"
#include "framework/transport/ray_tools.h"
#include "integrators/caches/file_cache.h"
#include "integrators/caches/records/cache_progress.h"
#include "integrators/caches/records/record_file.h"
#include "integrators/paths/sample_shares.h"
#include "integrators/photons/photon_camera_path.h"

namespace etendue {

namespace {

constexpr float kernel_noise = 4.0f / 3;  // variance of a density by n photons under Epanechnikov's kernel, times n

// What a camera sample brings.
struct GatherSample {
  std::uint64_t pixel;
  std::uint32_t index;  // among the pixel's samples
  Sampler sampler;
  Rgb sampled{0}, cached{0};  // by light samples and photons; by the cache, or by gather rays in its place
  float cached_error = 0;     // standard error of the cache's, of its luminance
  CachePoint wanted{};        // the first point that the next accuracy leaves uncovered
};

class PhotonCache final : public Integrator, public FileCache {
 public:
  explicit PhotonCache(const PhotonCacheParams& params)
      : params_(params),
        sampler_(parse_sampler(params.sampler)),
        gathers_(params.fill == "gather"),
        maps_(params, "photon-cache"),
        progress_{params.accuracy, params.refine} {
    if (!gathers_ && is_hessian(cache_metric(params.metric)))
      throw Error("photon-cache: metric = " + params.metric +
                  ": fill = density has no hemisphere to take Hessians of; expected " +
                  "split-sphere, bounded-split-sphere or tabellion");
  }

  void prepare(RenderContext& context) override;
  void iteration(RenderContext& context, std::uint32_t index, Film& film) override;
  Expectation expectation() const override;
  std::optional<Image> standard_error() const override { return cached_.standard_error(); }
  // Records that every iteration makes anew are none to keep.
  SavableCache* savable_cache() override { return gathers_ || !params_.retrace ? this : nullptr; }
  std::optional<std::vector<RecordShape>> record_shapes() const override {
    return cache_ ? cache_->shapes() : std::vector<RecordShape>();
  }

 private:
  Identity identity() const override;
  void write(ByteWriter& body) const override;
  void read(const RenderContext& context, ByteReader& body) override;
  // The stage of the refinement, and the round of random numbers and photons, of which none is drawn again after loading.
  std::uint32_t stage_of(std::uint32_t index) const { return standing_.first_round() + index; }
  std::uint32_t round_of(std::uint32_t index) const { return params_.refine ? stage_of(index) : index; }
  std::uint32_t map_at(std::uint32_t round) const;
  void fill_before(const RenderContext& context);
  void refine(RenderContext& context, std::uint32_t index);
  void gather(const RenderContext& context, std::span<PathSample> paths, int depth) const;
  IrradianceEstimate density(const RenderContext& context, const CachePoint& point, int depth) const;
  void camera_sample(const RenderContext& context, const Ray& ray, float next_accuracy, GatherSample& sample) const;

  PhotonCacheParams params_;
  SamplerKind sampler_;
  bool gathers_;
  int max_depth_ = 0;
  PhotonMaps maps_;
  CacheProgress progress_;
  std::unique_ptr<CacheLevels> cache_;
  HemisphereRadiance radiance_;
  std::vector<CachePoint> wanted_;  // by pixel
  CachedLight cached_;
  SampleShares shares_;
  CacheStanding standing_;
  std::vector<std::vector<RecordHistory>> saved_;  // by level, until they are used
  std::uint32_t map_pass_ = 0;                     // of the photons of the global map
};

void PhotonCache::prepare(RenderContext& context) {
  max_depth_ = context.max_depth(params_.max_depth);
  maps_.prepare(context, {gathers_ ? params_.samples : 0, max_depth_, sampler_});
  standing_.begin(context, params_.refine);
  map_pass_ = map_at(round_of(0));
  maps_.trace_global(context, map_pass_);
  maps_.trace_caustics(context, params_.retrace ? round_of(0) : 0);

  const auto timed = context.phases.measure("initial_pass");
  const ivec2 size = context.resolution;
  std::vector<CachePoint> seen(static_cast<std::size_t>(size.x) * size.y);
  parallel_pixels(size, [&](ivec2 pixel) {
    // Indirect light takes two scattering events at least.
    seen[pixel_index(pixel, size)] = find_cache_point(context, pixel, max_depth_ - 1, sampler_, &maps_.rough_materials());
  });
  wanted_.assign(seen.size(), {});
  cached_ = CachedLight(size, context.states_error);
  shares_ = SampleShares(size, params_.extra_samples, params_.refine ? standing_.first_round() : 0);
  CacheSettings settings = cache_settings(params_, sampler_, params_.record_structure);
  if (!gathers_)
    settings.at_point = [this, &context](const CachePoint& point, int depth) { return density(context, point, depth); };
  cache_ = std::make_unique<CacheLevels>(context, settings, std::move(seen), max_depth_ > shared_above);
  cache_->set_source(map_pass_);
  radiance_ = [this, &context](std::span<PathSample> paths, int depth) { gather(context, paths, depth); };
  fill_before(context);
}

// What is done before the first iteration.
void PhotonCache::fill_before(const RenderContext& context) {
  if (!standing_.loaded()) {
    if (!params_.refine) cache_->fill(context, radiance_, params_.accuracy);
    return;
  }
  cache_->resume(context, std::move(saved_), standing_.accuracy(), standing_.key_salt());
  const float accuracy = standing_.accuracy_wanted(progress_);
  if (standing_.needs_filling(accuracy)) cache_->fill(context, radiance_, accuracy);
}

FileCache::Identity PhotonCache::identity() const {
  return {"photon-cache", param_texts(params_), {"accuracy", "extra_samples", "record_structure", "refine", "structure"}};
}

void PhotonCache::write(ByteWriter& body) const {
  CHECK(cache_ != nullptr);
  standing_.write(body, cache_->accuracy());
  write_levels(body, cache_->histories());
}

void PhotonCache::read(const RenderContext& context, ByteReader& body) {
  standing_.read(body);
  saved_ = read_levels(body, context.max_depth(params_.max_depth) > shared_above, IrradianceEstimate{});
}

// What comes along the rays of a hemisphere, of which each has a map at its end.
void PhotonCache::gather(const RenderContext& context, std::span<PathSample> paths, int depth) const {
  static thread_local std::vector<Ray> rays;
  static thread_local std::vector<Hit> hits;
  rays.clear();
  for (const PathSample& path : paths) rays.push_back(path.ray);
  hits.resize(rays.size());
  trace(context, rays, hits);
  const FinalGather gather = maps_.gather(context, 1, false);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (!hits[i]) continue;
    PathSample& path = paths[i];
    path.first_distance = hits[i].t;
    path.first_normal = context.scene.surface_at(path.ray, hits[i]).normal;
    path.radiance = gather.along(path.ray, hits[i], depth, path.sampler, &path.first_photon_footprint);
  }
}

IrradianceEstimate PhotonCache::density(const RenderContext& context, const CachePoint& point, int depth) const {
  const GatherPoint at = GatherPoint::irradiance(point.position, point.geometric, point.origin, max_depth_ - depth);
  const PhotonMap::Estimate found = maps_.global().measure(context, at);
  IrradianceEstimate estimate;
  estimate.irradiance = found.radiance;
  // A map that stays has noise of its own; one that is new in every iteration shows it in their scatter.
  if (found.radius > 0 && !params_.retrace) {
    const float photons = pi * square(found.radius) / std::max(found.photon_footprint, 1e-30f);
    estimate.shared_variance = square(luminance(estimate.irradiance)) * kernel_noise / photons;
  }
  if (found.radius > 0) {
    estimate.nearest = found.radius / usual_accuracy;
    estimate.inverse_distance = 1 / estimate.nearest;
  }
  return estimate;
}

// The pass of photons with which records are made.
std::uint32_t PhotonCache::map_at(std::uint32_t round) const {
  if (!params_.retrace || (gathers_ && !params_.refine)) return 0;
  const auto passes = [&](std::uint32_t at) { return std::floor(progress_.passes_at(at)); };
  while (gathers_ && round > 0 && passes(round) == passes(round - 1)) --round;
  return round;
}

void PhotonCache::refine(RenderContext& context, std::uint32_t index) {
  const std::uint32_t stage = stage_of(index), map_pass = map_at(round_of(index));
  if (params_.retrace && index > 0) maps_.trace_caustics(context, round_of(index));
  const bool new_map = map_pass != map_pass_;
  if (new_map) maps_.trace_global(context, map_pass);
  map_pass_ = map_pass;
  cache_->set_source(map_pass_);

  const auto timed = context.phases.measure("initial_pass");
  const bool anew = new_map && !gathers_;  // records on this map alone
  if (anew) cache_->clear(context);
  const float accuracy = progress_.accuracy_at(stage);
  if (anew || (progress_.refines && stage <= CacheProgress::overture_rounds))
    cache_->fill(context, radiance_, accuracy);
  else if (progress_.steps_at(stage))
    cache_->refine(context, radiance_, accuracy, gathers_ ? progress_.passes_at(stage) : 1, wanted_, stage);
  else
    return;
  std::fill(wanted_.begin(), wanted_.end(), CachePoint{});
}

void PhotonCache::iteration(RenderContext& context, std::uint32_t index, Film& film) {
  const std::uint32_t stage = stage_of(index);
  refine(context, index);
  if (params_.refine) standing_.reached(stage + 1);
  const auto timed = context.phases.measure("gather");
  const float next_accuracy = progress_.accuracy_after(stage);
  cached_.begin(index, progress_.weight_at(stage));
  parallel_pixels(context.resolution, [&](ivec2 pixel) {
    const auto key = pixel_index(pixel, context.resolution);
    const SampleShares::Range samples = shares_.range(key);
    Rgb sampled(0), cached(0);
    float cached_error = 0;
    CachePoint wanted;
    for (std::uint32_t i = samples.begin; i < samples.begin + samples.count; ++i) {
      GatherSample sample{key, i, Sampler(sampler_, context.seed, Stream::camera, key, i)};
      const Ray ray = sample_camera_ray(context, pixel, sample.sampler);
      camera_sample(context, ray, next_accuracy, sample);
      shares_.add(key, luminance(sample.sampled + sample.cached));
      sampled += sample.sampled;
      cached += sample.cached;
      cached_error += sample.cached_error;
      if (!wanted) wanted = sample.wanted;
    }
    const float share = 1 / static_cast<float>(samples.count);
    if (wanted && progress_.asks(key, round_of(index))) wanted_[key] = wanted;
    cached_.add(film, pixel, share * sampled, share * cached, {share * cached_error});
  });
  shares_.end_iteration();
}

void PhotonCache::camera_sample(const RenderContext& context, const Ray& ray, float next_accuracy, GatherSample& sample) const {
  const auto at_rough_vertex = [&](const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, const Rgb& throughput,
                                   int depth, float distance) {
    const int remaining = max_depth_ - depth - 1;
    const Rgb caustics = maps_.caustics(context, point, bsdf, wo, remaining);
    Rgb radiance = direct_light(context, point, bsdf, wo, sample.sampler, MisMode::light) + caustics;
    // Photons that stay have noise of their own; of those that are new in every iteration the samples' scatter tells.
    const auto state_error_of = [&](const Rgb& by_photons) {
      if (context.states_error && !params_.retrace && params_.k > 0)
        sample.cached_error += luminance(throughput * by_photons) * std::sqrt(kernel_noise / static_cast<float>(params_.k));
    };
    state_error_of(caustics);
    // Records by density know nothing of walls; near them photons are gathered at the point itself.
    const PhotonMap& map = maps_.global();
    const bool by_walls =
        !gathers_ && !map.near_walls(point.position, towards(point.normal, point.normal, wo), map.radius()).none();
    const bool cached = remaining >= 1 && is_cached(bsdf) && !by_walls;
    bool found = false;
    if (cached) {
      const auto record =
          cache_->interpolate(depth, point.position, towards(point.shading_normal, point.normal, wo), context.states_error);
      if (record) {
        const Rgb reflected = throughput * base_reflectance(context.scene, point, bsdf, wo);
        sample.cached += reflected * record->irradiance * inv_pi;
        sample.cached_error += luminance(reflected) * inv_pi * record->standard_error;
      }
      found = record.has_value();
      if (!sample.wanted && !(record && record->error < next_accuracy))
        sample.wanted = cache_point(context, point, wo, distance, depth);
    }
    if (remaining >= 1 && !found) {
      const Rgb seen = gathers_ ? maps_.gather(context, 1, false)(point, bsdf, wo, depth, sample.pixel, sample.index)
                                : maps_.seen_directly(context, point, bsdf, wo, remaining);
      if (!gathers_) state_error_of(seen);
      (cached ? sample.cached : sample.sampled) += throughput * seen;
    }
    sample.sampled += throughput * radiance;
  };
  sample.sampled +=
      PhotonCameraPath{context, maps_.rough_materials(), max_depth_}(ray, sample.sampler, sample.sampler, at_rough_vertex);
}

Expectation PhotonCache::expectation() const {
  const std::string blur = "blur by the kernel's radius and loss at edges [Jensen2001]";
  return {Bias::biased, -1, gathers_ ? 0.05 : 0.1,
          blur + (params_.retrace && params_.refine ? "; noise and interpolation error fall with iterations"
                  : params_.retrace                 ? "; interpolation, and the records' own noise [Ward1988]"
                                                    : "; interpolation, and the one map's own noise [Ward1988]")};
}

}  // namespace

IntegratorEntry photon_cache_entry() {
  return {"photon-cache", "irradiance caching filled by photons: by final gather into their map, or by their density",
          list_params<PhotonCacheParams>(), [](const ParamMap& map) {
            return std::make_unique<PhotonCache>(read_params<PhotonCacheParams>(map, "photon-cache"));
          }};
}

}  // namespace etendue
