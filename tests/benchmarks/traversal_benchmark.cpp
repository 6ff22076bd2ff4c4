// Single rays through every ray structure: primary, diffuse-bounce and shadow rays of built-in scenes, one thread. The answers
// are compared with brute force on a sample before anything is timed.
#include "accel/bvh/build/binned_sah.h"
#include "accel/bvh/bvh.h"
#include "accel/registry.h"
#include "experiments/kinds/structures/accel_rays.h"
#include "framework/io/load_scene.h"

#include <benchmark/benchmark.h>

#include <memory>

namespace etendue {
namespace {

struct Workload {
  Scene scene;
  RaysByKind rays;

  explicit Workload(const std::string& name) : scene(load_scene(name)) {
    rays = record_rays(scene, *find_ray_structure("binned-sah", {}).make(scene, {}), 128);
  }
};

const Workload& workload(const std::string& name) {
  static std::map<std::string, std::unique_ptr<Workload>> loaded;
  auto& entry = loaded[name];
  if (!entry) entry = std::make_unique<Workload>(name);
  return *entry;
}

bool agrees_with_brute_force(const RayQuery& structure, const Workload& work) {
  const auto brute = find_ray_structure("brute", {}).make(work.scene, {});
  for (const std::vector<Ray>& rays : work.rays)
    for (std::size_t i = 0; i < rays.size(); i += rays.size() / 50 + 1) {
      const Hit a = structure.closest(rays[i]), b = brute->closest(rays[i]);
      if (static_cast<bool>(a) != static_cast<bool>(b) || (a && std::abs(a.t - b.t) > 1e-4f * b.t)) return false;
    }
  return true;
}

void trace(benchmark::State& state, const std::string& scene, const std::string& structure, RayKind kind) {
  const Workload& work = workload(scene);
  const auto query = find_ray_structure(structure, {}).make(work.scene, {});
  if (!agrees_with_brute_force(*query, work)) return state.SkipWithError("differs from brute force");
  const std::vector<Ray>& rays = work.rays[static_cast<std::size_t>(kind)];
  std::vector<Hit> hits(rays.size());
  for (auto _ : state) {
    if (kind == RayKind::shadow)
      for (const Ray& ray : rays) benchmark::DoNotOptimize(query->occluded(ray));
    else
      query->closest(rays, hits);
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(rays.size()));
}

// The same without the interface, by the static type: what the one indirect call per query costs.
void trace_static(benchmark::State& state, const std::string& scene) {
  const Workload& work = workload(scene);
  const Geometry& geometry = work.scene.objects[0].geometry;
  const Bvh bvh(geometry, build_binned_sah(build_items(geometry), {}));
  const std::vector<Ray>& rays = work.rays[static_cast<std::size_t>(RayKind::diffuse)];
  for (auto _ : state)
    for (const Ray& ray : rays) benchmark::DoNotOptimize(bvh.closest(ray));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(rays.size()));
}

void trace_one_by_one(benchmark::State& state, const std::string& scene) {
  const Workload& work = workload(scene);
  const auto query = find_ray_structure("binned-sah", {}).make(work.scene, {});
  const std::vector<Ray>& rays = work.rays[static_cast<std::size_t>(RayKind::diffuse)];
  for (auto _ : state)
    for (const Ray& ray : rays) benchmark::DoNotOptimize(query->closest(ray));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(rays.size()));
}

const bool registered = [] {
  for (const char* scene : {"builtin:cornell-box", "builtin:mesh"}) {
    for (const RayEntry& entry : ray_structures()) {
      if (!entry.available || entry.name == "brute") continue;
      for (const RayKind kind : ray_kinds) {
        const std::string name = std::string("trace/") + scene + "/" + entry.name + "/" + ray_kind_name(kind);
        benchmark::RegisterBenchmark(name.c_str(), trace, scene, entry.name, kind)->Unit(benchmark::kMillisecond);
      }
    }
    const std::string suffix = std::string(scene) + "/binned-sah/diffuse";
    benchmark::RegisterBenchmark(("static_call/" + suffix).c_str(), trace_static, scene)->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(("indirect_call/" + suffix).c_str(), trace_one_by_one, scene)->Unit(benchmark::kMillisecond);
  }
  return true;
}();

}  // namespace
}  // namespace etendue
