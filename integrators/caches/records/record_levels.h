// Records by level, filled and refined so that they cover what the camera sees ([Ward1988]'s overture), whatever they hold.
//
// In an overture over pixel centres on grids of 256, 128, ... 1 pixels, each pass looks for points that no record covers and
// takes them in an order drawn by hash, in batches of 64 (order and offset of the grids depend on the seed, so that the scatter
// over seeds includes that of the records' places): a batch is computed in parallel, then inserted in its order. Points of one
// batch do not see each other's records; the few superfluous ones cost only memory. As clamping shortens validity radii, a last
// pass visits every pixel again. Thus the records do not depend on threads.
//
// Without the overture pixels are visited row by row, each seeing all earlier records: the order in which rendering an image
// needs them ([Ward1988]). A record then lies where those before it end, at the edge of the area it is to serve.
#pragma once

#include "framework/core/counters.h"
#include "framework/core/parallel.h"
#include "integrators/caches/records/hemisphere.h"
#include "integrators/paths/path.h"
#include "integrators/photons/cache_points.h"

#include <functional>
#include <unordered_map>

namespace etendue {

// Radiance arriving along the first rays of paths with `depth` events behind them.
using HemisphereRadiance = std::function<void(std::span<PathSample> paths, int depth)>;

// Holds what a record is made from.
template <class Estimate>
struct RecordHistoryOf {
  CachePoint point;
  std::uint64_t key = 0;  // of its random numbers
  Estimate mean;          // of its passes
  int passes = 0;
};

// Settings by which records of either kind are made.
struct RecordSettings {
  float accuracy = 0.2f;     // at which the spacings hold; with a number of records given they hold at that which is found
  float min_spacing = 1.5f;  // pixels
  float max_spacing = 0.1f;  // scene diagonals
  float overlap = 1;         // see irradiance_records.h
  HemisphereStrata strata;
  SamplerKind sampler = SamplerKind::sobol;
  std::string structure = "cells";
};

// `Estimate`: what one pass over a hemisphere gives, and how passes average. `Records`: which points they cover. A point
// belongs to the level of its depth, or all to one.
template <class Estimate, class Records>
class RecordLevels {
 public:
  using History = RecordHistoryOf<Estimate>;

  virtual ~RecordLevels() = default;

  // Forgets all records.
  void clear(const RenderContext& context);
  // Covers all pixels at an accuracy with records added to those there are.
  void fill(const RenderContext& context, const HemisphereRadiance& radiance, float accuracy);
  // Every record is brought to `passes` passes over its hemisphere (a fractional number by giving that share of the records one
  // pass more), and its validity radius is recomputed; then `wanted` points, keyed by their index and `round`, are covered at
  // `accuracy` where they are not yet.
  void refine(const RenderContext& context, const HemisphereRadiance& radiance, float accuracy, double passes,
              std::span<const CachePoint> wanted, std::uint32_t round);
  // Records made earlier, in their order, in place of those there are. A `key_salt` other than 0 keeps the random numbers of
  // points that are filled from now on apart from those of earlier views.
  void resume(const RenderContext& context, std::vector<std::vector<History>> levels, float accuracy, std::uint64_t key_salt);

  std::vector<std::span<const History>> histories() const;  // by level
  std::uint64_t passes() const;                             // of all records
  std::size_t size() const;
  float accuracy() const { return accuracy_; }

 protected:
  // The three steps that depend on the kind of record: making an empty set, at accuracy() within bounds(); inserting a record;
  // tracing a pass.
  virtual Records make_records(const RenderContext& context) const = 0;
  virtual void insert(Records& records, const History& history) const = 0;
  virtual Estimate estimate(const RenderContext& context, const HemisphereRadiance& radiance, const History& history, int depth,
                            std::uint32_t pass) const = 0;

  // Without records. `pixels`: what their centres see.
  void start(const RenderContext& context, std::vector<CachePoint> pixels, bool one_level, float accuracy);
  void overture(bool plays) { overture_ = plays; }
  // Makes no more than `limit` records from now on (0: any number); one that is made again reuses its samples.
  void limit(std::size_t limit);
  // Those that serve points of a depth, and those of a level; null where there are none.
  const Records* records_at(int depth) const { return records_in(level(depth)); }
  const Records* records_in(std::size_t level) const { return level < levels_.size() ? &levels_[level].records : nullptr; }
  const Bounds& bounds() const { return bounds_; }  // of what is seen

 private:
  static constexpr int coarsest_grid = 256;
  static constexpr std::size_t batch_size = 64;

  struct Level {
    std::vector<History> histories;
    Records records;
  };
  struct Query {
    std::uint64_t key;  // of random numbers
    const CachePoint* point;
  };

  std::size_t level(int depth) const { return one_level_ ? 0 : static_cast<std::size_t>(depth); }
  bool covered(const CachePoint& point) const {
    return levels_[level(point.depth)].records.covered(point.position, point.normal);
  }
  void rebuild(const RenderContext& context, float accuracy);
  template <class Wanted>
  void fill_where(const RenderContext& context, const HemisphereRadiance& radiance, const Wanted& wanted);
  void cover(const RenderContext& context, const HemisphereRadiance& radiance, std::vector<Query> queue, double passes);
  // In the queue's order, `together` points at a time.
  void cover_in_order(const RenderContext& context, const HemisphereRadiance& radiance, std::span<const Query> queue,
                      double passes, std::size_t together);
  History sample(const RenderContext& context, const HemisphereRadiance& radiance, const Query& query, double passes) const;
  void add_passes(const RenderContext& context, const HemisphereRadiance& radiance, History& history, double passes) const;

  float accuracy_ = 1;
  bool one_level_ = true, overture_ = true;
  Bounds bounds_;
  std::vector<CachePoint> pixels_;
  std::vector<Level> levels_;
  std::uint64_t key_salt_ = 0;
  std::size_t limit_ = 0;
  std::unordered_map<std::uint64_t, History> known_;  // by key, under a limit
};

template <class Estimate, class Records>
void RecordLevels<Estimate, Records>::start(const RenderContext& context, std::vector<CachePoint> pixels, bool one_level,
                                            float accuracy) {
  accuracy_ = accuracy;
  one_level_ = one_level;
  pixels_ = std::move(pixels);
  bounds_ = {};
  for (const CachePoint& point : pixels_)
    if (point) bounds_.extend(point.position);
  clear(context);
}

template <class Estimate, class Records>
void RecordLevels<Estimate, Records>::clear(const RenderContext& context) {
  levels_.clear();
  int deepest = -1;
  for (const CachePoint& point : pixels_)
    if (point) deepest = std::max(deepest, static_cast<int>(level(point.depth)));
  for (int i = 0; i <= deepest; ++i) levels_.push_back({{}, make_records(context)});
}

template <class Estimate, class Records>
void RecordLevels<Estimate, Records>::limit(std::size_t limit) {
  limit_ = limit;
  if (limit == 0) known_.clear();
}

template <class Estimate, class Records>
void RecordLevels<Estimate, Records>::rebuild(const RenderContext& context, float accuracy) {
  accuracy_ = accuracy;
  for (Level& level : levels_) {
    level.records = make_records(context);
    for (const History& history : level.histories) insert(level.records, history);
  }
}

template <class Estimate, class Records>
std::size_t RecordLevels<Estimate, Records>::size() const {
  std::size_t sum = 0;
  for (const Level& level : levels_) sum += level.histories.size();
  return sum;
}

template <class Estimate, class Records>
auto RecordLevels<Estimate, Records>::histories() const -> std::vector<std::span<const History>> {
  std::vector<std::span<const History>> spans;
  for (const Level& level : levels_) spans.emplace_back(level.histories);
  return spans;
}

template <class Estimate, class Records>
std::uint64_t RecordLevels<Estimate, Records>::passes() const {
  std::uint64_t sum = 0;
  for (const Level& level : levels_)
    for (const History& history : level.histories) sum += static_cast<std::uint64_t>(history.passes);
  return sum;
}

template <class Estimate, class Records>
void RecordLevels<Estimate, Records>::fill(const RenderContext& context, const HemisphereRadiance& radiance, float accuracy) {
  rebuild(context, accuracy);
  // Every step-th pixel, but for those that the coarser pass has been to.
  const std::uint64_t drawn = hash_keys(context.seed, static_cast<std::uint32_t>(Stream::initial_pass));
  const int left = static_cast<int>(drawn % coarsest_grid), up = static_cast<int>((drawn >> 32) % coarsest_grid);
  for (int step = overture_ ? coarsest_grid : 0; step >= 1; step /= 2)
    fill_where(context, radiance, [=](int x, int y) {
      const auto on_grid = [=](int size) { return (x + left) % size == 0 && (y + up) % size == 0; };
      return on_grid(step) && (step == coarsest_grid || !on_grid(2 * step));
    });
  fill_where(context, radiance, [](int, int) { return true; });
}

// Covers the points of the pixels for which wanted(x, y), where no record covers them yet.
template <class Estimate, class Records>
template <class Wanted>
void RecordLevels<Estimate, Records>::fill_where(const RenderContext& context, const HemisphereRadiance& radiance,
                                                 const Wanted& wanted) {
  const auto width = static_cast<std::size_t>(context.resolution.x);
  std::vector<std::uint8_t> open(pixels_.size());
  parallel_for(pixels_.size(), 1024, [&](std::size_t i) {
    open[i] = pixels_[i] && wanted(static_cast<int>(i % width), static_cast<int>(i / width)) && !covered(pixels_[i]);
  });
  std::vector<Query> queue;
  for (std::size_t i = 0; i < pixels_.size(); ++i)
    if (open[i]) queue.push_back({key_salt_ == 0 ? i : hash_keys(i, key_salt_), &pixels_[i]});
  if (overture_)
    cover(context, radiance, std::move(queue), 1);
  else
    cover_in_order(context, radiance, queue, 1, 1);
}

template <class Estimate, class Records>
void RecordLevels<Estimate, Records>::cover(const RenderContext& context, const HemisphereRadiance& radiance,
                                            std::vector<Query> queue, double passes) {
  const std::uint64_t drawn = mix_bits(context.seed);
  std::sort(queue.begin(), queue.end(),
            [=](const Query& a, const Query& b) { return mix_bits(a.key ^ drawn) < mix_bits(b.key ^ drawn); });
  cover_in_order(context, radiance, queue, passes, batch_size);
}

template <class Estimate, class Records>
void RecordLevels<Estimate, Records>::cover_in_order(const RenderContext& context, const HemisphereRadiance& radiance,
                                                     std::span<const Query> queue, double passes, std::size_t together) {
  std::vector<Query> batch;
  std::vector<History> made(together);
  for (std::size_t next = 0; next < queue.size();) {
    const std::size_t room = limit_ > 0 ? limit_ - std::min(limit_, size()) : together;
    if (room == 0) return;
    batch.clear();
    for (; next < queue.size() && batch.size() < std::min(room, together); ++next)
      if (!covered(*queue[next].point)) batch.push_back(queue[next]);
    parallel_for(batch.size(), 1, [&](std::size_t i) { made[i] = sample(context, radiance, batch[i], passes); });
    for (std::size_t i = 0; i < batch.size(); ++i) {
      Level& level = levels_[this->level(batch[i].point->depth)];
      if (limit_ == 0 || known_.emplace(batch[i].key, made[i]).second) count(Counter::records);
      insert(level.records, made[i]);
      level.histories.push_back(std::move(made[i]));
    }
  }
}

template <class Estimate, class Records>
auto RecordLevels<Estimate, Records>::sample(const RenderContext& context, const HemisphereRadiance& radiance,
                                             const Query& query, double passes) const -> History {
  if (const auto known = known_.find(query.key); known != known_.end()) return known->second;
  History history{*query.point, query.key, {}, 0};
  add_passes(context, radiance, history, passes);
  return history;
}

template <class Estimate, class Records>
void RecordLevels<Estimate, Records>::add_passes(const RenderContext& context, const HemisphereRadiance& radiance,
                                                 History& history, double passes) const {
  const auto target = static_cast<int>(passes + to_unit_float(static_cast<std::uint32_t>(hash_keys(history.key, 1u))));
  const int depth = static_cast<int>(level(history.point.depth)) + 1;
  while (history.passes < std::max(target, 1)) {
    const auto pass = static_cast<std::uint32_t>(history.passes++);
    Estimate next = estimate(context, radiance, history, depth, pass);
    if (pass == 0)
      history.mean = std::move(next);
    else
      history.mean.average_in(next, history.passes);
  }
}

template <class Estimate, class Records>
void RecordLevels<Estimate, Records>::refine(const RenderContext& context, const HemisphereRadiance& radiance, float accuracy,
                                             double passes, std::span<const CachePoint> wanted, std::uint32_t round) {
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

template <class Estimate, class Records>
void RecordLevels<Estimate, Records>::resume(const RenderContext& context, std::vector<std::vector<History>> levels,
                                             float accuracy, std::uint64_t key_salt) {
  key_salt_ = key_salt;
  for (const auto& histories : levels)
    for (const History& history : histories) bounds_.extend(history.point.position);
  while (levels_.size() < levels.size()) levels_.push_back({{}, make_records(context)});
  for (std::size_t i = 0; i < levels.size(); ++i) levels_[i].histories = std::move(levels[i]);
  rebuild(context, accuracy);
}

}  // namespace etendue
