// Which tree: claims about builders. All trees are traversed alike, in the `binary` layout; where it matters in `bvh16` too.
#include "experiments/kinds/claims/claim_scenes.h"
#include "experiments/kinds/claims/measure_tools.h"
#include "experiments/kinds/claims/naive_loop.h"
#include "experiments/statistics/statistics.h"

#include <fmt/format.h>

namespace etendue {

namespace {

struct Candidate {
  std::string name;
  ParamMap params;
};

// Every candidate over the scene, and the seconds they take for its rays, in turns.
Times trace_times(const MeasureTask& task, const Scene& scene, const std::vector<Candidate>& candidates) {
  const ClaimRays rays = record_claim_rays(scene, task.resolution);
  std::vector<std::unique_ptr<RayQuery>> structures;
  std::vector<std::function<void()>> works;
  for (const Candidate& candidate : candidates) {
    structures.push_back(make_structure(scene, candidate.name, candidate.params));
    works.push_back([&rays, structure = structures.back().get()] { trace_rays(*structure, rays); });
  }
  return take_turns(task, works);
}

MeasureResult measure_builders(const MeasureTask& task) {
  const ParamMap wide = text_param("layout", "bvh16");
  const Times times = trace_times(task, load_claim_scene(task.scene, task.reading),
                                  {{"sah", {}},
                                   {"median", {}},
                                   {"midpoint", {}},
                                   {"median-round-robin", {}},
                                   {"sah", wide},
                                   {"median", wide},
                                   {"midpoint", wide}});
  MeasureResult result;
  result.add("median", ratio_of(times[1], times[0]));
  result.add("midpoint", ratio_of(times[2], times[0]));
  result.add("median_round_robin", ratio_of(times[3], times[0]));
  result.add("median_wide", ratio_of(times[5], times[4]));
  result.add("midpoint_wide", ratio_of(times[6], times[4]));
  result.remarks.push_back(fmt::format("{} in the bvh16 layout: median {:.2f}×, midpoint {:.2f}×.", task.scene,
                                       ratio_of(times[5], times[4]).median, ratio_of(times[6], times[4]).median));
  return result;
}

MeasureResult measure_bins(const MeasureTask& task) {
  const Scene scene = load_claim_scene(task.scene, task.reading);
  constexpr int bins[] = {16, 4, 8, 32, 128};
  std::vector<Candidate> candidates;
  for (const int count : bins) candidates.push_back({"binned-sah", whole_param("bins", count)});
  candidates.push_back({"sah", {}});
  const Times times = trace_times(task, scene, candidates);
  MeasureResult result;
  result.add("gain_from_4", ratio_of(times[1], times[0]));
  result.add("gain_from_8", ratio_of(times[2], times[0]));
  result.add("gain_of_32", ratio_of(times[0], times[3]));
  result.add("gain_of_128", ratio_of(times[0], times[4]));
  result.add("gain_of_all_cuts", ratio_of(times[0], times[5]));
  const auto cost = [&](const Candidate& c) { return make_structure(scene, c.name, c.params)->stats().sah_cost; };
  result.add("cost_of_16", cost(candidates[0]) / cost(candidates[5]));
  return result;
}

// Builds and traces one frame of the scene with more and more objects: from how many on does the one take less than the other?
// A ladder of factor two; between its steps the ratio of times is interpolated in logarithms. The last crossing counts.
struct Crossing {
  double at = 0;
  bool found = false;
};

Crossing last_crossing(const std::vector<double>& sizes, const std::vector<double>& ratio) {
  for (std::size_t i = sizes.size() - 1; i > 0; --i) {
    if (!(ratio[i] < 1) || ratio[i - 1] < 1) {
      if (!(ratio[i] < 1)) break;
      continue;
    }
    const double share = std::log(ratio[i - 1]) / (std::log(ratio[i - 1]) - std::log(ratio[i]));
    return {sizes[i - 1] * std::pow(sizes[i] / sizes[i - 1], share), true};
  }
  return {ratio.back() < 1 ? sizes.front() : sizes.back(), ratio.back() < 1};
}

// `work(scene, rays)` gives the seconds of the challenger and of the champion.
template <class Work>
Measured crossing(const MeasureTask& task, const std::vector<double>& sizes, const Work& work, MeasureResult& result) {
  const std::size_t rounds = static_cast<std::size_t>(task.repetitions);
  std::vector<std::vector<double>> ratio(rounds);
  for (const double size : sizes) {
    const Scene scene = load_claim_scene(fmt::format("{}?count={}", task.scene, size), task.reading);
    const Times times = work(scene, record_claim_rays(scene, std::max(8, task.resolution / 2)));
    for (std::size_t r = 0; r < rounds; ++r) ratio[r].push_back(times[0][r] / times[1][r]);
  }
  std::vector<double> at;
  bool beyond = false;
  for (const auto& one : ratio) {
    const Crossing crossing = last_crossing(sizes, one);
    at.push_back(crossing.at);
    beyond = beyond || !crossing.found;
  }
  if (beyond)
    result.remarks.push_back(
        fmt::format("In some repetitions not even with the most tried ({}): counted as there.", sizes.back()));
  if (median(at) == sizes.front())
    result.remarks.push_back(fmt::format("With the fewest objects tried ({}) it is ahead already.", sizes.front()));
  return summarise(at);
}

MeasureResult measure_worth(const MeasureTask& task) {
  MeasureResult result;
  const auto frame = [&](const Scene& scene, const ClaimRays& rays) {
    const auto with = [&](const char* name) { return [&, name] { trace_rays(*make_structure(scene, name), rays); }; };
    return take_turns(task, {with("sah"), with("median")});
  };
  result.add("worth_from", crossing(task, {4, 8, 16, 32, 64, 128, 256, 512}, frame, result));
  return result;
}

MeasureResult measure_brute(const MeasureTask& task) {
  MeasureResult result;
  const std::vector<double> sizes{1, 2, 4, 8, 16, 32, 64, 128, 256};
  // `make` gives brute force and tree.
  const auto against = [&](const auto& make) {
    return [&](const Scene& scene, const ClaimRays& rays) {
      const auto structures = make(scene);
      const auto& brute = structures.first;
      const auto& tree = structures.second;
      result.disagreements +=
          count_disagreements(*make_structure(scene, "sah"), rays.closest, [&](const Ray& ray) { return brute->closest(ray); });
      return take_turns(task, {tracing(rays.closest, [&](const Ray& ray) { return tree->closest(ray); }),
                               tracing(rays.closest, [&](const Ray& ray) { return brute->closest(ray); })});
    };
  };
  const auto scalar = [](const Scene& scene) {
    const Geometry& geometry = scene.objects[0].geometry;
    return std::pair{std::make_unique<NaiveLoop>(scene, false),
                     std::make_unique<NaiveTree>(geometry, find_ray_structure("binned-sah", {}).tree(geometry, {}))};
  };
  const auto product = [](const Scene& scene) {
    return std::pair{make_structure(scene, "brute"), make_structure(scene, "binned-sah")};
  };
  result.add("viable_below", crossing(task, sizes, against(scalar), result));
  result.add("viable_below_simd", crossing(task, sizes, against(product), result));
  return result;
}

MeasureResult measure_build(const MeasureTask& task) {
  const Scene scene = load_claim_scene(task.scene, task.reading);
  const auto with = [&](const char* name) { return [&, name] { keep_answer(make_structure(scene, name)); }; };
  const Times times = take_turns(task, {with("sah"), with("binned-sah"), with("median")});
  MeasureResult result;
  result.add("full_sweep", summarise(times[0]));
  result.add("binned", summarise(times[1]));
  result.add("median", summarise(times[2]));
  return result;
}

}  // namespace

std::vector<Measurement> builder_measurements() {
  constexpr auto factor = FigureKind::factor;
  return {{"builders",
           "time for the same rays, over that in the tree by full-sweep SAH",
           {{"median", factor, "median over SAH"},
            {"midpoint", factor, "midpoint over SAH"},
            {"median_round_robin", factor, "median on a rotating axis over SAH"},
            {"median_wide", factor, "median over SAH in the bvh16 layout"},
            {"midpoint_wide", factor, "midpoint over SAH in the bvh16 layout"}},
           measure_builders},
          {"bins",
           "what more bins spare",
           {{"gain_from_4", factor, "4 bins over 16"},
            {"gain_from_8", factor, "8 bins over 16"},
            {"gain_of_32", factor, "16 bins over 32"},
            {"gain_of_128", factor, "16 bins over 128"},
            {"gain_of_all_cuts", factor, "16 bins over the full sweep"},
            {"cost_of_16", factor, "SAH cost of 16 bins over the full sweep's"}},
           measure_bins},
          {"sah-worth",
           "objects from which on building by full-sweep SAH and tracing a frame takes less than with the median",
           {{"worth_from", FigureKind::plain, "objects from which on SAH pays"}},
           measure_worth},
          {"brute-force",
           "objects from which on a tree traces faster than brute force",
           {{"viable_below", FigureKind::plain, "objects below which brute force is faster"},
            {"viable_below_simd", FigureKind::plain, "the same with four triangles and two boxes at once"}},
           measure_brute},
          {"build-time",
           "seconds on one thread",
           {{"full_sweep", FigureKind::time, "full-sweep SAH"},
            {"binned", FigureKind::time, "binned SAH"},
            {"median", FigureKind::time, "median"}},
           measure_build}};
}

}  // namespace etendue
