// Shared by measurements: rays recorded from a render, work timed in turns, ratios with their quartiles.
#pragma once

#include "accel/registry.h"
#include "experiments/kinds/claims/claim.h"
#include "experiments/kinds/structures/accel_timing.h"
#include "framework/scene/scene.h"

namespace etendue {

// The rays on which variants are compared: primary and diffuse ones ask for the closest hit, shadow rays for any.
struct ClaimRays {
  std::vector<Ray> closest, shadow;
};

// Recorded from a render (accel_rays.h), about resolution^2 of each kind.
ClaimRays record_claim_rays(const Scene& scene, int resolution);

// At most `count` of them, evenly spread.
std::vector<Ray> every_nth(const std::vector<Ray>& rays, std::size_t count);

std::unique_ptr<RayQuery> make_structure(const Scene& scene, const std::string& name, const ParamMap& params = {});
ParamMap text_param(const char* key, const std::string& value);
ParamMap whole_param(const char* key, std::int64_t value);

// Stores answers where the compiler must assume that they are read.
template <class T>
void keep_answer(const T& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

// All of the rays.
template <class Structure>
void trace_rays(const Structure& structure, const ClaimRays& rays) {
  float sum = 0;
  for (const Ray& ray : rays.closest) sum += structure.closest(ray).t < infinity;
  for (const Ray& ray : rays.shadow) sum += structure.occluded(ray);
  keep_answer(sum);
}

// As many of them, evenly spread, as take about so long, at least 64 of each kind; for variants that would take minutes.
template <class Structure>
ClaimRays affordable_sample(const Structure& structure, const ClaimRays& rays, double seconds) {
  constexpr std::size_t least = 64;
  const ClaimRays trial{every_nth(rays.closest, least), every_nth(rays.shadow, least)};
  const double trial_s = seconds_of([&] { trace_rays(structure, trial); });
  const double share =
      std::max(1.0, seconds / trial_s) * least / static_cast<double>(std::max<std::size_t>(1, rays.closest.size()));
  const auto of = [&](const std::vector<Ray>& all) {
    return every_nth(all, static_cast<std::size_t>(std::ceil(share * static_cast<double>(all.size()))));
  };
  return {of(rays.closest), of(rays.shadow)};
}

// Seconds of each task in each repetition, after one warm-up. Tasks take turns, and each repetition starts with the next one.
using Times = std::vector<std::vector<double>>;
Times take_turns(const MeasureTask& task, const std::vector<std::function<void()>>& works);

// Repetition by repetition a over b.
Measured ratio_of(const std::vector<double>& a, const std::vector<double>& b);

template <class Closest>
std::function<void()> tracing(const std::vector<Ray>& rays, const Closest& closest) {
  return [&rays, closest] {
    float sum = 0;
    for (const Ray& ray : rays) sum += closest(ray).t < infinity;
    keep_answer(sum);
  };
}

// Rays for which closest(ray) gives another distance or primitive than the product.
template <class Closest>
std::uint64_t count_disagreements(const RayQuery& product, const std::vector<Ray>& rays, const Closest& closest) {
  std::uint64_t count = 0;
  for (const Ray& ray : rays) {
    const Hit a = product.closest(ray), b = closest(ray);
    count += a.t != b.t || a.primitive != b.primitive || a.instance != b.instance;
  }
  return count;
}

}  // namespace etendue
