// How a tree is walked: claims about traversal, measured on one tree (binned SAH) with the closest-hit rays of a render.
#include "experiments/kinds/claims/cache_model.h"
#include "experiments/kinds/claims/claim_scenes.h"
#include "experiments/kinds/claims/measure_tools.h"
#include "experiments/kinds/claims/traversal_variants.h"
#include "framework/core/rng.h"

namespace etendue {

namespace {

using FigureKind::factor;

// Observes into a model of a cache.
struct ObserveCache {
  static constexpr bool touches = true;
  struct Touch {
    CacheModel* cache;
    void operator()(const void* address, std::size_t bytes) const { cache->touch(address, bytes); }
  } touch;
  void node() {}
};

// The scene's tree, its nodes in both forms, the product's structure over the same tree, and the rays.
struct Subject {
  explicit Subject(const MeasureTask& task)
      : scene(load_claim_scene(task.scene, task.reading)),
        tree(scene.objects[0].geometry, find_ray_structure("binned-sah", {}).tree(scene.objects[0].geometry, {})),
        packed(tree.tree),
        linked(tree.tree),
        product(make_structure(scene, "binned-sah")),
        rays(record_claim_rays(scene, task.resolution).closest) {}

  template <TraversalOptions options, class Slab, class Nodes>
  auto variant(const Nodes& nodes) {
    return [this, &nodes](const Ray& ray) { return closest_by<options, Slab>(tree, nodes, ray); };
  }

  Scene scene;
  VariantTree tree;
  PackedNodes packed;
  LinkedNodes linked;
  std::unique_ptr<RayQuery> product;
  std::vector<Ray> rays;
};

// Seconds of each variant, in turns; all of their hits are held to the product's.
template <class... Closest>
Times compare(const MeasureTask& task, const Subject& subject, MeasureResult& result, const Closest&... closest) {
  ((result.disagreements += count_disagreements(*subject.product, subject.rays, closest)), ...);
  return take_turns(task, {tracing(subject.rays, closest)...});
}

template <TraversalOptions options>
double nodes_per_ray(const Subject& subject) {
  std::uint64_t nodes = 0;
  for (const Ray& ray : subject.rays) closest_by<options, ScalarSlab>(subject.tree, subject.packed, ray, ObserveNodes{nodes});
  return static_cast<double>(nodes) / static_cast<double>(subject.rays.size());
}

MeasureResult measure_order(const MeasureTask& task) {
  Subject s(task);
  MeasureResult result;
  constexpr TraversalOptions best{}, unordered{TraversalForm::iterative, false, true},
      unpruned{TraversalForm::iterative, true, false}, neither{TraversalForm::iterative, false, false};
  const Times times =
      compare(task, s, result, s.variant<best, ScalarSlab>(s.packed), s.variant<unordered, ScalarSlab>(s.packed),
              s.variant<unpruned, ScalarSlab>(s.packed), s.variant<neither, ScalarSlab>(s.packed));
  result.add("order", ratio_of(times[1], times[0]));
  result.add("pruning", ratio_of(times[2], times[0]));
  result.add("both", ratio_of(times[3], times[0]));
  const double least = nodes_per_ray<best>(s);
  result.add("order_boxes", nodes_per_ray<unordered>(s) / least);
  result.add("both_boxes", nodes_per_ray<neither>(s) / least);
  return result;
}

MeasureResult measure_recursion(const MeasureTask& task) {
  Subject s(task);
  MeasureResult result;
  constexpr TraversalOptions iterative{}, recursive{TraversalForm::recursive, true, true};
  const Times times =
      compare(task, s, result, s.variant<iterative, ScalarSlab>(s.packed), s.variant<recursive, ScalarSlab>(s.packed),
              s.variant<iterative, SimdSlab>(s.packed), s.variant<recursive, SimdSlab>(s.packed));
  result.add("iterative", ratio_of(times[1], times[0]));
  result.add("iterative_simd", ratio_of(times[3], times[2]));
  return result;
}

// Misses of a traversal, after the first half of the rays has warmed the cache.
template <class Nodes>
double misses_per_ray(const Subject& s, const Nodes& nodes, CacheModel cache) {
  const std::size_t half = s.rays.size() / 2;
  for (std::size_t i = 0; i < s.rays.size(); ++i) {
    if (i == half) cache.reset_counts();
    closest_by<TraversalOptions{}, ScalarSlab>(s.tree, nodes, s.rays[i], ObserveCache{{&cache}});
  }
  return static_cast<double>(cache.misses()) / static_cast<double>(s.rays.size() - half);
}

MeasureResult measure_layout(const MeasureTask& task) {
  Subject s(task);
  MeasureResult result;
  constexpr TraversalOptions best{};
  const Times times = compare(task, s, result, s.variant<best, ScalarSlab>(s.packed), s.variant<best, ScalarSlab>(s.linked));
  const CacheModel first(32 << 10, 8), second(1 << 20, 16);
  const auto misses = [&](const CacheModel& cache) {
    return misses_per_ray(s, s.linked, cache) / std::max(1e-9, misses_per_ray(s, s.packed, cache));
  };
  result.add("misses", misses(first));
  result.add("misses_second", misses(second));
  result.add("time", ratio_of(times[1], times[0]));
  result.remarks.push_back(
      "Misses are simulated (32 KiB in 8 ways, and 1 MiB in 16, of 64-byte lines that hold nodes alone): a virtual machine "
      "shows "
      "no hardware counters. Times are measured.");
  return result;
}

// Tests alone: as many boxes of the tree as the first cache holds, against rays one after the other.
template <class Slab>
std::function<void()> testing(const Subject& s, const std::vector<Bounds>& boxes, std::size_t rays) {
  return [&s, &boxes, rays] {
    for (std::size_t r = 0; r < rays; ++r) {
      const Ray& ray = s.rays[r * s.rays.size() / rays];
      const Slab slab(ray);
      float sum = 0;
      for (const Bounds& box : boxes) sum += slab.entry(box, ray.t_max) < infinity;
      keep_answer(sum);
    }
  };
}

std::vector<Bounds> some_boxes(const Subject& s, std::size_t count) {
  std::vector<Bounds> boxes;
  const auto& nodes = s.tree.tree.nodes;
  for (std::size_t i = 0; i < count; ++i) boxes.push_back(nodes[mix_bits(i) % nodes.size()].bounds);
  return boxes;
}

MeasureResult measure_slab(const MeasureTask& task) {
  Subject s(task);
  MeasureResult result;
  constexpr TraversalOptions best{};
  const std::vector<Bounds> boxes = some_boxes(s, 512);
  const std::size_t rays = std::min<std::size_t>(s.rays.size(), 8192);
  const Times alone = take_turns(task, {testing<SimdSlab>(s, boxes, rays), testing<LoopSlab>(s, boxes, rays),
                                        testing<ScalarSlab>(s, boxes, rays), testing<DividingSlab>(s, boxes, rays)});
  const Times whole = compare(task, s, result, s.variant<best, SimdSlab>(s.packed), s.variant<best, LoopSlab>(s.packed),
                              s.variant<best, DividingSlab>(s.packed));
  const auto product = [&](const Ray& ray) { return s.product->closest(ray); };
  const Times two = take_turns(task, {tracing(s.rays, product), tracing(s.rays, s.variant<best, LoopSlab>(s.packed))});
  result.add("simd_alone", ratio_of(alone[1], alone[0]));
  result.add("simd_over_branch_free", ratio_of(alone[2], alone[0]));
  result.add("simd_whole", ratio_of(whole[1], whole[0]));
  result.add("two_boxes_whole", ratio_of(two[1], two[0]));
  result.add("reciprocal_alone", ratio_of(alone[3], alone[1]));
  result.add("reciprocal_whole", ratio_of(whole[2], whole[1]));
  return result;
}

// All that is no matter of the tree, at once: nodes, recursion, slab test; both visit the near child first and prune.
MeasureResult measure_together(const MeasureTask& task) {
  Subject s(task);
  MeasureResult result;
  constexpr TraversalOptions recursive{TraversalForm::recursive, true, true};
  const auto product = [&](const Ray& ray) { return s.product->closest(ray); };
  const auto wide = make_structure(s.scene, "binned-sah", text_param("layout", "bvh16"));
  const Times times = compare(task, s, result, s.variant<recursive, DividingSlab>(s.linked), product,
                              [&](const Ray& ray) { return wide->closest(ray); });
  result.add("together", ratio_of(times[0], times[1]));
  result.add("together_wide", ratio_of(times[0], times[2]));
  return result;
}

MeasureResult measure_counting(const MeasureTask& task) {
  const Scene scene = load_claim_scene(task.scene, task.reading);
  const std::vector<Ray> rays = record_claim_rays(scene, task.resolution).closest;
  const auto binary = make_structure(scene, "binned-sah"),
             wide = make_structure(scene, "binned-sah", text_param("layout", "bvh16"));
  const auto silent = [&](const RayQuery& q) { return tracing(rays, [&q](const Ray& ray) { return q.closest(ray); }); };
  const auto counted = [&](const RayQuery& q) {
    return [&rays, &q] {
      TraversalCounters counters;
      float sum = 0;
      for (const Ray& ray : rays) sum += q.closest_counted(ray, counters).t < infinity;
      keep_answer(sum);
      keep_answer(counters);
    };
  };
  const Times times = take_turns(task, {silent(*binary), counted(*binary), silent(*wide), counted(*wide)});
  MeasureResult result;
  result.add("counting", ratio_of(times[1], times[0]));
  result.add("counting_wide", ratio_of(times[3], times[2]));
  return result;
}

}  // namespace

std::vector<Measurement> traversal_measurements() {
  return {
      {"order",
       "time without the order of children, or pruning, over that with both",
       {{"order", factor, "first child first over near child first"},
        {"pruning", factor, "no pruning over pruning"},
        {"both", factor, "neither over both"},
        {"order_boxes", factor, "boxes tested, first child first over near child first"},
        {"both_boxes", factor, "boxes tested, neither over both"}},
       measure_order},
      {"recursion",
       "time of a recursive traversal over that of one with a stack",
       {{"iterative", factor, "recursive over iterative"},
        {"iterative_simd", factor, "recursive over iterative, with the SIMD slab test"}},
       measure_recursion},
      {"node-layout",
       "nodes in one array, by index, against nodes allocated one by one, by pointer",
       {{"misses", factor, "misses of a first cache, linked over packed nodes"},
        {"misses_second", factor, "misses of a second cache, linked over packed nodes"},
        {"time", factor, "time, linked over packed nodes"}},
       measure_layout},
      {"slab-test",
       "slab tests alone and in a traversal",
       {{"simd_alone", factor, "the test alone, scalar loop over SIMD"},
        {"simd_over_branch_free", factor, "the test alone, branch-free scalar over SIMD"},
        {"simd_whole", factor, "the traversal, scalar loop over SIMD"},
        {"two_boxes_whole", factor, "the traversal, scalar loop over two boxes at once"},
        {"reciprocal_alone", factor, "the test alone, division over reciprocal"},
        {"reciprocal_whole", factor, "the traversal, division over reciprocal"}},
       measure_slab},
      {"point-optimisations",
       "recursion, linked nodes and division, over the product's traversal of the same tree",
       {{"together", factor, "none of them over all"}, {"together_wide", factor, "none of them over the bvh16 layout"}},
       measure_together},
      {"counting",
       "time with counters of nodes and primitives over that without",
       {{"counting", factor, "counted over not, binary layout"}, {"counting_wide", factor, "counted over not, bvh16 layout"}},
       measure_counting}};
}

}  // namespace etendue
