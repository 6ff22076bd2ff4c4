#include "experiments/kinds/structures/accel_timing.h"

#include "experiments/kinds/timing.h"

#include <memory>

namespace etendue {

namespace {

template <class Trace>
double rate(std::size_t rays, const Trace& trace) {
  if (rays == 0) return 0;
  return 1e-6 * static_cast<double>(rays) / std::max(1e-9, seconds_of(trace));
}

void trace_singly(const RayQuery& structure, RayKind kind, std::span<const Ray> rays, std::vector<Hit>& hits) {
  hits.resize(rays.size());
  if (kind == RayKind::shadow) {
    std::size_t occluded = 0;
    for (const Ray& ray : rays) occluded += structure.occluded(ray);
    keep_answer(occluded);
  } else {
    for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = structure.closest(rays[i]);
    keep_answer(hits.data());
  }
}

}  // namespace

double mrays_per_s(const RayQuery& structure, RayKind kind, std::span<const Ray> rays) {
  std::vector<Hit> hits(rays.size());
  return rate(rays.size(), [&] { trace_singly(structure, kind, rays, hits); });
}

double batched_mrays_per_s(const RayQuery& structure, RayKind kind, std::span<const Ray> rays) {
  if (kind == RayKind::shadow) {
    const std::unique_ptr<bool[]> occluded(new bool[rays.size()]());
    return rate(rays.size(), [&] {
      structure.occluded(rays, std::span(occluded.get(), rays.size()));
      keep_answer(occluded.get());
    });
  }
  std::vector<Hit> hits(rays.size());
  return rate(rays.size(), [&] {
    structure.closest(rays, hits);
    keep_answer(hits.data());
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
