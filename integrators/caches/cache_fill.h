// Irradiance records over what the camera sees: how hemispheres are sampled for them, and levels of them (record_levels.h).
//
// A given number of records is met by bisecting the accuracy. A point's hemisphere sees the same at any accuracy, so each point
// is sampled once, however often the placement of records is repeated.
#pragma once

#include "integrators/caches/records/irradiance_records.h"
#include "integrators/caches/records/record_levels.h"

namespace etendue {

// Irradiance at a point that has no hemisphere, with `depth` events before what it reflects.
using PointIrradiance = std::function<IrradianceEstimate(const CachePoint& point, int depth)>;

struct CacheSettings : RecordSettings {
  CacheMetric metric = CacheMetric::bounded_split_sphere;
  Gradients gradients = Gradients::both;
  bool clamping = true;
  bool overture = true;
  float scene_size = 1;         // metres
  float stretch = 1;            // see irradiance_records.h
  PointIrradiance at_point;     // in place of hemispheres; none: hemispheres are sampled
  bool judges_by_rays = false;  // with `at_point`: hemispheres say how far a record serves, and that what it holds
};

// Traces one ray in each stratum of the hemisphere over a point; a sample is black where its ray would go below the surface.
// `even`: strata are even over solid angle, else over projected solid angle.
// Passes of different `key` or number `pass` are independent. The span refers to a buffer of this thread, valid until the
// thread traces its next hemisphere.
std::span<const HemisphereSample> trace_hemisphere(const RenderContext& context, SamplerKind kind, const CachePoint& point,
                                                   const Frame& frame, int depth, std::uint64_t key, std::uint32_t pass,
                                                   const HemisphereStrata& strata, bool even,
                                                   const HemisphereRadiance& radiance);
// Irradiance and its derivatives by such a pass.
IrradianceEstimate sample_hemisphere(const RenderContext& context, const CacheSettings& settings, const CachePoint& point,
                                     int depth, std::uint64_t key, std::uint32_t pass, const HemisphereRadiance& radiance);

using RecordHistory = RecordHistoryOf<IrradianceEstimate>;

class CacheLevels final : public RecordLevels<IrradianceEstimate, IrradianceRecords> {
 public:
  // `pixels`: what their centres see.
  CacheLevels(const RenderContext& context, const CacheSettings& settings, std::vector<CachePoint> pixels, bool one_level);

  // Like fill, from the start, with at most `records` records, and at least 98 % of that number where the metric's bounds
  // permit.
  void fill_to(const RenderContext& context, const HemisphereRadiance& radiance, std::size_t records);

  // The rays of a pass from now on.
  void take_rays(int samples) { settings_.strata = HemisphereStrata::of(samples); }
  // Names the noise that estimates share from now on (IrradianceEstimate::source).
  void set_source(std::uint32_t source) { source_ = source; }

  std::vector<RecordShape> shapes() const;
  // Empty where no record serves.
  std::optional<Interpolated> interpolate(int depth, const vec3& position, const vec3& normal, bool states_error = false) const;

 private:
  IrradianceRecords make_records(const RenderContext& context) const override;
  void insert(IrradianceRecords& records, const RecordHistory& history) const override;
  IrradianceEstimate estimate(const RenderContext& context, const HemisphereRadiance& radiance, const RecordHistory& history,
                              int depth, std::uint32_t pass) const override;

  CacheSettings settings_;
  std::uint32_t source_ = 0;
};

}  // namespace etendue
