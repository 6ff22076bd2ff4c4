#include "integrators/photons/photon_map.h"

#include "framework/core/parallel.h"

namespace etendue {

namespace {

// The state of one camera sample.
struct CameraSample {
  std::uint64_t pixel;
  std::uint32_t iteration;
  Sampler sampler;
};

class PhotonMapping final : public Integrator {
 public:
  explicit PhotonMapping(const PhotonMapParams& params);

  void prepare(RenderContext& context) override;
  void iteration(RenderContext& context, std::uint32_t index, Film& film) override;
  Expectation expectation() const override { return expected_; }

 private:
  void trace_maps(RenderContext& context, std::uint32_t pass);
  PhotonCameraPath walk(const RenderContext& context) const { return {context, maps_.rough_materials(), max_depth_}; }
  Rgb camera_radiance(const RenderContext& context, const Ray& ray, CameraSample& sample) const;
  Rgb reflected(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, int depth,
                CameraSample& sample) const;

  PhotonMapParams params_;
  Expectation expected_;
  int max_depth_ = 0;
  PhotonMaps maps_;
  DirectShares direct_;
};

PhotonMapping::PhotonMapping(const PhotonMapParams& params)
    : params_(params),
      expected_{Bias::biased, -1, 0.05,
                params.retrace ? "blur by the kernel's radius and loss at edges [Jensen2001]; the maps' variance averages out"
                               : "blur by the kernel's radius, loss at edges, and the one map's own noise [Jensen2001]"},
      maps_(params, "photon-map") {}

void PhotonMapping::prepare(RenderContext& context) {
  context.choose_lights_by(params_.lights);
  max_depth_ = context.max_depth(params_.max_depth);
  maps_.prepare(context, {params_.final_gather, max_depth_, params_.sampler});
  expected_ = expectation_in(context, maps_.rough_materials(), std::move(expected_));
  direct_ = {walk(context), params_.sampler, params_.further_paths, true};
  trace_maps(context, 0);
}

void PhotonMapping::trace_maps(RenderContext& context, std::uint32_t pass) {
  maps_.trace_global(context, pass);
  maps_.trace_caustics(context, pass);
}

void PhotonMapping::iteration(RenderContext& context, std::uint32_t index, Film& film) {
  if (params_.retrace && index > 0) trace_maps(context, index);
  const auto timed = context.phases.measure("gather");
  parallel_tiles(context.resolution, tile_size, [&](const Tile& tile) {
    for_pixels(context.seen(tile), [&](ivec2 pixel) {
      const auto key = pixel_index(pixel, context.resolution);
      CameraSample sample{key, index, Sampler(params_.sampler, context.seed, Stream::camera, key, index)};
      const Ray ray = sample_camera_ray(context, pixel, sample.sampler);
      const Rgb radiance = camera_radiance(context, ray, sample) + direct_.further(walk(context), pixel, index);
      film.add(pixel, radiance, index, sample_weight(context, pixel, index));
    });
  });
}

Rgb PhotonMapping::camera_radiance(const RenderContext& context, const Ray& ray, CameraSample& sample) const {
  Rgb reflected_direct(0), seen(0);
  const Rgb met = walk(context)(
      ray, sample.sampler, sample.sampler,
      [&](const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, const Rgb& throughput, int depth, float) {
        reflected_direct += throughput * all_direct_light(context, point, bsdf, wo, sample.sampler, direct_.mode());
        seen += throughput * reflected(context, point, bsdf, wo, depth, sample);
      });
  return direct_.share(sample.pixel) * (met + reflected_direct) + seen;
}

// The radiance that a rough vertex reflects of all but direct light, seen by a camera path with `depth` events before this one.
Rgb PhotonMapping::reflected(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo,
                             int depth, CameraSample& sample) const {
  const int remaining = max_depth_ - depth - 1;
  const Rgb radiance = maps_.caustics(context, point, bsdf, wo, remaining);
  if (params_.final_gather == 0) return radiance + maps_.seen_directly(context, point, bsdf, wo, remaining);
  if (remaining < 1) return radiance;
  const FinalGather gather = maps_.gather(context, params_.final_gather, params_.gather_sampling == GatherSampling::photons);
  return radiance + gather(point, bsdf, wo, depth, sample.pixel, sample.iteration);
}

}  // namespace

IntegratorEntry photon_map_entry() {
  return integrator_entry<PhotonMapping, PhotonMapParams>(
      "photon-map", "photon mapping with a caustic map where one is needed, and optional final gathering");
}

}  // namespace etendue
