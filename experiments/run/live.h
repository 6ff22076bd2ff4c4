// Figures that a watched run tells of itself while it goes on: rays per second, the work of a sample of them, and the error. A
// run that nobody watches has none of this: its integrators query their structure directly.
#pragma once

#include "framework/core/counters.h"
#include "framework/query.h"
#include "framework/scene/scene.h"

#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>

namespace etendue {

struct LiveFigures {
  // Means over the last 60 iterations, or as many as there were.
  double rays_per_s = 0;
  std::optional<double> tests_per_ray;  // node visits and primitive tests; nothing where the structure cannot tell
  // The share of tests that the structure spares a ray which brute force would test against every primitive: one that looks
  // for the nearest hit, or that nothing blocks.
  std::optional<double> tests_saved;
  std::optional<double> error;  // relmse of the image so far, where there is a reference
};

// A structure of which every 256th query of a thread, nearly, is counted as well. The answers are those of the structure.
class SampledRays final : public RayQuery {
 public:
  explicit SampledRays(const RayQuery& rays) : rays_(rays) {}

  Hit closest(const Ray& ray) const override;
  bool occluded(const Ray& ray) const override;
  void closest(std::span<const Ray> rays, std::span<Hit> hits) const override;
  void occluded(std::span<const Ray> rays, std::span<bool> occluded) const override;
  Hit passed_light(const Ray& ray) const override { return rays_.passed_light(ray); }
  Hit closest_counted(const Ray& ray, TraversalCounters& counters) const override;
  bool occluded_counted(const Ray& ray, TraversalCounters& counters) const override;
  RayStructureStats stats() const override { return rays_.stats(); }

  // Sums over the samples; of `full` are those that brute force would test against every primitive.
  struct Work {
    std::uint64_t rays = 0, tests = 0, full_rays = 0, full_tests = 0;
  };
  Work work() const { return {rays_counted_, tests_, full_rays_, full_tests_}; }

 private:
  void note(const TraversalCounters& counters, bool is_full) const;

  const RayQuery& rays_;
  mutable std::atomic<std::uint64_t> rays_counted_ = 0, tests_ = 0, full_rays_ = 0, full_tests_ = 0;
};

// The tests of a ray by brute force: every primitive of every instance, and every plane.
std::uint64_t brute_force_tests(const Scene& scene);

// Keeps what the last 60 iterations did.
class LiveWindow {
 public:
  explicit LiveWindow(const Scene& scene) : brute_force_(static_cast<double>(brute_force_tests(scene))) {}

  // It is called before the first iteration and after each.
  void mark(double time_s, const CounterValues& counters, const SampledRays::Work& work);
  LiveFigures figures() const;

 private:
  struct Moment {
    double time_s = 0;
    std::uint64_t rays = 0;
    SampledRays::Work work;
  };
  double brute_force_;
  std::deque<Moment> moments_;  // the first one is where the window begins
};

}  // namespace etendue
