#include "integrators/radiance_cache.h"

#include "framework/core/parallel.h"
#include "framework/transport/ray_tools.h"
#include "integrators/cache_points.h"
#include "integrators/emission.h"
#include "integrators/path.h"
#include "integrators/radiance_cache_records.h"
#include "integrators/spherical_harmonics.h"

namespace etendue {

namespace {

constexpr int roulette_depth = 5, coarsest_grid = 64, path_batch = 2048;
constexpr std::size_t batch_size = 64;

struct SeenPoint {
  vec3 position{0};
  vec3 normal{0}, geometric{0};  // both on the side that is seen
  float pixel_width = 0;         // metres per pixel, there
  int depth = -1;                // events before it; -1: nothing to cache is seen
};

class RadianceCache final : public Integrator {
 public:
  explicit RadianceCache(const RadianceCacheParams& params) : params_(params), sampler_(parse_sampler(params.sampler)) {}

  void prepare(RenderContext& context) override;
  void iteration(RenderContext& context, std::uint32_t index, Film& film) override;
  Expectation expectation() const override {
    return {Bias::biased, -1, 0.05, "interpolation, the records' own noise, and the order of the harmonics [Krivanek2005]"};
  }
  std::optional<std::vector<RecordDisc>> record_discs() const override {
    std::vector<RecordDisc> discs;
    for (const RadianceRecords& level : levels_) level.add_discs(discs);
    return discs;
  }

 private:
  std::size_t level(int depth) const { return max_depth_ > shared_above ? 0 : static_cast<std::size_t>(depth); }
  bool is_cached(const RenderContext& context, const SurfacePoint& point) const;
  SeenPoint find_seen(const RenderContext& context, ivec2 pixel) const;
  template <class Wanted>
  void fill(const RenderContext& context, const Wanted& wanted);
  RadianceEstimate sample_hemisphere(const RenderContext& context, const SeenPoint& point, std::uint64_t key) const;
  std::optional<Rgb> indirect(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, int depth, Sampler& sampler) const;
  Rgb camera_radiance(const RenderContext& context, Ray ray, Sampler& sampler) const;

  RadianceCacheParams params_;
  SamplerKind sampler_;
  HemisphereStrata strata_;
  int max_depth_ = 0;
  float max_spacing_ = 0;
  std::vector<SeenPoint> seen_;
  std::vector<RadianceRecords> levels_;
};

bool RadianceCache::is_cached(const RenderContext& context, const SurfacePoint& point) const {
  const Material& material = context.scene.materials[point.material];
  if (std::holds_alternative<Diffuse>(material)) return true;
  float alpha = 0;
  if (const auto* m = std::get_if<Conductor>(&material)) alpha = std::min(m->alpha.x, m->alpha.y);
  if (const auto* m = std::get_if<Plastic>(&material)) alpha = m->alpha;
  return alpha > 0 && alpha >= params_.roughness;
}

void RadianceCache::prepare(RenderContext& context) {
  const auto timed = context.phases.measure("prefill");
  max_depth_ = context.max_depth(params_.max_depth);
  strata_ = HemisphereStrata::of(params_.samples);
  const ivec2 size = context.resolution;
  seen_.assign(static_cast<std::size_t>(size.x) * size.y, {});
  parallel_pixels(
      size, [&](ivec2 pixel) { seen_[static_cast<std::size_t>(pixel.y) * size.x + pixel.x] = find_seen(context, pixel); });
  Bounds bounds;
  int deepest = -1;
  for (const SeenPoint& point : seen_) {
    if (point.depth < 0) continue;
    bounds.extend(point.position);
    deepest = std::max(deepest, static_cast<int>(level(point.depth)));
  }
  levels_.clear();
  if (deepest < 0) return;
  const Bounds scene = context.scene.bounds();
  max_spacing_ = params_.max_spacing * glm::length((scene.empty() ? bounds : scene).diagonal());
  for (int i = 0; i <= deepest; ++i)
    levels_.emplace_back(context.make_balls(params_.structure, bounds), params_.order, params_.accuracy);
  // Every step-th pixel, but for those that the coarser pass has been to.
  for (int step = coarsest_grid; step >= 1; step /= 2)
    fill(context, [=](int x, int y) {
      return x % step == 0 && y % step == 0 && (step == coarsest_grid || x % (2 * step) != 0 || y % (2 * step) != 0);
    });
  fill(context, [](int, int) { return true; });
  seen_ = {};
}

// Follows the pixel's centre to a cached surface at which light may scatter once more.
SeenPoint RadianceCache::find_seen(const RenderContext& context, ivec2 pixel) const {
  const auto key = static_cast<std::uint64_t>(pixel.y) * context.resolution.x + pixel.x;
  Sampler sampler(sampler_, context.seed, Stream::prefill, key, 0);
  const vec2 lens = context.needs.thin_lens ? sampler.get_2d() : vec2(0.5f);
  const float pixel_angle =
      2 * context.scene.camera.half_extent(context.resolution).x / static_cast<float>(context.resolution.x);
  Ray ray = context.scene.camera.ray(context.resolution, vec2(pixel) + 0.5f, lens);
  float distance = 0;
  for (int depth = 0; depth + 1 < max_depth_; ++depth) {
    const Hit hit = trace(context, ray);
    if (!hit) break;
    const SurfacePoint point = context.scene.surface_at(ray, hit);
    const vec3 wo = -ray.direction;
    distance += glm::length(point.position - ray.origin);
    if (is_cached(context, point))
      return {point.position, towards(point.shading_normal, point.normal, wo), towards(point.normal, point.normal, wo),
              distance * pixel_angle, depth};
    const Bsdf bsdf(context.scene, point);
    const float u_lobe = sampler.get_1d();
    const BsdfSample scattered = bsdf.sample(wo, u_lobe, sampler.get_2d());
    if (!scattered) break;
    ray = spawn_ray(point, scattered.wi);
  }
  return {};
}

// Covers the points of the pixels for which wanted(x, y), where no record covers them yet.
template <class Wanted>
void RadianceCache::fill(const RenderContext& context, const Wanted& wanted) {
  const auto covered = [&](std::size_t pixel) {
    const SeenPoint& point = seen_[pixel];
    return point.depth < 0 || levels_[level(point.depth)].covered(point.position, point.normal);
  };
  const auto width = static_cast<std::size_t>(context.resolution.x);
  std::vector<std::uint8_t> open(seen_.size());
  parallel_for(seen_.size(), 1024, [&](std::size_t i) {
    open[i] = wanted(static_cast<int>(i % width), static_cast<int>(i / width)) && !covered(i);
  });
  std::vector<std::pair<std::uint64_t, std::uint32_t>> queue;
  for (std::uint32_t i = 0; i < seen_.size(); ++i)
    if (open[i]) queue.emplace_back(mix_bits(i), i);
  std::sort(queue.begin(), queue.end());

  std::vector<std::uint32_t> batch;
  std::vector<RadianceEstimate> estimates(batch_size);
  for (std::size_t next = 0; next < queue.size();) {
    batch.clear();
    for (; next < queue.size() && batch.size() < batch_size; ++next)
      if (!covered(queue[next].second)) batch.push_back(queue[next].second);
    parallel_for(batch.size(), 1, [&](std::size_t i) { estimates[i] = sample_hemisphere(context, seen_[batch[i]], batch[i]); });
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const SeenPoint& point = seen_[batch[i]];
      const RadianceSpacing spacing{params_.accuracy, std::max(params_.min_spacing * point.pixel_width, 1e-6f * max_spacing_),
                                    max_spacing_};
      levels_[level(point.depth)].insert(point.position, point.normal, estimates[i], spacing, params_.gradients);
    }
    count(Counter::records, batch.size());
  }
}

// All light but that which arrives straight from a light.
RadianceEstimate RadianceCache::sample_hemisphere(const RenderContext& context, const SeenPoint& point,
                                                  std::uint64_t key) const {
  static thread_local std::vector<HemisphereSample> samples;
  static thread_local std::vector<PathSample> paths;
  static thread_local std::vector<int> strata;  // of the paths
  samples.assign(static_cast<std::size_t>(strata_.count()), {});
  const Frame frame = Frame::from_normal(point.normal);
  const vec3 origin = offset_origin(point.position, point.geometric);
  const int depth = (level(point.depth) == 0 ? 0 : point.depth) + 1;
  for (int first = 0; first < strata_.count(); first += path_batch) {
    paths.clear();
    strata.clear();
    for (int i = first; i < std::min(first + path_batch, strata_.count()); ++i) {
      Sampler sampler(sampler_, context.seed, Stream::cache_record, key, static_cast<std::uint32_t>(i));
      samples[i].direction = frame.to_world(even_direction(strata_, i, sampler.get_2d()));
      if (glm::dot(samples[i].direction, point.geometric) <= 0) continue;  // below, where shading normals disagree
      paths.push_back({Ray{.origin = origin, .direction = samples[i].direction}, sampler});
      strata.push_back(i);
    }
    trace_paths(context, paths, depth, {max_depth_, roulette_depth, MisMode::power}, false);
    for (std::size_t i = 0; i < paths.size(); ++i) {
      samples[strata[i]].radiance = paths[i].radiance;
      samples[strata[i]].distance = paths[i].first_distance;
    }
  }
  return estimate_radiance(params_.order, strata_, samples, frame);
}

// Indirect light that a cached surface scatters; empty where no record serves.
std::optional<Rgb> RadianceCache::indirect(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, int depth,
                                           Sampler& sampler) const {
  if (depth + 1 >= max_depth_) return Rgb(0);
  if (level(depth) >= levels_.size()) return std::nullopt;
  count(Counter::lookups);
  const RadianceRecords& records = levels_[level(depth)];
  const vec3 normal = towards(point.shading_normal, point.normal, wo);
  if (bsdf.is_diffuse()) {
    const auto white = records.scatter(point.position, normal, diffuse_lobe(params_.order, normal));
    return white ? std::optional(bsdf.diffuse_albedo() * *white) : std::nullopt;
  }
  if (!records.covered(point.position, normal)) return std::nullopt;
  const std::size_t size = static_cast<std::size_t>(params_.order) * params_.order;
  static thread_local ShLobe lobe;
  static thread_local std::vector<float> harmonics;
  lobe.assign(size, Rgb(0));
  harmonics.resize(size);
  // A lattice of rank one, turned at random ([Cranley1976] with the golden ratio).
  const float turn = sampler.get_1d();
  const vec2 shift = sampler.get_2d();
  for (int k = 0; k < params_.lobe_samples; ++k) {
    const float place = static_cast<float>(k) / static_cast<float>(params_.lobe_samples);
    const auto wrapped = [](float x) { return std::min(x - std::floor(x), 0x1.fffffep-1f); };
    const vec2 u(wrapped(shift.x + place), wrapped(shift.y + 0.61803399f * static_cast<float>(k)));
    const BsdfSample s = bsdf.sample(wo, wrapped(turn + 0.75487767f * static_cast<float>(k)), u);
    if (!s) continue;
    evaluate_sh(params_.order, s.wi, harmonics);
    const Rgb weight = s.weight / static_cast<float>(params_.lobe_samples);
    for (std::size_t i = 0; i < size; ++i) lobe[i] += harmonics[i] * weight;
  }
  return records.scatter(point.position, normal, lobe);
}

void RadianceCache::iteration(RenderContext& context, std::uint32_t index, Film& film) {
  const auto timed = context.phases.measure("gather");
  parallel_pixels(context.resolution, [&](ivec2 pixel) {
    const auto key = static_cast<std::uint64_t>(pixel.y) * context.resolution.x + pixel.x;
    Sampler sampler(sampler_, context.seed, Stream::camera, key, index);
    const Ray ray = sample_camera_ray(context, pixel, sampler);
    film.add(pixel, camera_radiance(context, ray, sampler), index);
  });
}

Rgb RadianceCache::camera_radiance(const RenderContext& context, Ray ray, Sampler& sampler) const {
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
    const bool cached = is_cached(context, point);
    radiance += throughput * direct_light(context, point, bsdf, wo, sampler, cached ? MisMode::light : MisMode::power);
    if (cached)
      if (const auto found = indirect(point, bsdf, wo, depth, sampler)) return radiance + throughput * *found;

    const float u_lobe = sampler.get_1d();
    const BsdfSample scattered = bsdf.sample(wo, u_lobe, sampler.get_2d());
    if (!scattered) return radiance;
    count_emission = !cached;  // a cached surface has had all of its direct light from the light sample
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

}  // namespace

IntegratorEntry radiance_cache_entry() {
  return {"radiance-cache", "radiance caching in spherical harmonics", list_params<RadianceCacheParams>(),
          [](const ParamMap& map) {
            return std::make_unique<RadianceCache>(read_params<RadianceCacheParams>(map, "radiance-cache"));
          }};
}

}  // namespace etendue
