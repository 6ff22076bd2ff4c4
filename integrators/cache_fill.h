// Fills levels of records so that what the camera sees is covered ([Ward1988]'s overture).
//
// In an overture over pixel centres on grids of 256, 128, ... 1 pixels, each pass looks for points that no record covers and
// takes them in an order drawn by hash, in batches of 64 (the seed draws the order and where the grids lie, so that the scatter
// over seeds is that of the records' places too): a batch is computed in parallel, then inserted in its order. Points
// of one batch do not see each other; the few records more cost nothing but room. As clamping shortens what records reach, a
// last pass looks at every pixel again. Thus the records do not depend on threads.
//
// A given number of records is met by bisecting the accuracy. What a point's hemisphere saw does not depend on it, so that each
// point is sampled once, however often the overture is played.
#pragma once

#include "integrators/cache_points.h"
#include "integrators/irradiance_records.h"
#include "integrators/path.h"

#include <functional>
#include <unordered_map>

namespace etendue {

// Irradiance at a point that has no hemisphere, with `depth` events before what it reflects.
using PointIrradiance = std::function<IrradianceEstimate(const CachePoint& point, int depth)>;

struct CacheSettings {
  CacheMetric metric = CacheMetric::bounded_split_sphere;
  Gradients gradients = Gradients::both;
  bool clamping = true;
  float accuracy = 0.2f;     // at which the spacings hold
  float min_spacing = 1.5f;  // pixels
  float max_spacing = 0.1f;  // scene diagonals
  float scene_size = 1;      // metres
  float stretch = 1;         // see irradiance_records.h
  float overlap = 1;         // likewise
  HemisphereStrata strata;
  SamplerKind sampler = SamplerKind::sobol;
  std::string structure = "cells";
  PointIrradiance at_point;  // in place of hemispheres; none: hemispheres are sampled
};

// Radiance arriving along the first rays of paths with `depth` events behind them.
using HemisphereRadiance = std::function<void(std::span<PathSample> paths, int depth)>;

// A direction in stratum i by u, about the z axis.
using StratumDirection = vec3 (*)(const HemisphereStrata& strata, int i, const vec2& u);

// One ray in each stratum of the hemisphere over a point; black where it goes below the surface. Pass `pass` of `key`: passes
// of different keys or numbers are independent. The samples are this thread's, until it traces the next hemisphere.
std::span<const HemisphereSample> trace_hemisphere(const RenderContext& context, SamplerKind kind, const CachePoint& point,
                                                   const Frame& frame, int depth, std::uint64_t key, std::uint32_t pass,
                                                   const HemisphereStrata& strata, StratumDirection direction,
                                                   const HemisphereRadiance& radiance);
// Irradiance and its derivatives by such a pass.
IrradianceEstimate sample_hemisphere(const RenderContext& context, const CacheSettings& settings, const CachePoint& point,
                                     int depth, std::uint64_t key, std::uint32_t pass, const HemisphereRadiance& radiance);

// What a record was made of.
struct RecordHistory {
  CachePoint point;
  std::uint64_t key = 0;    // of its random numbers
  IrradianceEstimate mean;  // of its passes
  int passes = 1;
};

// Records by level; a point belongs to the level of its depth, or all to one.
class CacheLevels {
 public:
  // `pixels`: what their centres see.
  CacheLevels(const RenderContext& context, const CacheSettings& settings, std::vector<CachePoint> pixels, bool one_level);

  // Forgets all records.
  void clear(const RenderContext& context);
  // Covers all pixels at an accuracy with records added to those there are.
  void fill(const RenderContext& context, const HemisphereRadiance& radiance, float accuracy);
  // The same, anew, with at most `records` records, and at least 98 % of them where the metric's bounds permit.
  void fill_to(const RenderContext& context, const HemisphereRadiance& radiance, std::size_t records);
  // Every record is brought to `passes` passes over its hemisphere (a fraction is met by as many more records) and judged anew;
  // then `wanted` points, keyed by their index and `round`, are covered at `accuracy` where they are not yet.
  void refine(const RenderContext& context, const HemisphereRadiance& radiance, float accuracy, double passes,
              std::span<const CachePoint> wanted, std::uint32_t round);

  // Records made earlier, in their order, in place of those there are. A `key_salt` other than 0 keeps the random numbers of
  // points that are filled from now on apart from those of earlier views.
  void resume(const RenderContext& context, std::vector<std::vector<RecordHistory>> levels, float accuracy,
              std::uint64_t key_salt);
  std::vector<std::span<const RecordHistory>> histories() const;  // by level
  std::vector<RecordDisc> discs() const;

  // Empty where no record serves.
  std::optional<Interpolated> interpolate(int depth, const vec3& position, const vec3& normal) const;
  std::size_t size() const;
  float accuracy() const { return accuracy_; }

 private:
  struct Level {
    std::vector<RecordHistory> histories;
    IrradianceRecords records;
  };
  struct Query {
    std::uint64_t key;  // of random numbers
    const CachePoint* point;
  };

  void rebuild(const RenderContext& context, float accuracy);
  IrradianceRecords make_records(const RenderContext& context) const;
  IrradianceRecord record_of(const RecordHistory& history) const;
  template <class Wanted>
  void fill_where(const RenderContext& context, const HemisphereRadiance& radiance, const Wanted& wanted);
  void cover(const RenderContext& context, const HemisphereRadiance& radiance, std::vector<Query> queue, double passes);
  RecordHistory sample(const RenderContext& context, const HemisphereRadiance& radiance, const Query& query,
                       double passes) const;
  void add_passes(const RenderContext& context, const HemisphereRadiance& radiance, RecordHistory& history,
                  double passes) const;
  bool covered(const CachePoint& point) const;
  std::size_t level(int depth) const { return one_level_ ? 0 : static_cast<std::size_t>(depth); }

  CacheSettings settings_;
  float accuracy_;
  bool one_level_;
  Bounds bounds_;
  std::vector<CachePoint> pixels_;
  std::vector<Level> levels_;
  std::uint64_t key_salt_ = 0;
  std::size_t limit_ = 0;                                       // records at most; 0: none
  std::unordered_map<std::uint64_t, RecordHistory> histories_;  // by key, while bisecting
};

}  // namespace etendue
