// Claims about builders ask which tree is best. All trees are traversed alike, in the `binary` layout; where it matters in
// `bvh16` too.
#include "experiments/kinds/claims/measurement.h"
#include "experiments/kinds/claims/naive_loop.h"
#include "experiments/statistics/statistics.h"

#include <fmt/format.h>

namespace etendue {

namespace {

void measure_builders(Trial& t) {
  t.race_structures(t.record_rays());
  const auto wide = [&](const std::string& name) { return t.ratio(name + " layout=bvh16", "sah layout=bvh16").median; };
  t.remark(
      fmt::format("{} in the bvh16 layout: median {:.2f}×, midpoint {:.2f}×.", t.task.scene, wide("median"), wide("midpoint")));
}

void measure_bins(Trial& t) {
  t.race_structures(t.record_rays());
  t.count("cost_of_16", t.make("binned-sah bins=16").stats().sah_cost / t.make("sah").stats().sah_cost);
}

// Builds and traces one frame of the scene with more and more objects: from how many on does the one take less than the other?
// A ladder of factor two; between its steps the ratio of times is interpolated in logarithms. The last crossing counts.
struct Crossing {
  double at = 0;
  bool found = false;
};

Crossing last_crossing(const std::vector<double>& sizes, const std::vector<double>& ratio) {
  for (std::size_t i = sizes.size() - 1; i > 0 && ratio[i] < 1; --i) {
    if (ratio[i - 1] < 1) continue;
    return {equality_between(sizes[i - 1], std::log(ratio[i - 1]), sizes[i], std::log(ratio[i])), true};
  }
  return {ratio.back() < 1 ? sizes.front() : sizes.back(), ratio.back() < 1};
}

// `works(scene, rays)` gives the challenger and the champion.
template <class Works>
void count_crossing(Trial& t, const char* quantity, const std::vector<double>& sizes, const Works& works) {
  std::vector<std::vector<double>> ratio(static_cast<std::size_t>(t.task.repetitions));
  for (const double size : sizes) {
    MeasureTask sized = t.task;
    sized.scene = fmt::format("{}?count={}", t.task.scene, size);
    const Trial of_size(sized, {});
    const TrialRays rays = of_size.record_rays(std::max(8, t.task.resolution / 2));
    const Times times = take_turns(works(of_size.scene, rays), t.task.repetitions, t.task.progress);
    for (std::size_t r = 0; r < ratio.size(); ++r) ratio[r].push_back(times[0][r] / times[1][r]);
  }
  std::vector<double> at;
  bool beyond = false;
  for (const auto& one : ratio) {
    const Crossing crossing = last_crossing(sizes, one);
    at.push_back(crossing.at);
    beyond = beyond || !crossing.found;
  }
  if (beyond) t.remark(fmt::format("In some repetitions not even with the most tried ({}): counted as there.", sizes.back()));
  if (median(at) == sizes.front())
    t.remark(fmt::format("With the fewest objects tried ({}) it is ahead already.", sizes.front()));
  t.count(quantity, summarise(at));
}

void measure_worth(Trial& t) {
  count_crossing(t, "worth_from", {4, 8, 16, 32, 64, 128, 256, 512}, [](const Scene& scene, const TrialRays& rays) {
    const auto frame = [&](const char* name) {
      return timed([&scene, &rays, name] { trace_rays(*find_ray_structure(name, {}).make(scene, {}), rays); });
    };
    return std::vector{frame("sah"), frame("median")};
  });
}

void measure_brute(Trial& t) {
  const std::vector<double> sizes{1, 2, 4, 8, 16, 32, 64, 128, 256};
  // `make` gives brute force and tree.
  const auto against = [&](const auto& make) {
    return [&](const Scene& scene, const TrialRays& rays) {
      auto made = make(scene);
      const auto brute = [held = std::move(made.first)](const Ray& ray) { return held->closest(ray); };
      const auto tree = [held = std::move(made.second)](const Ray& ray) { return held->closest(ray); };
      t.hold_to(*find_ray_structure("sah", {}).make(scene, {}), rays.closest, brute);
      return std::vector{tracing(rays.closest, tree), tracing(rays.closest, brute)};
    };
  };
  const auto scalar = [](const Scene& scene) {
    const Geometry& geometry = scene.objects[0].geometry;
    return std::pair{std::make_shared<NaiveLoop>(scene, false),
                     std::make_shared<NaiveTree>(geometry, find_ray_structure("binned-sah", {}).tree(geometry, {}))};
  };
  const auto product = [](const Scene& scene) {
    const auto make = [&](const char* name) { return std::shared_ptr<RayQuery>(find_ray_structure(name, {}).make(scene, {})); };
    return std::pair{make("brute"), make("binned-sah")};
  };
  count_crossing(t, "viable_below", sizes, against(scalar));
  count_crossing(t, "viable_below_simd", sizes, against(product));
}

void measure_build(Trial& t) {
  t.race(mapped(t.works(), [&](const std::string& name) {
    return Contender{name, timed([&] { keep_answer(find_ray_structure(name, {}).make(t.scene, {})); })};
  }));
}

}  // namespace

std::vector<Measurement> builder_measurements() {
  constexpr auto factor = FigureKind::factor, plain = FigureKind::plain, time = FigureKind::time;
  return {{"builders",
           "time for the same rays, over that in the tree by full-sweep SAH",
           {{"median", factor, "median over SAH", "median", "sah"},
            {"midpoint", factor, "midpoint over SAH", "midpoint", "sah"},
            {"median_round_robin", factor, "round-robin-axis median over SAH", "median-round-robin", "sah"},
            {"median_wide", factor, "median over SAH in the bvh16 layout", "median layout=bvh16", "sah layout=bvh16"},
            {"midpoint_wide", factor, "midpoint over SAH in the bvh16 layout", "midpoint layout=bvh16", "sah layout=bvh16"}},
           measure_builders},
          {"bins",
           "what more bins spare",
           {{"gain_from_4", factor, "4 bins over 16", "binned-sah bins=4", "binned-sah bins=16"},
            {"gain_from_8", factor, "8 bins over 16", "binned-sah bins=8", "binned-sah bins=16"},
            {"gain_of_32", factor, "16 bins over 32", "binned-sah bins=16", "binned-sah bins=32"},
            {"gain_of_128", factor, "16 bins over 128", "binned-sah bins=16", "binned-sah bins=128"},
            {"gain_of_all_cuts", factor, "16 bins over the full sweep", "binned-sah bins=16", "sah"},
            {"cost_of_16", factor, "SAH cost of 16 bins over the full sweep's"}},
           measure_bins},
          {"sah-worth",
           "objects from which on building by full-sweep SAH and tracing a frame takes less than with the median",
           {{"worth_from", plain, "objects from which on SAH pays"}},
           measure_worth},
          {"brute-force",
           "objects from which on a tree traces faster than brute force",
           {{"viable_below", plain, "objects below which brute force is faster"},
            {"viable_below_simd", plain, "the same with four triangles and two boxes at once"}},
           measure_brute},
          {"build-time",
           "seconds on one thread",
           {{"full_sweep", time, "full-sweep SAH", "sah"},
            {"binned", time, "binned SAH", "binned-sah"},
            {"median", time, "median", "median"}},
           measure_build}};
}

}  // namespace etendue
