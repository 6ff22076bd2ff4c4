#include "integrators/irradiance_cache.h"

#include "framework/core/counters.h"
#include "framework/core/parallel.h"
#include "framework/transport/fresnel.h"
#include "framework/transport/ray_tools.h"
#include "integrators/emission.h"
#include "integrators/irradiance_records.h"
#include "integrators/path.h"

namespace etendue {

namespace {

constexpr int roulette_depth = 5, shared_above = 16, coarsest_grid = 64;
constexpr std::size_t batch_size = 64;
constexpr int path_batch = 2048;  // paths traced together: as many rays at once as still pays

// A cached surface that a pixel's centre sees.
struct VisiblePoint {
  vec3 position{0};
  vec3 normal{0}, geometric{0};  // both on the side that is seen
  float pixel_width = 0;         // metres per pixel, there
  int depth = -1;                // carrying events before it; -1: nothing to cache is seen
};

// Diffuse, or a diffuse base under a smooth coat.
bool is_cached(const Bsdf& bsdf) { return bsdf.is_diffuse() || (bsdf.has_specular() && bsdf.has_non_specular()); }

vec3 towards(const vec3& normal, const vec3& side, const vec3& wo) { return glm::dot(side, wo) < 0 ? -normal : normal; }

class IrradianceCache final : public Integrator {
 public:
  explicit IrradianceCache(const IrradianceCacheParams& params) : params_(params), sampler_(parse_sampler(params.sampler)) {}

  void prepare(RenderContext& context) override;
  void iteration(RenderContext& context, std::uint32_t index, Film& film) override;
  Expectation expectation() const override;

 private:
  std::size_t level(int depth) const { return max_depth_ > shared_above ? 0 : static_cast<std::size_t>(depth); }
  template <class Wanted>
  void fill(const RenderContext& context, const std::vector<VisiblePoint>& seen, const Wanted& wanted);
  VisiblePoint find_visible(const RenderContext& context, ivec2 pixel) const;
  IrradianceRecord compute_record(const RenderContext& context, const VisiblePoint& point, std::uint64_t key) const;
  Rgb camera_radiance(const RenderContext& context, Ray ray, Sampler& sampler) const;
  Rgb base_reflectance(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo) const;

  IrradianceCacheParams params_;
  SamplerKind sampler_;
  Gradients gradients_ = Gradients::both;
  HemisphereStrata strata_;
  int max_depth_ = 0;
  float max_spacing_ = 0;
  std::vector<IrradianceRecords> levels_;
};

void IrradianceCache::prepare(RenderContext& context) {
  const auto timed = context.phases.measure("prefill");
  max_depth_ = context.max_depth(params_.max_depth);
  gradients_ = params_.gradients == "none"       ? Gradients::none
               : params_.gradients == "rotation" ? Gradients::rotation
                                                 : Gradients::both;
  strata_ = HemisphereStrata::of(params_.samples);

  const ivec2 size = context.resolution;
  std::vector<VisiblePoint> seen(static_cast<std::size_t>(size.x) * size.y);
  parallel_pixels(
      size, [&](ivec2 pixel) { seen[static_cast<std::size_t>(pixel.y) * size.x + pixel.x] = find_visible(context, pixel); });
  Bounds bounds;
  int deepest = -1;
  for (const VisiblePoint& point : seen) {
    if (point.depth < 0) continue;
    bounds.extend(point.position);
    deepest = std::max(deepest, static_cast<int>(level(point.depth)));
  }
  levels_.clear();
  if (deepest < 0) return;
  Bounds whole = context.scene.bounds();
  if (whole.empty()) whole = bounds;
  max_spacing_ = params_.max_spacing * glm::length(whole.diagonal());
  for (int i = 0; i <= deepest; ++i)
    levels_.emplace_back(context.make_balls(params_.structure, bounds), params_.accuracy, params_.neighbour_clamping);

  // Every step-th pixel, but for those that the coarser pass has been to.
  for (int step = coarsest_grid; step >= 1; step /= 2)
    fill(context, seen, [=](int x, int y) {
      return x % step == 0 && y % step == 0 && (step == coarsest_grid || x % (2 * step) != 0 || y % (2 * step) != 0);
    });
  if (params_.neighbour_clamping) fill(context, seen, [](int, int) { return true; });
}

// Covers the points of the pixels for which wanted(x, y), where no record covers them yet.
template <class Wanted>
void IrradianceCache::fill(const RenderContext& context, const std::vector<VisiblePoint>& seen, const Wanted& wanted) {
  const auto covered = [&](std::size_t pixel) {
    const VisiblePoint& point = seen[pixel];
    return point.depth < 0 || levels_[level(point.depth)].covered(point.position, point.normal);
  };
  const auto width = static_cast<std::size_t>(context.resolution.x);
  std::vector<std::uint8_t> open(seen.size());
  parallel_for(seen.size(), 1024, [&](std::size_t i) {
    open[i] = wanted(static_cast<int>(i % width), static_cast<int>(i / width)) && !covered(i);
  });
  std::vector<std::pair<std::uint64_t, std::uint32_t>> queue;
  for (std::uint32_t i = 0; i < seen.size(); ++i)
    if (open[i]) queue.emplace_back(mix_bits(i), i);
  std::sort(queue.begin(), queue.end());

  std::vector<std::uint32_t> batch;
  std::vector<IrradianceRecord> records(batch_size);
  for (std::size_t next = 0; next < queue.size();) {
    batch.clear();
    for (; next < queue.size() && batch.size() < batch_size; ++next)
      if (!covered(queue[next].second)) batch.push_back(queue[next].second);
    parallel_for(batch.size(), 1, [&](std::size_t i) { records[i] = compute_record(context, seen[batch[i]], batch[i]); });
    for (std::size_t i = 0; i < batch.size(); ++i) levels_[level(seen[batch[i]].depth)].insert(records[i]);
    count(Counter::records, batch.size());
  }
}

// Follows the pixel's centre to a cached surface at which light may scatter once more.
VisiblePoint IrradianceCache::find_visible(const RenderContext& context, ivec2 pixel) const {
  const auto key = static_cast<std::uint64_t>(pixel.y) * context.resolution.x + pixel.x;
  Sampler sampler(sampler_, context.seed, Stream::prefill, key, 0);
  const vec2 lens = context.needs.thin_lens ? sampler.get_2d() : vec2(0.5f);
  Ray ray = context.scene.camera.ray(context.resolution, vec2(pixel) + 0.5f, lens);
  float distance = 0;
  for (int depth = 0; depth + 1 < max_depth_; ++depth) {
    const Hit hit = trace(context, ray);
    if (!hit) break;
    const SurfacePoint point = context.scene.surface_at(ray, hit);
    const vec3 wo = -ray.direction;
    distance += glm::length(point.position - ray.origin);
    const Bsdf bsdf(context.scene, point);
    if (is_cached(bsdf)) {
      const float pixel_width =
          2 * context.scene.camera.half_extent(context.resolution).x / static_cast<float>(context.resolution.x);
      return {point.position, towards(point.shading_normal, point.normal, wo), towards(point.normal, point.normal, wo),
              distance * pixel_width, depth};
    }
    const float u_lobe = sampler.get_1d();
    const BsdfSample scattered = bsdf.sample(wo, u_lobe, sampler.get_2d());
    if (!scattered) break;
    ray = spawn_ray(point, scattered.wi);
  }
  return {};
}

// Indirect irradiance: all light but that which arrives straight from a light.
IrradianceRecord IrradianceCache::compute_record(const RenderContext& context, const VisiblePoint& point,
                                                 std::uint64_t key) const {
  static thread_local std::vector<HemisphereSample> samples;
  static thread_local std::vector<PathSample> paths;
  static thread_local std::vector<int> strata;  // of the paths
  samples.assign(static_cast<std::size_t>(strata_.count()), {});
  const Frame frame = Frame::from_normal(point.normal);
  const PathSettings settings{max_depth_, roulette_depth, MisMode::power};
  const vec3 origin = offset_origin(point.position, point.geometric);
  const int depth = (level(point.depth) == 0 ? 0 : point.depth) + 1;
  for (int first = 0; first < strata_.count(); first += path_batch) {
    paths.clear();
    strata.clear();
    for (int i = first; i < std::min(first + path_batch, strata_.count()); ++i) {
      Sampler sampler(sampler_, context.seed, Stream::cache_record, key, static_cast<std::uint32_t>(i));
      const vec3 direction = frame.to_world(strata_.direction(i, sampler.get_2d()));
      if (glm::dot(direction, point.geometric) <= 0) continue;  // below the surface, where shading normals disagree
      paths.push_back({Ray{.origin = origin, .direction = direction}, sampler});
      strata.push_back(i);
    }
    trace_paths(context, paths, depth, settings, false);
    for (std::size_t i = 0; i < paths.size(); ++i) samples[strata[i]] = {paths[i].radiance, paths[i].first_distance};
  }
  return make_record(point.position, point.normal, estimate_irradiance(strata_, samples, frame), gradients_, params_.accuracy,
                     std::max(params_.min_spacing * point.pixel_width, 1e-6f * max_spacing_), max_spacing_);
}

void IrradianceCache::iteration(RenderContext& context, std::uint32_t index, Film& film) {
  const auto timed = context.phases.measure("gather");
  parallel_pixels(context.resolution, [&](ivec2 pixel) {
    const auto key = static_cast<std::uint64_t>(pixel.y) * context.resolution.x + pixel.x;
    Sampler sampler(sampler_, context.seed, Stream::camera, key, index);
    const Ray ray = sample_camera_ray(context, pixel, sampler);
    film.add(pixel, camera_radiance(context, ray, sampler), index);
  });
}

Rgb IrradianceCache::camera_radiance(const RenderContext& context, Ray ray, Sampler& sampler) const {
  Rgb radiance(0), throughput(1);
  float eta_scale = 1, pdf_bsdf = 0;
  bool count_emission = true;
  for (int depth = 0;; ++depth) {
    const Hit hit = trace(context, ray);
    if (!hit) {
      if (count_emission) radiance += throughput * met_emission(context, ray, nullptr, pdf_bsdf);
      return radiance;
    }
    const SurfacePoint point = context.scene.surface_at(ray, hit);
    if (count_emission) radiance += throughput * met_emission(context, ray, &point, pdf_bsdf);
    if (depth >= max_depth_) return radiance;

    const vec3 wo = -ray.direction;
    const Bsdf bsdf(context.scene, point);
    const bool cached = is_cached(bsdf);
    radiance += throughput * direct_light(context, point, bsdf, wo, sampler, cached ? MisMode::light : MisMode::power);
    bool found = false;
    if (cached && depth + 1 < max_depth_ && level(depth) < levels_.size()) {
      count(Counter::lookups);
      if (const auto irradiance =
              levels_[level(depth)].interpolate(point.position, towards(point.shading_normal, point.normal, wo))) {
        radiance += throughput * base_reflectance(context, point, bsdf, wo) * *irradiance * inv_pi;
        found = true;
      }
    }
    if (found && !bsdf.has_specular()) return radiance;

    const float u_lobe = sampler.get_1d();
    const BsdfSample scattered = bsdf.sample(wo, u_lobe, sampler.get_2d());
    if (!scattered || (found && !scattered.specular)) return radiance;
    // A cached surface has had all of its direct light from the light sample.
    count_emission = !cached || scattered.specular;
    throughput *= scattered.weight;
    if (scattered.transmitted) eta_scale *= scattered.eta * scattered.eta;
    pdf_bsdf = scattered.pdf_solid_angle;
    ray = spawn_ray(point, scattered.wi);
    if (depth + 1 >= roulette_depth) {
      const float survival = std::min(0.95f, max_component(throughput) * eta_scale);
      if (!(sampler.get_1d() < survival)) return radiance;
      throughput /= survival;
    }
  }
}

// What the diffuse part reflects of uniform light towards wo. A coated base, f = g T(wo) T(wi) / pi, is evaluated along the
// normal and T(wi) replaced by its cosine-weighted mean.
Rgb IrradianceCache::base_reflectance(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf,
                                      const vec3& wo) const {
  if (bsdf.is_diffuse()) return bsdf.diffuse_albedo();
  const float eta = std::get<Plastic>(context.scene.materials[point.material]).eta;
  const vec3 normal = towards(point.shading_normal, point.normal, wo);
  return pi * bsdf.evaluate(wo, normal) * ((1 - fresnel_average(eta)) / (1 - fresnel_dielectric(1, eta)));
}

Expectation IrradianceCache::expectation() const {
  return {Bias::biased, -1, 0.05, "interpolation within the accuracy a, and the records' own noise [Ward1988]"};
}

}  // namespace

IntegratorEntry irradiance_cache_entry() {
  return {"irradiance-cache", "irradiance caching with rotation and translation gradients",
          list_params<IrradianceCacheParams>(), [](const ParamMap& map) {
            return std::make_unique<IrradianceCache>(read_params<IrradianceCacheParams>(map, "irradiance-cache"));
          }};
}

}  // namespace etendue
