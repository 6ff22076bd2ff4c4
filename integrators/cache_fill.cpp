#include "integrators/cache_fill.h"

#include "framework/core/counters.h"
#include "framework/core/parallel.h"
#include "framework/transport/ray_tools.h"
#include "integrators/irradiance_hessian.h"

namespace etendue {

namespace {

constexpr int coarsest_grid = 64;
constexpr std::size_t batch_size = 64;
constexpr int path_batch = 2048;                // paths traced together: as many rays at once as still pays
constexpr float coarsest = 64, finest = 1e-3f;  // accuracies between which a number of records is looked for

}  // namespace

IrradianceEstimate sample_hemisphere(const RenderContext& context, const CacheSettings& settings, const CachePoint& point,
                                     int depth, std::uint64_t key, std::uint32_t pass, const HemisphereRadiance& radiance) {
  static thread_local std::vector<HemisphereSample> samples;
  static thread_local std::vector<PathSample> paths;
  static thread_local std::vector<int> strata_of;  // of the paths
  const HemisphereStrata& strata = settings.strata;
  samples.assign(static_cast<std::size_t>(strata.count()), {});
  const Frame frame = Frame::from_normal(point.normal);
  const vec3 origin = offset_origin(point.position, point.geometric);
  for (int first = 0; first < strata.count(); first += path_batch) {
    paths.clear();
    strata_of.clear();
    for (int i = first; i < std::min(first + path_batch, strata.count()); ++i) {
      const auto index = pass * static_cast<std::uint32_t>(strata.count()) + static_cast<std::uint32_t>(i);
      Sampler sampler(settings.sampler, context.seed, Stream::cache_record, key, index);
      const vec3 direction = frame.to_world(strata.direction(i, sampler.get_2d()));
      samples[i].direction = direction;
      if (glm::dot(direction, point.geometric) <= 0) continue;  // below the surface, where shading normals disagree
      paths.push_back({Ray{.origin = origin, .direction = direction}, sampler});
      strata_of.push_back(i);
    }
    radiance(paths, depth);
    for (std::size_t i = 0; i < paths.size(); ++i) {
      HemisphereSample& sample = samples[strata_of[i]];
      sample.radiance = paths[i].radiance;
      sample.distance = paths[i].first_distance;
      sample.normal = paths[i].first_normal;
    }
  }
  IrradianceEstimate estimate = estimate_irradiance(strata, samples, frame);
  if (settings.gradients == Gradients::mesh || is_hessian(settings.metric))
    estimate_hessian(settings.metric, strata, samples, frame, settings.gradients == Gradients::mesh, estimate);
  return estimate;
}

CacheLevels::CacheLevels(const RenderContext& context, const CacheSettings& settings, std::vector<CachePoint> pixels,
                         bool one_level)
    : settings_(settings), one_level_(one_level), pixels_(std::move(pixels)) {
  for (const CachePoint& point : pixels_)
    if (point) bounds_.extend(point.position);
  Bounds whole = context.scene.bounds();
  if (whole.empty()) whole = bounds_;
  if (!whole.empty()) settings_.scene_size = glm::length(whole.diagonal());
  clear(context, settings.accuracy);
}

void CacheLevels::clear(const RenderContext& context, float accuracy) {
  settings_.accuracy = accuracy;
  levels_.clear();
  int deepest = -1;
  for (const CachePoint& point : pixels_)
    if (point) deepest = std::max(deepest, static_cast<int>(level(point.depth)));
  const CacheWeight weight = settings_.metric == CacheMetric::tabellion ? CacheWeight::tabellion : CacheWeight::ward;
  for (int i = 0; i <= deepest; ++i)
    levels_.emplace_back(context.make_balls(settings_.structure, bounds_), accuracy, settings_.clamping, weight);
}

MetricContext CacheLevels::metric_context(const CachePoint& point) const {
  return {.accuracy = settings_.accuracy,
          .scene_size = settings_.scene_size,
          .pixel_width = point.pixel_width,
          .min_spacing = settings_.min_spacing,
          .max_spacing = settings_.max_spacing,
          .extrapolates = settings_.gradients >= Gradients::both};
}

std::size_t CacheLevels::size() const {
  std::size_t sum = 0;
  for (const IrradianceRecords& records : levels_) sum += records.all().size();
  return sum;
}

void CacheLevels::fill(const RenderContext& context, const HemisphereRadiance& radiance) {
  // Every step-th pixel, but for those that the coarser pass has been to.
  for (int step = coarsest_grid; step >= 1; step /= 2)
    fill_where(context, radiance, [=](int x, int y) {
      return x % step == 0 && y % step == 0 && (step == coarsest_grid || x % (2 * step) != 0 || y % (2 * step) != 0);
    });
  if (settings_.clamping) fill_where(context, radiance, [](int, int) { return true; });
}

void CacheLevels::fill_to(const RenderContext& context, const HemisphereRadiance& radiance, std::size_t records) {
  float coarse = coarsest, fine = finest;
  // One more than asked for shows that an accuracy is too fine.
  limit_ = records + 1;
  const auto fill_at = [&](float accuracy) {
    clear(context, accuracy);
    fill(context, radiance);
    return size();
  };
  float accuracy = settings_.accuracy;
  for (int step = 0; step < 20; ++step) {
    const std::size_t count = fill_at(accuracy);
    if (count <= records && count >= records - records / 50) break;
    (count > records ? fine : coarse) = accuracy;
    if (coarse / fine < 1.0005f) break;
    accuracy = std::sqrt(coarse * fine);
  }
  if (size() > records) fill_at(coarse);
  estimates_.clear();
  limit_ = 0;
}

// Covers the points of the pixels for which wanted(x, y), where no record covers them yet.
template <class Wanted>
void CacheLevels::fill_where(const RenderContext& context, const HemisphereRadiance& radiance, const Wanted& wanted) {
  const auto covered = [&](std::size_t pixel) {
    const CachePoint& point = pixels_[pixel];
    return !point || levels_[level(point.depth)].covered(point.position, point.normal);
  };
  const auto width = static_cast<std::size_t>(context.resolution.x);
  std::vector<std::uint8_t> open(pixels_.size());
  parallel_for(pixels_.size(), 1024, [&](std::size_t i) {
    open[i] = wanted(static_cast<int>(i % width), static_cast<int>(i / width)) && !covered(i);
  });
  std::vector<std::pair<std::uint64_t, std::uint32_t>> queue;
  for (std::uint32_t i = 0; i < pixels_.size(); ++i)
    if (open[i]) queue.emplace_back(mix_bits(i), i);
  std::sort(queue.begin(), queue.end());

  std::vector<std::uint32_t> batch;
  std::vector<IrradianceEstimate> estimates(batch_size);
  std::vector<std::uint8_t> known(batch_size);
  for (std::size_t next = 0; next < queue.size();) {
    const std::size_t room = limit_ > 0 ? limit_ - std::min(limit_, size()) : batch_size;
    if (room == 0) return;
    batch.clear();
    for (; next < queue.size() && batch.size() < std::min(room, batch_size); ++next)
      if (!covered(queue[next].second)) batch.push_back(queue[next].second);
    parallel_for(batch.size(), 1, [&](std::size_t i) {
      const auto found = estimates_.find(batch[i]);
      known[i] = found != estimates_.end();
      const CachePoint& point = pixels_[batch[i]];
      const int depth = (level(point.depth) == 0 ? 0 : point.depth) + 1;
      estimates[i] = known[i] ? found->second : sample_hemisphere(context, settings_, point, depth, batch[i], 0, radiance);
    });
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const CachePoint& point = pixels_[batch[i]];
      if (!known[i]) count(Counter::records);
      if (limit_ > 0 && !known[i]) estimates_.emplace(batch[i], estimates[i]);
      levels_[level(point.depth)].insert(make_record(point.position, point.normal, estimates[i], settings_.gradients,
                                                     settings_.metric, metric_context(point)));
    }
  }
}

std::optional<Rgb> CacheLevels::interpolate(int depth, const vec3& position, const vec3& normal) const {
  if (level(depth) >= levels_.size()) return std::nullopt;
  count(Counter::lookups);
  return levels_[level(depth)].interpolate(position, normal);
}

}  // namespace etendue
