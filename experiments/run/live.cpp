#include "experiments/run/live.h"

namespace etendue {

namespace {

constexpr std::uint32_t sampling = 256;  // queries of a thread, one of which is counted
constexpr std::size_t window = 60;       // iterations

// Tells which of the next `count` queries of this thread is to be counted; `count` itself where none is.
std::size_t sample_among(std::size_t count) {
  thread_local std::uint32_t left = sampling;
  if (count < left) {
    left -= static_cast<std::uint32_t>(count);
    return count;
  }
  const std::size_t chosen = left - 1;  // of a long span only the first one
  left = sampling;
  return chosen;
}

}  // namespace

void SampledRays::note(const TraversalCounters& counters, bool is_full) const {
  const std::uint64_t tests = counters.nodes + counters.primitives;
  rays_counted_.fetch_add(1, std::memory_order_relaxed);
  tests_.fetch_add(tests, std::memory_order_relaxed);
  if (!is_full) return;
  full_rays_.fetch_add(1, std::memory_order_relaxed);
  full_tests_.fetch_add(tests, std::memory_order_relaxed);
}

Hit SampledRays::closest_counted(const Ray& ray, TraversalCounters& counters) const {
  return rays_.closest_counted(ray, counters);
}

bool SampledRays::occluded_counted(const Ray& ray, TraversalCounters& counters) const {
  return rays_.occluded_counted(ray, counters);
}

Hit SampledRays::closest(const Ray& ray) const {
  if (sample_among(1) == 1) return rays_.closest(ray);
  TraversalCounters counters;
  const Hit hit = rays_.closest_counted(ray, counters);
  note(counters, true);
  return hit;
}

bool SampledRays::occluded(const Ray& ray) const {
  if (sample_among(1) == 1) return rays_.occluded(ray);
  TraversalCounters counters;
  const bool occluded = rays_.occluded_counted(ray, counters);
  note(counters, !occluded);
  return occluded;
}

// The sampled one is traced twice, so that the others stay together.
void SampledRays::closest(std::span<const Ray> rays, std::span<Hit> hits) const {
  rays_.closest(rays, hits);
  const std::size_t sample = sample_among(rays.size());
  if (sample == rays.size()) return;
  TraversalCounters counters;
  rays_.closest_counted(rays[sample], counters);
  note(counters, true);
}

void SampledRays::occluded(std::span<const Ray> rays, std::span<bool> occluded) const {
  rays_.occluded(rays, occluded);
  const std::size_t sample = sample_among(rays.size());
  if (sample == rays.size()) return;
  TraversalCounters counters;
  rays_.occluded_counted(rays[sample], counters);
  note(counters, !occluded[sample]);
}

std::uint64_t brute_force_tests(const Scene& scene) {
  std::uint64_t tests = scene.planes.size();
  for (const Instance& instance : scene.instances) tests += scene.objects[instance.object].geometry.primitive_count();
  return tests;
}

void LiveWindow::mark(double time_s, const CounterValues& counters, const SampledRays::Work& work) {
  const auto of = [&](Counter counter) { return counters[static_cast<std::size_t>(counter)]; };
  moments_.push_back({time_s, of(Counter::rays) + of(Counter::shadow_rays), work});
  if (moments_.size() > window + 1) moments_.pop_front();
}

LiveFigures LiveWindow::figures() const {
  if (moments_.empty()) return {};
  const Moment &first = moments_.front(), &last = moments_.back();
  const auto growth = [&](std::uint64_t SampledRays::Work::*sum) {
    return static_cast<double>(last.work.*sum - first.work.*sum);
  };
  LiveFigures figures;
  if (last.time_s > first.time_s)
    figures.rays_per_s = static_cast<double>(last.rays - first.rays) / (last.time_s - first.time_s);
  if (const double tests = growth(&SampledRays::Work::tests); tests > 0)
    figures.tests_per_ray = tests / growth(&SampledRays::Work::rays);
  if (const double rays = growth(&SampledRays::Work::full_rays); rays > 0 && figures.tests_per_ray && brute_force_ > 0)
    figures.tests_saved = 1 - growth(&SampledRays::Work::full_tests) / (rays * brute_force_);
  return figures;
}

}  // namespace etendue
