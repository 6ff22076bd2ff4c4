#include "integrators/cache_fill.h"

#include "framework/core/counters.h"
#include "framework/core/parallel.h"
#include "framework/transport/ray_tools.h"
#include "integrators/irradiance_hessian.h"

namespace etendue {

namespace {

constexpr int coarsest_grid = 256;
constexpr std::size_t batch_size = 64;
constexpr int path_batch = 2048;                // paths traced together: as many rays at once as still pays
constexpr float coarsest = 64, finest = 1e-3f;  // accuracies between which a number of records is looked for

}  // namespace

std::span<const HemisphereSample> trace_hemisphere(const RenderContext& context, SamplerKind kind, const CachePoint& point,
                                                   const Frame& frame, int depth, std::uint64_t key, std::uint32_t pass,
                                                   const HemisphereStrata& strata, StratumDirection direction,
                                                   const HemisphereRadiance& radiance) {
  static thread_local std::vector<HemisphereSample> samples;
  static thread_local std::vector<PathSample> paths;
  static thread_local std::vector<int> strata_of;  // of the paths
  samples.assign(static_cast<std::size_t>(strata.count()), {});
  const vec3 origin = offset_origin(point.position, point.geometric);
  for (int first = 0; first < strata.count(); first += path_batch) {
    paths.clear();
    strata_of.clear();
    for (int i = first; i < std::min(first + path_batch, strata.count()); ++i) {
      const auto index = pass * static_cast<std::uint32_t>(strata.count()) + static_cast<std::uint32_t>(i);
      Sampler sampler(kind, context.seed, Stream::cache_record, key, index);
      samples[i].direction = frame.to_world(direction(strata, i, sampler.get_2d()));
      if (glm::dot(samples[i].direction, point.geometric) <= 0) continue;  // below, where shading normals disagree
      paths.push_back({Ray{.origin = origin, .direction = samples[i].direction}, sampler});
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
  return samples;
}

IrradianceEstimate sample_hemisphere(const RenderContext& context, const CacheSettings& settings, const CachePoint& point,
                                     int depth, std::uint64_t key, std::uint32_t pass, const HemisphereRadiance& radiance) {
  const HemisphereStrata& strata = settings.strata;
  const Frame frame = Frame::from_normal(point.normal);
  const auto direction = [](const HemisphereStrata& all, int i, const vec2& u) { return all.direction(i, u); };
  const auto samples = trace_hemisphere(context, settings.sampler, point, frame, depth, key, pass, strata, direction, radiance);
  IrradianceEstimate estimate = estimate_irradiance(strata, samples, frame);
  if (settings.gradients == Gradients::mesh || is_hessian(settings.metric))
    estimate_hessian(settings.metric, strata, samples, frame, settings.gradients == Gradients::mesh, estimate);
  return estimate;
}

CacheLevels::CacheLevels(const RenderContext& context, const CacheSettings& settings, std::vector<CachePoint> pixels,
                         bool one_level)
    : settings_(settings), accuracy_(settings.accuracy), one_level_(one_level), pixels_(std::move(pixels)) {
  for (const CachePoint& point : pixels_)
    if (point) bounds_.extend(point.position);
  Bounds whole = context.scene.bounds();
  if (whole.empty()) whole = bounds_;
  if (!whole.empty()) settings_.scene_size = glm::length(whole.diagonal());
  clear(context);
}

void CacheLevels::clear(const RenderContext& context) {
  levels_.clear();
  int deepest = -1;
  for (const CachePoint& point : pixels_)
    if (point) deepest = std::max(deepest, static_cast<int>(level(point.depth)));
  for (int i = 0; i <= deepest; ++i) levels_.push_back({{}, make_records(context)});
}

void CacheLevels::rebuild(const RenderContext& context, float accuracy) {
  accuracy_ = accuracy;
  for (Level& level : levels_) {
    level.records = make_records(context);
    for (const RecordHistory& history : level.histories) level.records.insert(record_of(history));
  }
}

IrradianceRecords CacheLevels::make_records(const RenderContext& context) const {
  const CacheWeight weight = settings_.metric == CacheMetric::tabellion ? CacheWeight::tabellion : CacheWeight::ward;
  // The split sphere's radius is a mean distance, which grows by no more than the way ([Krivanek2006]). What Hessians allow has
  // no such bound; there it is what a record serves, at the usual accuracy, that may grow by the way.
  const float clamp = is_hessian(settings_.metric) ? 1 / usual_accuracy : 1;
  return {context.make_balls(settings_.structure, bounds_),
          accuracy_,
          settings_.clamping ? clamp : 0.0f,
          weight,
          settings_.stretch,
          std::clamp(settings_.accuracy / accuracy_, 1.0f, settings_.overlap)};
}

IrradianceRecord CacheLevels::record_of(const RecordHistory& history) const {
  const MetricContext metric{.accuracy = settings_.accuracy,
                             .scene_size = settings_.scene_size,
                             .pixel_width = history.point.pixel_width,
                             .min_spacing = settings_.min_spacing,
                             .max_spacing = settings_.max_spacing,
                             .extrapolates = settings_.gradients >= Gradients::both};
  return make_record(history.point.position, history.point.normal, history.mean, settings_.gradients, settings_.metric, metric);
}

std::size_t CacheLevels::size() const {
  std::size_t sum = 0;
  for (const Level& level : levels_) sum += level.histories.size();
  return sum;
}

bool CacheLevels::covered(const CachePoint& point) const {
  return levels_[level(point.depth)].records.covered(point.position, point.normal);
}

void CacheLevels::fill(const RenderContext& context, const HemisphereRadiance& radiance, float accuracy) {
  rebuild(context, accuracy);
  // Every step-th pixel, but for those that the coarser pass has been to.
  const std::uint64_t drawn = hash_keys(context.seed, static_cast<std::uint32_t>(Stream::prefill));
  const int left = static_cast<int>(drawn % coarsest_grid), up = static_cast<int>((drawn >> 32) % coarsest_grid);
  for (int step = coarsest_grid; step >= 1; step /= 2)
    fill_where(context, radiance, [=](int x, int y) {
      const auto on_grid = [=](int size) { return (x + left) % size == 0 && (y + up) % size == 0; };
      return on_grid(step) && (step == coarsest_grid || !on_grid(2 * step));
    });
  if (settings_.clamping) fill_where(context, radiance, [](int, int) { return true; });
}

void CacheLevels::fill_to(const RenderContext& context, const HemisphereRadiance& radiance, std::size_t records) {
  float coarse = coarsest, fine = finest, accuracy = settings_.accuracy;
  limit_ = records + 1;  // one more than asked for shows that an accuracy is too fine
  for (int step = 0; step < 20; ++step) {
    clear(context);
    fill(context, radiance, accuracy);
    if (size() <= records && size() >= records - records / 50) break;
    (size() > records ? fine : coarse) = accuracy;
    if (coarse / fine < 1.0005f) break;
    accuracy = std::sqrt(coarse * fine);
  }
  if (size() > records) {
    limit_ = records;
    clear(context);
    fill(context, radiance, coarse);
  }
  histories_.clear();
  limit_ = 0;
}

// Covers the points of the pixels for which wanted(x, y), where no record covers them yet.
template <class Wanted>
void CacheLevels::fill_where(const RenderContext& context, const HemisphereRadiance& radiance, const Wanted& wanted) {
  const auto width = static_cast<std::size_t>(context.resolution.x);
  std::vector<std::uint8_t> open(pixels_.size());
  parallel_for(pixels_.size(), 1024, [&](std::size_t i) {
    open[i] = pixels_[i] && wanted(static_cast<int>(i % width), static_cast<int>(i / width)) && !covered(pixels_[i]);
  });
  std::vector<Query> queue;
  for (std::size_t i = 0; i < pixels_.size(); ++i)
    if (open[i]) queue.push_back({key_salt_ == 0 ? i : hash_keys(i, key_salt_), &pixels_[i]});
  cover(context, radiance, std::move(queue), 1);
}

void CacheLevels::cover(const RenderContext& context, const HemisphereRadiance& radiance, std::vector<Query> queue,
                        double passes) {
  const std::uint64_t drawn = mix_bits(context.seed);
  std::sort(queue.begin(), queue.end(),
            [=](const Query& a, const Query& b) { return mix_bits(a.key ^ drawn) < mix_bits(b.key ^ drawn); });
  std::vector<Query> batch;
  std::vector<RecordHistory> made(batch_size);
  for (std::size_t next = 0; next < queue.size();) {
    const std::size_t room = limit_ > 0 ? limit_ - std::min(limit_, size()) : batch_size;
    if (room == 0) return;
    batch.clear();
    for (; next < queue.size() && batch.size() < std::min(room, batch_size); ++next)
      if (!covered(*queue[next].point)) batch.push_back(queue[next]);
    parallel_for(batch.size(), 1, [&](std::size_t i) { made[i] = sample(context, radiance, batch[i], passes); });
    for (std::size_t i = 0; i < batch.size(); ++i) {
      Level& level = levels_[this->level(batch[i].point->depth)];
      if (limit_ == 0 || histories_.emplace(batch[i].key, made[i]).second) count(Counter::records);
      level.records.insert(record_of(made[i]));
      level.histories.push_back(made[i]);
    }
  }
}

RecordHistory CacheLevels::sample(const RenderContext& context, const HemisphereRadiance& radiance, const Query& query,
                                  double passes) const {
  if (const auto known = histories_.find(query.key); known != histories_.end()) return known->second;
  RecordHistory history{*query.point, query.key, {}, 0};
  add_passes(context, radiance, history, passes);
  return history;
}

void CacheLevels::add_passes(const RenderContext& context, const HemisphereRadiance& radiance, RecordHistory& history,
                             double passes) const {
  const auto target = static_cast<int>(passes + to_unit_float(static_cast<std::uint32_t>(hash_keys(history.key, 1u))));
  const int depth = static_cast<int>(level(history.point.depth)) + 1;
  while (history.passes < std::max(target, 1)) {
    const auto pass = static_cast<std::uint32_t>(history.passes++);
    const IrradianceEstimate next =
        settings_.at_point ? settings_.at_point(history.point, depth)
                           : sample_hemisphere(context, settings_, history.point, depth, history.key, pass, radiance);
    if (pass == 0)
      history.mean = next;
    else
      history.mean.average_in(next, history.passes);
  }
}

void CacheLevels::refine(const RenderContext& context, const HemisphereRadiance& radiance, float accuracy, double passes,
                         std::span<const CachePoint> wanted, std::uint32_t round) {
  for (Level& level : levels_)
    parallel_for(level.histories.size(), 1, [&](std::size_t i) { add_passes(context, radiance, level.histories[i], passes); });
  rebuild(context, accuracy);
  std::vector<Query> queue;
  for (std::size_t i = 0; i < wanted.size(); ++i)
    if (wanted[i]) {
      while (level(wanted[i].depth) >= levels_.size()) levels_.push_back({{}, make_records(context)});
      queue.push_back({hash_keys(i, round), &wanted[i]});
    }
  cover(context, radiance, std::move(queue), passes);
}

void CacheLevels::resume(const RenderContext& context, std::vector<std::vector<RecordHistory>> levels, float accuracy,
                         std::uint64_t key_salt) {
  key_salt_ = key_salt;
  for (const auto& histories : levels)
    for (const RecordHistory& history : histories) bounds_.extend(history.point.position);
  while (levels_.size() < levels.size()) levels_.push_back({{}, make_records(context)});
  for (std::size_t i = 0; i < levels.size(); ++i) levels_[i].histories = std::move(levels[i]);
  rebuild(context, accuracy);
}

std::vector<std::span<const RecordHistory>> CacheLevels::histories() const {
  std::vector<std::span<const RecordHistory>> spans;
  for (const Level& level : levels_) spans.emplace_back(level.histories);
  return spans;
}

std::vector<RecordDisc> CacheLevels::discs() const {
  std::vector<RecordDisc> discs;
  for (const Level& level : levels_)
    for (const IrradianceRecord& record : level.records.all())
      discs.push_back({record.position, record.normal, accuracy_ * record.reach});
  return discs;
}

std::optional<Interpolated> CacheLevels::interpolate(int depth, const vec3& position, const vec3& normal) const {
  if (level(depth) >= levels_.size()) return std::nullopt;
  count(Counter::lookups);
  return levels_[level(depth)].records.interpolate(position, normal);
}

}  // namespace etendue
