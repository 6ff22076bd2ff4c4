#include "integrators/caches/photon_cache.h"

#include "framework/transport/ray_tools.h"
#include "integrators/photons/photon_camera_path.h"

namespace etendue {

namespace {

constexpr float kernel_noise = 4.0f / 3;  // variance of a density by n photons under Epanechnikov's kernel, times n

Expectation expectation_of(const PhotonCacheParams& params) {
  const std::string blur = "blur by the kernel's radius and loss at edges [Jensen2001]";
  return {Bias::biased, -1, params.fill == PhotonFill::gather ? 0.05 : 0.1,
          blur + (params.retrace && params.refine ? "; noise and interpolation error fall with iterations"
                  : params.retrace                ? "; interpolation, and the records' own noise [Ward1988]"
                                                  : "; interpolation, and the one map's own noise [Ward1988]")};
}

class PhotonCache final : public RecordCache {
 public:
  explicit PhotonCache(const PhotonCacheParams& params)
      : RecordCache(params, 0, params.fill == PhotonFill::gather ? params.samples : 1),
        params_(params),
        gathers_(params.fill == PhotonFill::gather),
        maps_(params, "photon-cache"),
        expected_(expectation_of(params)) {
    if (!gathers_ && is_hessian(params.metric))
      throw Error(std::string("photon-cache: metric = ") + name_of(params.metric) +
                  ": fill = density has no hemisphere to take Hessians of; expected " +
                  "split-sphere, bounded-split-sphere or tabellion");
  }

  void prepare(RenderContext& context) override;
  Expectation expectation() const override { return expected_; }
  // Records that every iteration makes anew are none to keep.
  bool savable() const override { return gathers_ || !params_.retrace; }

 private:
  Identity identity() const override {
    return {"photon-cache", param_texts(params_), {"accuracy", "extra_samples", "record_structure", "refine", "structure"}, 2};
  }
  bool trace_map(RenderContext& context, std::uint32_t index);
  double ray_work() const override { return EffortSplit::gather_ray_work; }
  double photon_work() const override {
    return params_.retrace ? EffortSplit::caustic_photon_work * maps_.caustic_photons() : 0;
  }
  double photon_record_work() const override {
    const double maps = params_.retrace ? std::floor(progress_.passes_at(stage())) : 1;
    return EffortSplit::photon_work * maps * progress_.photon_share_at(stage()) * maps_.photons();
  }
  bool made_anew() const override { return !gathers_ && params_.retrace; }
  void refine(RenderContext& context, std::uint32_t index) override;
  void gather(const RenderContext& context, std::span<PathSample> paths, int depth) const;
  IrradianceEstimate density(const RenderContext& context, const CachePoint& point, int depth) const;
  void camera_samples(const RenderContext& context, float next_accuracy, std::span<CameraSample> samples) const override {
    for (CameraSample& sample : samples) camera_sample(context, next_accuracy, sample);
  }
  void camera_sample(const RenderContext& context, float next_accuracy, CameraSample& sample) const;

  PhotonCacheParams params_;
  bool gathers_;
  PhotonMaps maps_;
  Expectation expected_;
  std::uint32_t map_pass_ = 0;  // of the photons of the global map
  float map_share_ = 0;         // of the photons that it has; 0: none yet
};

void PhotonCache::prepare(RenderContext& context) {
  context.choose_lights_by(params_.lights);
  max_depth_ = context.max_depth(params_.max_depth);
  maps_.prepare(context, {gathers_ ? params_.samples : 0, max_depth_, sampler_, true, params_.retrace});
  if (gathers_) {
    progress_.map_photons = maps_.photons();
    // Records that were loaded may be of a coarser first map, after which a step has to come.
    if (!standing_.loaded()) progress_.first_map = std::max(progress_.first_map, maps_.photons_to_begin_with());
  }
  expected_ = expectation_in(context, maps_.rough_materials(), std::move(expected_));
  standing_.begin(context, has_overture() && gathers_);
  trace_map(context, 0);
  maps_.trace_caustics(context, params_.retrace ? round_of(0) : 0);

  const auto timed = context.phases.measure("initial_pass");
  CacheSettings settings = cache_settings(params_, params_.record_structure);
  if (!gathers_)
    settings.at_point = [this, &context](const CachePoint& point, int depth) { return density(context, point, depth); };
  // Indirect light takes two scattering events at least.
  start(context, settings, seen_points(context, max_depth_ - 1, &maps_.rough_materials()), params_.extra_samples);
  cache_->set_source(map_pass_);
  radiance_ = [this, &context](std::span<PathSample> paths, int depth) { gather(context, paths, depth); };
  fill_before(context);
}

// Finds what comes along the rays of a hemisphere, each of which has a map at its end.
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

// The map of photons with which records are made in an iteration, where it is not there yet.
bool PhotonCache::trace_map(RenderContext& context, std::uint32_t index) {
  std::uint32_t pass = 0;
  if (made_anew()) {
    pass = round_of(index);
  } else if (params_.retrace && params_.refine) {
    const auto passes = static_cast<std::uint32_t>(progress_.passes_at(stage()));
    pass = std::min(stage(), CacheProgress::overture_stages) + passes - 1;
  }
  const float share = gathers_ ? progress_.photon_share_at(stage()) : 1;
  if (pass == map_pass_ && share == map_share_) return false;
  const bool grew = share > map_share_ && map_share_ > 0;
  maps_.trace_global(context, pass, share);
  map_pass_ = pass;
  map_share_ = share;
  return grew;
}

void PhotonCache::refine(RenderContext& context, std::uint32_t index) {
  if (params_.retrace && index > 0) maps_.trace_caustics(context, round_of(index));
  const bool grew = index > 0 && trace_map(context, index);
  cache_->set_source(map_pass_);

  const auto timed = context.phases.measure("initial_pass");
  refine_records(context, grew || (made_anew() && index > 0), gathers_ ? progress_.passes_at(stage()) : 1);
}

void PhotonCache::camera_sample(const RenderContext& context, float next_accuracy, CameraSample& sample) const {
  const Ray ray = sample_camera_ray(context, sample.pixel, sample.sampler);
  const auto at_rough_vertex = [&](const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, const Rgb& throughput,
                                   int depth, float distance) {
    const int remaining = max_depth_ - depth - 1;
    const Rgb caustics = maps_.caustics(context, point, bsdf, wo, remaining);
    Rgb radiance = all_direct_light(context, point, bsdf, wo, sample.sampler, direct_) + caustics;
    // Photons that stay have noise of their own; of those that are new in every iteration the samples' scatter tells.
    const auto state_error_of = [&](const Rgb& by_photons) {
      if (sample.states_error && !params_.retrace && params_.k > 0)
        sample.cached_error += luminance(throughput * by_photons) * std::sqrt(kernel_noise / static_cast<float>(params_.k));
    };
    state_error_of(caustics);
    // Records by density know nothing of walls and of relief; there photons are gathered at the point itself.
    const PhotonMap& map = maps_.global();
    const bool by_walls =
        !gathers_ && !map.near_walls(point.position, towards(point.normal, point.normal, wo), map.radius()).none();
    const bool has_records = gathers_ ? takes_records(point, wo) : !by_walls && is_flat(point, wo);
    const bool cached = remaining >= 1 && is_cached(bsdf) && has_records;
    bool found = false;
    if (cached) {
      const auto record =
          cache_->interpolate(depth, point.position, towards(point.shading_normal, point.normal, wo), sample.states_error);
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
      const Rgb seen = gathers_ ? maps_.gather(context, 1, false)(point, bsdf, wo, depth, sample.key, sample.index)
                                : maps_.seen_directly(context, point, bsdf, wo, remaining);
      if (!gathers_) state_error_of(seen);
      (cached ? sample.cached : sample.sampled) += throughput * seen;
    }
    sample.sampled += throughput * radiance;
  };
  sample.sampled +=
      PhotonCameraPath{context, maps_.rough_materials(), max_depth_}(ray, sample.sampler, sample.sampler, at_rough_vertex);
}

}  // namespace

IntegratorEntry photon_cache_entry() {
  return integrator_entry<PhotonCache, PhotonCacheParams>(
      "photon-cache", "irradiance caching filled by photons: by final gather into their map, or by their density", 350);
}

}  // namespace etendue
