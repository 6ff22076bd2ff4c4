// Builds of ray structures over a bumpy sphere, one thread: the whole structure as the registry makes it, and each builder's
// tree alone.
#include "accel/bvh/build/binned_sah.h"
#include "accel/bvh/build/lbvh.h"
#include "accel/bvh/build/median.h"
#include "accel/bvh/build/median_round_robin.h"
#include "accel/bvh/build/midpoint.h"
#include "accel/bvh/build/ploc.h"
#include "accel/bvh/build/sah.h"
#include "accel/registry.h"

#include <benchmark/benchmark.h>

namespace etendue {
namespace {

// 2 n^2 triangles of a sphere whose radius varies, without a gap.
Scene bumpy_sphere(std::uint32_t n) {
  Scene scene;
  Geometry& g = scene.objects[0].geometry;
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t j = 0; j <= n; ++j) {
      const float theta = pi * static_cast<float>(i) / static_cast<float>(n),
                  phi = 2 * pi * static_cast<float>(j) / static_cast<float>(n);
      const float r = 1 + 0.1f * std::sin(9 * theta) * std::sin(7 * phi);
      g.positions.push_back(r * vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)));
    }
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t a = i * (n + 1) + j, b = a + n + 1;
      g.triangles.push_back({a, b, a + 1});
      g.triangles.push_back({a + 1, b, b + 1});
    }
  return scene;
}

void build_structure(benchmark::State& state, const std::string& name) {
  const Scene scene = bumpy_sphere(static_cast<std::uint32_t>(state.range(0)));
  const RayEntry& entry = find_ray_structure(name, {});
  const auto triangles = static_cast<double>(scene.objects[0].geometry.triangles.size());
  RayStructureStats stats;
  for (auto _ : state) stats = entry.make(scene, {})->stats();
  state.counters["triangles"] = triangles;
  state.counters["bytes_per_triangle"] = static_cast<double>(stats.bytes) / triangles;
  state.counters["sah_cost"] = stats.sah_cost;
}

template <class Build>
void build_tree(benchmark::State& state, const Build& build) {
  const Scene scene = bumpy_sphere(static_cast<std::uint32_t>(state.range(0)));
  const BuildItems items = build_items(scene.objects[0].geometry);
  for (auto _ : state) benchmark::DoNotOptimize(build(items).nodes.size());
  state.counters["triangles"] = static_cast<double>(items.size());
}

const bool registered = [] {
  for (const RayEntry& entry : ray_structures())
    if (entry.available)
      benchmark::RegisterBenchmark(("build/" + entry.name).c_str(), build_structure, entry.name)
          ->Arg(32)
          ->Arg(224)  // 100,352 triangles
          ->Unit(benchmark::kMillisecond);
  const auto tree = [](const char* name, auto build) {
    benchmark::RegisterBenchmark(name, build_tree<decltype(build)>, build)->Arg(224)->Unit(benchmark::kMillisecond);
  };
  tree("tree/median", [](const BuildItems& items) { return build_median(items, {}); });
  tree("tree/median-round-robin", [](const BuildItems& items) { return build_median_round_robin(items, {}); });
  tree("tree/midpoint", [](const BuildItems& items) { return build_midpoint(items, {}); });
  tree("tree/lbvh", [](const BuildItems& items) { return build_lbvh(items, {}); });
  tree("tree/ploc", [](const BuildItems& items) { return build_ploc(items, {}); });
  tree("tree/sah", [](const BuildItems& items) { return build_sah(items, {}); });
  for (const int bins : {4, 8, 16, 32, 64, 256}) {
    BinnedSahParams params;
    params.bins = bins;
    tree(("tree/binned-sah/bins:" + std::to_string(bins)).c_str(),
         [params](const BuildItems& items) { return build_binned_sah(items, params); });
  }
  return true;
}();

}  // namespace
}  // namespace etendue
