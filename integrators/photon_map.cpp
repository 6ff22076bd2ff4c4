#include "integrators/photon_map.h"

#include "framework/core/parallel.h"
#include "integrators/camera_walk.h"
#include "integrators/final_gather.h"
#include "integrators/path.h"
#include "integrators/photon_gather.h"
#include "integrators/visible_region.h"

namespace etendue {

namespace {

// What one camera sample carries along.
struct CameraSample {
  std::uint64_t pixel;
  std::uint32_t iteration;
  Sampler sampler;
};

class PhotonMapping final : public Integrator {
 public:
  explicit PhotonMapping(const PhotonMapParams& params)
      : params_(params), sampler_(parse_sampler(params.sampler)), emission_(parse_emission(params.emission)) {
    if (params.k == 1) throw Error("photon-map: k = 1: expected 0 (fixed radius) or at least 2");
  }

  void prepare(RenderContext& context) override;
  void iteration(RenderContext& context, std::uint32_t index, Film& film) override;
  Expectation expectation() const override;

 private:
  void mark_seen(RenderContext& context);
  void trace_maps(RenderContext& context, std::uint32_t pass);
  Rgb camera_radiance(const RenderContext& context, const Ray& ray, CameraSample& sample) const;
  Rgb reflected(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, int depth,
                CameraSample& sample) const;

  PhotonMapParams params_;
  SamplerKind sampler_;
  int max_depth_ = 0;
  bool separate_caustics_ = false;
  PhotonHistory global_seen_ = photon_any;  // histories the global map answers for where it is seen directly
  std::unique_ptr<Receivers> receivers_;
  PhotonMap global_, caustic_;
  std::unique_ptr<PhotonIrradiance> irradiance_;  // of the global map, for gather rays
  PhotonEmission emission_;
  float largest_radius_ = infinity;
  std::unique_ptr<VisibleRegion> seen_, gathered_;  // by camera paths, and by gather rays; null where not needed
};

void PhotonMapping::prepare(RenderContext& context) {
  max_depth_ = context.max_depth(params_.max_depth);
  receivers_ = std::make_unique<Receivers>(context.scene, params_.carry_below);
  separate_caustics_ = params_.caustic_map == "on" ||
                       (params_.caustic_map == "auto" && (context.needs.caustic_map || receivers_->narrow_lobes()));
  global_seen_ = separate_caustics_ ? photon_indirect : photon_indirect | photon_caustic;
  if (emission_ != PhotonEmission::power) mark_seen(context);
  trace_maps(context, 0);
}

void PhotonMapping::mark_seen(RenderContext& context) {
  const auto timed = context.phases.measure("prefill");
  const SeenOptions options{4, max_depth_, sampler_, params_.side_test};
  // Twice what k photons need of the area seen if half of those emitted reach it, as densities differ; for gather rays, a
  // fiftieth of the scene.
  const float whole = 0.02f * glm::length(context.scene.bounds().diagonal());
  const double area = seen_area(context, *receivers_, options);
  const double photons = 0.5 * std::min(params_.photons, separate_caustics_ ? params_.caustic_photons : params_.photons);
  const double needed = 2 * std::sqrt((params_.k > 0 ? params_.k : 50) * area / (std::numbers::pi * photons));
  const bool gathers = params_.final_gather > 0;
  const float reach = params_.radius > 0 ? params_.radius
                      : gathers          ? whole
                                         : std::clamp(static_cast<float>(needed), 1e-3f * whole, whole);
  // Half as much again, for what lies between the samples of a pixel.
  seen_ = find_seen(context, *receivers_, options, 1.5f * reach);
  if (gathers) gathered_ = find_seen(context, *receivers_, options, 1.5f * reach, std::min(params_.final_gather, 16));
  if (emission_ == PhotonEmission::visibility) largest_radius_ = reach;  // beyond it there may be no photons
}

void PhotonMapping::trace_maps(RenderContext& context, std::uint32_t pass) {
  const auto make = [&](PhotonMap& map, int count, std::uint64_t key, int max_scatterings, PhotonHistory keep,
                        const VisibleRegion* visible, Edges edges) {
    Photons photons;
    {
      const auto timed = context.phases.measure("emit");
      photons = trace_photons(
          context, *receivers_,
          {static_cast<std::uint32_t>(count), hash_keys(key, pass), max_scatterings, keep, sampler_, emission_, visible});
    }
    const auto timed = context.phases.measure("build");
    map.build(std::move(photons), context.make_points(params_.structure),
              {params_.k, params_.radius, kernel_from_name(params_.kernel), params_.side_test, largest_radius_, edges});
  };
  // The event at which a photon is gathered counts too, and so does the one at the visible point before a gather ray.
  const bool gathers = params_.final_gather > 0;
  const Edges edges = parse_edges(params_.edges);
  make(global_, params_.photons, 0, max_depth_ - (gathers && separate_caustics_ ? 2 : 1), gathers ? photon_any : global_seen_,
       gathered_ ? gathered_.get() : seen_.get(), edges);
  if (gathers && params_.precompute > 0) {
    const auto timed = context.phases.measure("build");
    irradiance_ =
        std::make_unique<PhotonIrradiance>(context, global_, params_.precompute, context.make_points(params_.structure));
  }
  if (separate_caustics_)
    make(caustic_, params_.caustic_photons, 1, max_depth_ - 1, photon_caustic, seen_.get(),
         edges == Edges::hull ? Edges::disc : edges);
}

void PhotonMapping::iteration(RenderContext& context, std::uint32_t index, Film& film) {
  if (params_.retrace && index > 0) trace_maps(context, index);
  const auto timed = context.phases.measure("gather");
  parallel_pixels(context.resolution, [&](ivec2 pixel) {
    const auto key = static_cast<std::uint64_t>(pixel.y) * context.resolution.x + pixel.x;
    CameraSample sample{key, index, Sampler(sampler_, context.seed, Stream::camera, key, index)};
    const Ray ray = sample_camera_ray(context, pixel, sample.sampler);
    film.add(pixel, camera_radiance(context, ray, sample), index);
  });
}

Rgb PhotonMapping::camera_radiance(const RenderContext& context, const Ray& ray, CameraSample& sample) const {
  Rgb seen(0);
  const Rgb met = CameraWalk{context, *receivers_, max_depth_}(
      ray, sample.sampler, sample.sampler,
      [&](const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, const Rgb& throughput, int depth) {
        seen += throughput * reflected(context, point, bsdf, wo, depth, sample);
      });
  return met + seen;
}

// What a receiver reflects by events that diffuse, seen by a camera path with `depth` events before this one.
Rgb PhotonMapping::reflected(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo,
                             int depth, CameraSample& sample) const {
  const int remaining = max_depth_ - depth - 1;
  Rgb radiance = direct_light(context, point, bsdf, wo, sample.sampler, MisMode::light);
  if (separate_caustics_) radiance += caustic_.radiance(context, point, bsdf, wo, photon_caustic, remaining);
  if (params_.final_gather == 0) return radiance + global_.radiance(context, point, bsdf, wo, global_seen_, remaining);
  if (!separate_caustics_) radiance += global_.radiance(context, point, bsdf, wo, photon_caustic, remaining);
  if (remaining < 1) return radiance;

  const FinalGather gather{
      context, *receivers_, global_, irradiance_.get(), params_.final_gather, max_depth_, params_.gather_sampling == "photons",
      sampler_};
  return radiance + gather(point, bsdf, wo, depth, sample.pixel, sample.iteration);
}

Expectation PhotonMapping::expectation() const {
  return {Bias::biased, -1, 0.05,
          params_.retrace ? "blur by the kernel's radius and loss at edges [Jensen2001]; the maps' variance averages out"
                          : "blur by the kernel's radius, loss at edges, and the one map's own noise [Jensen2001]"};
}

}  // namespace

IntegratorEntry photon_map_entry() {
  return {"photon-map", "photon mapping with a caustic map where one is needed, and optional final gathering",
          list_params<PhotonMapParams>(),
          [](const ParamMap& map) { return std::make_unique<PhotonMapping>(read_params<PhotonMapParams>(map, "photon-map")); }};
}

}  // namespace etendue
