// Paths that end at the first surface which an irradiance cache covers: its records answer for all further bounces, so that the
// hemispheres of new records cost a few events a ray.
//
// A record holds light of as many scattering events as its own depth leaves it, but where a path ends some of these events have
// happened already: it would count paths that are longer than the depth limit allows. The share of a record's light that one
// event less would leave hardly varies over most scenes, because after some bounces light of any further event has nearly the
// same distribution. So it is measured once for each level of records, as a mean over a few points, and the record's light is
// multiplied by it. Where it varies (a white room beside a dark one, a limit of two or three events), paths do not end in
// records: a share that is 0.02 off is amplified by all bounces. Beyond `shared_above` events the limit no longer matters.
#pragma once

#include "integrators/caches/cache_fill.h"
#include "integrators/paths/path.h"

#include <optional>
#include <vector>

namespace etendue {

class TerminateInCache final : public PathEnd {
 public:
  // Ends paths in the level of `depth`. `cache_direct`: records hold direct light too. `kept`: of that level, see
  // kept_below_limit; none: the limit does not matter.
  TerminateInCache(const Scene& scene, const CacheLevels& cache, int depth, bool cache_direct, const std::optional<Rgb>& kept);

  std::optional<Rgb> reflected(const SurfacePoint& point, const Diffuse& material, const vec3& wo, int depth) const override;

 private:
  const Scene& scene_;
  const CacheLevels& cache_;
  int depth_;
  std::optional<Rgb> kept_;
};

// The share of the irradiance in records of each level that a depth limit of one event less than theirs would leave, per
// channel in [0, 1]: those of level l have paths.max_depth - l. It is found by path tracing from at most 32 of the points
// `seen`, with the same random numbers for all limits. Empty where the limit does not matter; levels are missing from the first
// on of which nothing is seen, where light is found at fewer than eight points, or where the share surely varies by more than
// 0.02 over them.
std::vector<Rgb> kept_below_limit(const RenderContext& context, CacheSettings settings, std::span<const CachePoint> seen,
                                  const PathSettings& paths, bool cache_direct, const PathCaustics* caustics);

}  // namespace etendue
