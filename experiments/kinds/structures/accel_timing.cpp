#include "experiments/kinds/structures/accel_timing.h"

#include "experiments/statistics/statistics.h"

#include <chrono>
#include <memory>

namespace etendue {

namespace {

// Answers are kept where the compiler must suppose them read, so that no query can be left out.
template <class T>
void keep(const T& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

double rate(std::size_t rays, const std::function<void()>& trace) {
  if (rays == 0) return 0;
  return 1e-6 * static_cast<double>(rays) / std::max(1e-9, seconds_of(trace));
}

void trace_singly(const RayQuery& structure, RayKind kind, std::span<const Ray> rays, std::vector<Hit>& hits) {
  hits.resize(rays.size());
  if (kind == RayKind::shadow) {
    std::size_t occluded = 0;
    for (const Ray& ray : rays) occluded += structure.occluded(ray);
    keep(occluded);
  } else {
    for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = structure.closest(rays[i]);
    keep(hits.data());
  }
}

}  // namespace

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Measured summarise(std::span<const double> values) {
  if (values.empty()) return {};
  return {median(values), quantile(values, 0.25), quantile(values, 0.75)};
}

std::vector<double> ratios(std::span<const double> a, std::span<const double> b) {
  std::vector<double> result;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    if (b[i] > 0) result.push_back(a[i] / b[i]);
  return result;
}

double mrays_per_s(const RayQuery& structure, RayKind kind, std::span<const Ray> rays) {
  std::vector<Hit> hits(rays.size());
  return rate(rays.size(), [&] { trace_singly(structure, kind, rays, hits); });
}

double batched_mrays_per_s(const RayQuery& structure, RayKind kind, std::span<const Ray> rays) {
  if (rays.empty()) return 0;
  if (kind == RayKind::shadow) {
    const std::unique_ptr<bool[]> occluded(new bool[rays.size()]());
    bool asked = false;
    const double speed =
        rate(rays.size(), [&] { asked = ask_occluded(structure, rays, std::span(occluded.get(), rays.size())); });
    keep(occluded[0]);
    return asked ? speed : 0;
  }
  std::vector<Hit> hits(rays.size());
  return rate(rays.size(), [&] {
    structure.closest(rays, hits);
    keep(hits.data());
  });
}

std::size_t affordable_rays(const RayQuery& structure, RayKind kind, std::span<const Ray> rays, double seconds) {
  constexpr double enough = 2e-3;  // seconds that make a trial
  std::vector<Hit> hits;
  for (std::size_t trial = 4; trial < rays.size(); trial *= 4) {
    double time = infinity;  // the least of three: a pause of the machine is not the structure's
    for (int i = 0; i < 3 && time >= enough; ++i)
      time = std::min(time, seconds_of([&] { trace_singly(structure, kind, rays.first(trial), hits); }));
    if (time < enough) continue;
    return std::min(rays.size(), static_cast<std::size_t>(seconds / time * static_cast<double>(trial)));
  }
  return rays.size();
}

}  // namespace etendue
