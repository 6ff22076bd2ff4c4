#include "integrators/photons/photon_map.h"

#include "framework/core/parallel.h"
#include "integrators/photons/kernel_domain.h"

#include <fmt/format.h>

#include <numeric>
#include <optional>

namespace etendue {

namespace {

constexpr double usual_bias = 0.05;  // of the image's mean

// The state of one camera sample.
struct CameraSample {
  std::uint64_t pixel;
  std::uint32_t iteration;
  Sampler sampler;
};

void leave_out(Expectation& expected, const std::string& what) {
  if (!expected.left_out.empty()) expected.left_out += "; ";
  expected.left_out += what;
}

class PhotonMapping final : public Integrator {
 public:
  explicit PhotonMapping(const PhotonMapParams& params);

  void prepare(RenderContext& context) override;
  void iteration(RenderContext& context, std::uint32_t index, Film& film) override;
  Expectation expectation() const override;

 private:
  void trace_maps(RenderContext& context, std::uint32_t pass);
  double lost_at_edges(const RenderContext& context) const;
  void expect_loss(double lost);
  PhotonCameraPath walk(const RenderContext& context) const { return {context, maps_.rough_materials(), max_depth_}; }
  Rgb camera_radiance(const RenderContext& context, const Ray& ray, CameraSample& sample) const;
  Rgb reflected(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, int depth,
                CameraSample& sample) const;

  PhotonMapParams params_;
  Expectation expected_;
  std::optional<bool> landed_;  // photons of any pass on what is seen; empty: none was traced, or nothing shines
  int max_depth_ = 0;
  PhotonMaps maps_;
  DirectShares direct_;
};

PhotonMapping::PhotonMapping(const PhotonMapParams& params)
    : params_(params),
      expected_{Bias::biased, -1, usual_bias,
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
  if (params_.final_gather == 0 && params_.edges == Edges::disc) expect_loss(lost_at_edges(context));
}

// The share of the image's light that discs of the map seen lose where they are partly off the surface, by a few camera paths.
double PhotonMapping::lost_at_edges(const RenderContext& context) const {
  constexpr int lines = 16;
  const auto timed = context.phases.measure("pilot");
  std::vector<double> lost(lines * lines), whole(lost.size());
  parallel_for(lost.size(), 8, [&](std::size_t i) {
    const ivec2 pixel = grid_pixel(context.resolution, lines, static_cast<int>(i));
    PathSample path = camera_path(context, pixel, SamplerKind::independent, no_images_path);
    const auto add = [&](const Rgb& light, float share) {
      if (!is_finite(light)) return;
      whole[i] += luminance(light) / share;
      lost[i] += luminance(light) * (1 / share - 1);
    };
    const Rgb met = walk(context)(
        path.ray, path.sampler, path.sampler,
        [&](const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, const Rgb& throughput, int depth, float) {
          const GatherPoint at(point, bsdf, wo, photon_any, max_depth_ - depth - 1);
          const PhotonMap::Estimate seen = maps_.global().measure(context, at);
          add(throughput * all_direct_light(context, point, bsdf, wo, path.sampler, direct_.mode()), 1);
          if (!(seen.radius > 0)) return;
          const vec3 normal = glm::dot(point.normal, wo) < 0 ? -point.normal : point.normal;
          // Where hardly any of a disc is on the surface, what it holds came from elsewhere and tells little.
          const float share = VisibleDomain(context, point.position, normal, seen.radius).share(params_.kernel);
          add(throughput * seen.radiance, std::max(share, 0.1f));
        });
    add(met, 1);
  });
  const double all = std::accumulate(whole.begin(), whole.end(), 0.0);
  return all > 0 ? std::accumulate(lost.begin(), lost.end(), 0.0) / all : 0;
}

void PhotonMapping::expect_loss(double lost) {
  if (lost <= usual_bias) return;
  expected_.bias_bound = std::max(expected_.bias_bound, std::min(1.0, 2 * lost));
  leave_out(expected_, fmt::format("kernels reach beyond edges and corners, where about {:.0f} % of the light is lost; "
                                   "edges = \"visible\" keeps it, and more photons lose less",
                                   100 * lost));
}

// By visibility photons are led where others landed before: where none did in any pass, none is.
Expectation PhotonMapping::expectation() const {
  Expectation told = expected_;
  if (params_.emission == PhotonEmission::visibility && landed_ == false) {
    told.bias_bound = 1;
    leave_out(told, "no photon found a way to what is seen, so that none was led there: light that photons bring is left out");
  }
  return told;
}

void PhotonMapping::trace_maps(RenderContext& context, std::uint32_t pass) {
  maps_.trace_global(context, pass);
  maps_.trace_caustics(context, pass);
  if (!context.lights.empty()) landed_ = landed_.value_or(false) || !maps_.empty();
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
