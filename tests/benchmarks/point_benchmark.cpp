// Gathers: points on two perpendicular squares with a dense spot on one (photons under a caustic), queried on the surfaces
// themselves by radius and by number. One thread.
#include "accel/registry.h"
#include "framework/core/rng.h"

#include <benchmark/benchmark.h>

namespace etendue {
namespace {

std::vector<vec3> photons(std::size_t count) {
  Pcg32 random(1, 1);
  std::vector<vec3> points(count);
  for (std::size_t i = 0; i < count; ++i) {
    const vec2 u(random.next_float(), random.next_float());
    points[i] = i % 4 == 0 ? vec3(0, u) : i % 4 == 1 ? vec3(0.5f + 0.05f * u, 0) : vec3(u, 0);
  }
  return points;
}

// Every 97th photon's position, a little beside it.
std::vector<vec3> queries(const std::vector<vec3>& points) {
  std::vector<vec3> result;
  for (std::size_t i = 0; i < points.size(); i += 97) result.push_back(points[i] + vec3(1e-4f, -1e-4f, 0));
  return result;
}

// The radius that holds `expected` photons where they are even.
float radius_for(std::size_t count, float expected) { return std::sqrt(expected / (0.5f * static_cast<float>(count) * pi)); }

void build(benchmark::State& state, const std::string& name) {
  const std::vector<vec3> points = photons(static_cast<std::size_t>(state.range(0)));
  const auto structure = find_point_structure(name, {}).make();
  for (auto _ : state) structure->build(points);
  state.SetItemsProcessed(state.iterations() * state.range(0));
  state.counters["bytes_per_point"] = static_cast<double>(structure->bytes()) / static_cast<double>(points.size());
}

void within(benchmark::State& state, const std::string& name) {
  const std::vector<vec3> points = photons(static_cast<std::size_t>(state.range(0))), where = queries(points);
  const float r = radius_for(points.size(), static_cast<float>(state.range(1)));
  const auto structure = find_point_structure(name, {}).make(), brute = find_point_structure("brute", {}).make();
  structure->build(points);
  brute->build(points);
  Neighbours found, expected;
  structure->within(where[5], r, found);
  brute->within(where[5], r, expected);
  if (found.size() != expected.size()) return state.SkipWithError("differs from brute force");
  std::size_t i = 0, gathered = 0;
  for (auto _ : state) {
    structure->within(where[i++ % where.size()], r, found);
    gathered += found.size();
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["found"] = static_cast<double>(gathered) / static_cast<double>(state.iterations());
}

void nearest(benchmark::State& state, const std::string& name) {
  const std::vector<vec3> points = photons(static_cast<std::size_t>(state.range(0))), where = queries(points);
  const auto structure = find_point_structure(name, {}).make();
  structure->build(points);
  Neighbours found;
  std::size_t i = 0;
  for (auto _ : state) {
    structure->nearest(where[i++ % where.size()], static_cast<std::size_t>(state.range(1)), infinity, found);
    if (found.size() != static_cast<std::size_t>(state.range(1))) return state.SkipWithError("too few found");
  }
  state.SetItemsProcessed(state.iterations());
}

const bool registered = [] {
  for (const PointEntry& entry : point_structures()) {
    if (entry.name == "brute") continue;
    benchmark::RegisterBenchmark(("points_build/" + entry.name).c_str(), build, entry.name)
        ->Arg(100000)
        ->Arg(1000000)
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(("points_within/" + entry.name).c_str(), within, entry.name)
        ->Args({200000, 1})
        ->Args({200000, 10})
        ->Args({200000, 50})
        ->Args({200000, 500});
    benchmark::RegisterBenchmark(("points_nearest/" + entry.name).c_str(), nearest, entry.name)
        ->Args({200000, 1})
        ->Args({200000, 50})
        ->Args({200000, 500});
  }
  return true;
}();

}  // namespace
}  // namespace etendue
