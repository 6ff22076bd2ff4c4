#include "integrators/caches/irradiance_cache.h"

#include "framework/core/error.h"
#include "framework/transport/ray_tools.h"
#include "framework/transport/roulette.h"
#include "integrators/caches/closed_form_irradiance.h"
#include "integrators/caches/terminate_in_cache.h"
#include "integrators/paths/emission.h"
#include "integrators/paths/wavefront.h"
#include "integrators/pilot/caustic_need.h"

#include <fmt/format.h>

namespace etendue {

namespace {

constexpr int roulette_depth = 5;
constexpr float gap_stretch = 4;  // of accuracy, where the number of records is given

PathSettings paths_to(int max_depth) { return {max_depth, roulette_depth, MisMode::power}; }

// A camera path at a surface where a cache may answer.
struct Visit {
  const SurfacePoint& point;
  const Bsdf& bsdf;
  vec3 wo;
  int depth;       // events before it
  float distance;  // of the path from the camera, metres
  Rgb throughput;
};

class IrradianceCache final : public RecordCache {
 public:
  IrradianceCache(const IrradianceCacheParams& params, const std::optional<RoughExtension>& rough)
      : RecordCache(params, params.records, params.samples), params_(params), extension_(rough) {
    if (rough) rough_.emplace(rough->settings);
  }

  void prepare(RenderContext& context) override;
  Expectation expectation() const override;

 private:
  // A camera path under way.
  struct CameraPath {
    CameraSample* sample;
    // The path adds the light it finds to the first. To the second it adds what it finds in place of the cache, which holds
    // nothing of lights that rough lobes meet.
    Rgb *found_light, *met_light;
    Rgb throughput{1};
    float eta_scale = 1, pdf_bsdf = 0, distance = 0;
    bool count_emission = true, only_emission = false;
    CausticChain chain;

    explicit CameraPath(CameraSample& s) : sample(&s), found_light(&s.sampled), met_light(&s.sampled) {}
  };

  Identity identity() const override;
  CausticMap* caustic_map() override { return &params_.caustic_map; }
  void fill_by_closed_form(const RenderContext& context, CacheSettings& settings) const;
  void refine(RenderContext& context, std::uint32_t index) override;
  double photon_work() const override { return caustics_ ? EffortSplit::caustic_photon_work * caustics_->photons() : 0; }
  bool add_irradiance(const RenderContext& context, const Visit& at, float next_accuracy, CameraSample& out) const;
  bool add_rough(const RenderContext& context, const Visit& at, float next_accuracy, CameraSample& out) const;
  void camera_samples(const RenderContext& context, float next_accuracy, std::span<CameraSample> samples) const override;
  bool meet(const RenderContext& context, float next_accuracy, CameraPath& path, Ray& ray, const SurfacePoint* point, int depth,
            Wavefront<CameraPath>& wave) const;

  IrradianceCacheParams params_;
  std::optional<RoughExtension> extension_;
  std::unique_ptr<CausticLight> caustics_;  // null: paths meet lights behind specular surfaces by chance
  bool by_closed_form_ = false;
  int cached_below_ = 0;   // events before a point at which light is cached
  std::vector<Rgb> kept_;  // see kept_below_limit
};

void IrradianceCache::prepare(RenderContext& context) {
  by_closed_form_ = params_.fill == RecordFill::closed_form;
  const bool holds_all = by_closed_form_ || params_.fill == RecordFill::exact_values;
  if (!holds_all) decide_caustic_map(context, params_, enough_hits_of_records);
  context.choose_lights_by(params_.lights);
  std::optional<PhaseTimes::Scope> timed(std::in_place, context.phases, "initial_pass");
  max_depth_ = context.max_depth(params_.max_depth);
  // Direct light takes one scattering event, indirect light two at least.
  cached_below_ = max_depth_ - (params_.cache_direct ? 0 : 1);
  CacheSettings settings = cache_settings(params_, params_.structure);
  if (holds_all) fill_by_closed_form(context, settings);
  if (params_.refine && params_.records == 0) settings.overlap = CacheProgress::overlap;
  if (params_.records > 0 || by_closed_form_) settings.stretch = gap_stretch;
  // Loaded records keep the spacings of their own accuracy if it was found for a number of records, or if no new records will
  // fill the gaps that a coarser accuracy would leave.
  if (standing_.loaded() && params_.records > 0)
    settings.accuracy = standing_.accuracy();
  else if (standing_.loaded() && !params_.refine && !by_closed_form_)
    settings.accuracy = std::min(settings.accuracy, standing_.accuracy());
  settings.overture = params_.overture;
  standing_.begin(context, has_overture());
  std::vector<CachePoint> seen = seen_points(context, cached_below_, nullptr);
  if (rough_) rough_->prepare(context, cached_below_, shares_levels());
  if (rough_ && !rough_->active()) rough_.reset();
  timed.reset();
  if (params_.caustic_map == CausticMap::on) {
    const float narrow = rough_ ? rough_->narrowest() : infinity;
    caustics_ = std::make_unique<CausticLight>(context, params_.caustic_photons, max_depth_, sampler_, narrow);
    caustics_->trace(context, round_of(0));
  }
  timed.emplace(context.phases, "initial_pass");
  const bool by_records = params_.fill == RecordFill::records;
  if (by_records)
    kept_ = kept_below_limit(context, settings, seen, paths_to(max_depth_), params_.cache_direct, caustics_.get());
  start(context, settings, std::move(seen), by_closed_form_ ? 0 : params_.extra_samples);
  radiance_ = [this, by_records, &context](std::span<PathSample> paths, int depth) {
    const auto level = static_cast<std::size_t>(depth - 1);
    const std::optional<Rgb> kept = level < kept_.size() ? std::optional(kept_[level]) : std::nullopt;
    const TerminateInCache end(context.scene, *cache_, depth - 1, params_.cache_direct, kept);
    const bool ends = by_records && (kept || max_depth_ > shared_above);
    trace_paths(context, paths, depth, paths_to(max_depth_), params_.cache_direct, ends ? &end : nullptr, caustics_.get());
  };
  fill_before(context);
}

void IrradianceCache::fill_by_closed_form(const RenderContext& context, CacheSettings& settings) const {
  const char* const fill = name_of(params_.fill);
  if (!context.scene.closed_form)
    throw Error(fmt::format("irradiance-cache: fill = {}: the image of {} is not known; expected an exact scene", fill,
                            context.scene.name));
  if (!params_.cache_direct)
    throw Error(fmt::format("irradiance-cache: fill = {} holds all light; expected cache_direct = true", fill));
  if (params_.caustic_map == CausticMap::on)
    throw Error(fmt::format("irradiance-cache: fill = {} holds all light; caustic_map = on would count caustics twice", fill));
  settings.at_point = [&context](const CachePoint& point, int) { return closed_form_irradiance(context, point); };
  settings.judges_by_rays = !by_closed_form_;
  if (settings.judges_by_rays) return;
  const CacheMetric metric = params_.metric;
  if (metric == CacheMetric::geometric_hessian || metric == CacheMetric::tabellion || metric == CacheMetric::split_sphere)
    throw Error(
        fmt::format("irradiance-cache: fill = closed-form has no hemispheres, by which metric = {} judges", name_of(metric)));
}

FileCache::Identity IrradianceCache::identity() const {
  // With a given number of records, `accuracy` is where the search for it began, so it must agree.
  const std::string_view free_accuracy = params_.records > 0 ? "structure" : "accuracy";
  Identity own{
      "irradiance-cache", {}, {free_accuracy, "caustic_photons", "extra_samples", "lobe_samples", "refine", "structure"}, 2};
  own.params = extension_ ? extension_->params : param_texts(params_);
  if (extension_) own.integrator = extension_->integrator;
  own.params["caustic_map"] = name_of(params_.caustic_map);
  return own;
}

void IrradianceCache::refine(RenderContext& context, std::uint32_t index) {
  if (caustics_ && index > 0) caustics_->trace(context, round_of(index));
  if (!params_.refine) return;
  const auto timed = context.phases.measure("initial_pass");
  refine_records(context, false, progress_.passes_at(stage(), standing_.spacing()));
}

// Adds the light that a cached surface reflects by its records; false where none covers it.
bool IrradianceCache::add_irradiance(const RenderContext& context, const Visit& at, float next_accuracy,
                                     CameraSample& out) const {
  const vec3 normal = towards(at.point.shading_normal, at.point.normal, at.wo);
  const auto record = cache_->interpolate(at.depth, at.point.position, normal, out.states_error);
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
bool IrradianceCache::add_rough(const RenderContext& context, const Visit& at, float next_accuracy, CameraSample& out) const {
  const auto reflected = rough_->reflected(at.point, at.bsdf, at.wo, at.depth, out.sampler, out.states_error);
  if (reflected) {
    out.cached += at.throughput * reflected->radiance;
    out.cached_error += luminance(at.throughput) * reflected->standard_error;
  }
  if (!out.wanted_rough && !(reflected && reflected->error < next_accuracy))
    out.wanted_rough = cache_point(context, at.point, at.wo, at.distance, at.depth);
  return reflected.has_value();
}

void IrradianceCache::camera_samples(const RenderContext& context, float next_accuracy, std::span<CameraSample> samples) const {
  static thread_local Wavefront<CameraPath> wave;  // for its memory
  wave.clear();
  for (CameraSample& sample : samples) {
    const Ray ray = by_closed_form_ && !context.scene.filter
                        ? context.scene.camera.ray(context.resolution, vec2(sample.pixel) + 0.5f, vec2(0.5f))
                        : sample_camera_ray(context, sample.pixel, sample.sampler);
    wave.start(CameraPath(sample), ray);
  }
  wave.run(context, 0, [&](CameraPath& path, Ray& ray, const SurfacePoint* point, int depth) {
    return meet(context, next_accuracy, path, ray, point, depth, wave);
  });
}

// Handles what a camera path does where its ray ends; answers whether it goes on.
bool IrradianceCache::meet(const RenderContext& context, float next_accuracy, CameraPath& path, Ray& ray,
                           const SurfacePoint* met, int depth, Wavefront<CameraPath>& wave) const {
  CameraSample& out = *path.sample;
  if (path.count_emission && !path.chain.holds_emission())
    *path.met_light += path.throughput * emitted_with_mis(context, ray, met, path.pdf_bsdf);
  if (met == nullptr || depth >= max_depth_ || path.only_emission) return false;

  const SurfacePoint& point = *met;
  const vec3 wo = -ray.direction;
  path.distance += glm::length(point.position - ray.origin);
  const Bsdf bsdf(context.scene, point);
  const bool cached = is_cached(bsdf);
  // Light samples at a cached surface: all of its direct light, or only that of lights no ray can find.
  const MisMode mode = !cached ? MisMode::power : params_.cache_direct ? MisMode::bsdf : direct_;
  if (const auto light = sample_direct_light(context, point, bsdf, wo, out.sampler, mode))
    wave.gain({path.found_light, path.throughput * light->radiance}, light->shadow_ray);
  if (cached && mode == MisMode::power)
    *path.found_light += path.throughput * met_by_bsdf(context, point, bsdf, wo, out.sampler);
  if (caustics_ && caustics_->gathers_at(point.material))
    *path.found_light += path.throughput * caustics_->reflected(context, point, bsdf, wo, depth);
  path.met_light = path.found_light;
  const Visit visit{point, bsdf, wo, depth, path.distance, path.throughput};
  const bool has_records = depth < cached_below_ && takes_records(point, wo);
  const bool found = cached && has_records && add_irradiance(context, visit, next_accuracy, out);
  if (found && !bsdf.has_specular()) return false;
  bool rough_misses = false;
  if (rough_ && rough_->answers(point.material) && has_records) {
    // From here on the BSDF's sample finds lights alone, which are MIS-weighted with the light sample.
    path.only_emission = add_rough(context, visit, next_accuracy, out);
    rough_misses = !path.only_emission;
  }

  const float u_lobe = out.sampler.get_1d();
  const BsdfSample scattered = bsdf.sample(wo, u_lobe, out.sampler.get_2d());
  if (!scattered || is_black(scattered.weight) || (found && !scattered.specular)) return false;
  if (cached && !scattered.specular && has_records) path.found_light = path.met_light = &out.cached;
  if (rough_misses) path.found_light = &out.cached;
  // A cached surface has had all of its direct light from the light sample, or none.
  path.count_emission = !cached || scattered.specular || params_.cache_direct;
  path.chain.leave(caustics_.get(), point.material, scattered.specular, scattered.pdf_solid_angle);
  path.throughput *= scattered.weight;
  if (scattered.transmitted) path.eta_scale *= scattered.eta * scattered.eta;
  path.pdf_bsdf = cached ? 0 : scattered.pdf_solid_angle;
  ray = spawn_ray(point, scattered.wi);
  return depth + 1 < roulette_depth ||
         survives_roulette(path.throughput, survival_of(path.throughput, path.eta_scale), out.sampler);
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
  return integrator_entry<IrradianceCacheParams>(
      "irradiance-cache", "irradiance caching with rotation and translation gradients",
      [](const IrradianceCacheParams& p) { return make_irradiance_cache(p); }, 350);
}

}  // namespace etendue
