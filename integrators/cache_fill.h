// Fills levels of records so that what the camera sees is covered ([Ward1988]'s overture).
//
// In an overture over pixel centres on grids of 64, 32, ... 1 pixels, each pass looks for points that no record covers and
// takes them in an order drawn by hash, in batches of 64: a batch is computed in parallel, then inserted in its order. Points
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

struct CacheSettings {
  CacheMetric metric = CacheMetric::bounded_split_sphere;
  Gradients gradients = Gradients::both;
  bool clamping = true;
  float accuracy = 0.2f;
  float min_spacing = 1.5f;  // pixels
  float max_spacing = 0.1f;  // scene diagonals
  float scene_size = 1;      // metres
  HemisphereStrata strata;
  SamplerKind sampler = SamplerKind::sobol;
  std::string structure = "octree";
};

// Radiance arriving along the first rays of paths with `depth` events behind them.
using HemisphereRadiance = std::function<void(std::span<PathSample> paths, int depth)>;

// Pass `pass` of the hemisphere over a point; passes of different keys or numbers are independent.
IrradianceEstimate sample_hemisphere(const RenderContext& context, const CacheSettings& settings, const CachePoint& point,
                                     int depth, std::uint64_t key, std::uint32_t pass, const HemisphereRadiance& radiance);

// Records by level; a point belongs to the level of its depth, or all to one.
class CacheLevels {
 public:
  CacheLevels(const RenderContext& context, const CacheSettings& settings, std::vector<CachePoint> pixels, bool one_level);

  // Covers all pixels at the settings' accuracy.
  void fill(const RenderContext& context, const HemisphereRadiance& radiance);
  // The same with at most `records` records, and at least 98 % of them where the metric's bounds permit.
  void fill_to(const RenderContext& context, const HemisphereRadiance& radiance, std::size_t records);

  // Empty where no record serves.
  std::optional<Rgb> interpolate(int depth, const vec3& position, const vec3& normal) const;
  std::size_t size() const;
  float accuracy() const { return settings_.accuracy; }

 private:
  void clear(const RenderContext& context, float accuracy);
  template <class Wanted>
  void fill_where(const RenderContext& context, const HemisphereRadiance& radiance, const Wanted& wanted);
  std::size_t level(int depth) const { return one_level_ ? 0 : static_cast<std::size_t>(depth); }
  MetricContext metric_context(const CachePoint& point) const;

  CacheSettings settings_;
  bool one_level_;
  Bounds bounds_;
  std::vector<CachePoint> pixels_;
  std::vector<IrradianceRecords> levels_;
  std::size_t limit_ = 0;                                            // records at most; 0: none
  std::unordered_map<std::uint32_t, IrradianceEstimate> estimates_;  // by pixel, while bisecting
};

}  // namespace etendue
