// Claims about traversal are measured on one tree (binned SAH) with the closest-hit rays of a render.
#include "experiments/kinds/claims/cache_model.h"
#include "experiments/kinds/claims/measurement.h"
#include "experiments/kinds/claims/traversal_variants.h"
#include "framework/core/rng.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

namespace {

constexpr TraversalOptions best{}, recursive{TraversalForm::recursive, true, true},
    unordered{TraversalForm::iterative, false, true}, unpruned{TraversalForm::iterative, true, false},
    neither{TraversalForm::iterative, false, false};

// Observes into a model of a cache.
struct ObserveCache {
  static constexpr bool touches = true;
  struct Touch {
    CacheModel* cache;
    void operator()(const void* address, std::size_t bytes) const { cache->touch(address, bytes); }
  } touch;
  void node() {}
};

// The scene's tree, its nodes in both forms, the product's structure over the same tree, the rays, and some of its boxes, as
// many as the first cache holds.
struct Subject {
  explicit Subject(Trial& t)
      : trial(t),
        tree(t.scene.objects[0].geometry, find_ray_structure("binned-sah", {}).tree(t.scene.objects[0].geometry, {})),
        packed(tree.tree),
        linked(tree.tree),
        product(t.make("binned-sah")),
        rays(t.record_rays().closest) {
    const auto& nodes = tree.tree.nodes;
    for (std::size_t i = 0; i < 512; ++i) boxes.push_back(nodes[mix_bits(i) % nodes.size()].bounds);
  }

  // Hits are held to the product's.
  template <class Closest>
  TimedWork held(const Closest& closest) {
    trial.hold_to(product, rays, closest);
    return tracing(rays, closest);
  }

  Trial& trial;
  VariantTree tree;
  PackedNodes packed;
  LinkedNodes linked;
  const RayQuery& product;
  std::vector<Ray> rays;
  std::vector<Bounds> boxes;
};

template <auto nodes, TraversalOptions options, class Slab>
TimedWork traversing(Subject& s) {
  return s.held([&s](const Ray& ray) { return closest_by<options, Slab>(s.tree, s.*nodes, ray); });
}

// Tests alone: rays one after the other against the boxes.
template <class Slab>
TimedWork testing(Subject& s) {
  return timed([&s, rays = std::min<std::size_t>(s.rays.size(), 8192)] {
    for (std::size_t r = 0; r < rays; ++r) {
      const Ray& ray = s.rays[r * s.rays.size() / rays];
      const Slab slab(ray);
      float sum = 0;
      for (const Bounds& box : s.boxes) sum += slab.entry(box, ray.t_max) < infinity;
      keep_answer(sum);
    }
  });
}

constexpr std::pair<std::string_view, TimedWork (*)(Subject&)> variants[] = {
    {"near first, pruned", traversing<&Subject::packed, best, ScalarSlab>},
    {"unordered", traversing<&Subject::packed, unordered, ScalarSlab>},
    {"unpruned", traversing<&Subject::packed, unpruned, ScalarSlab>},
    {"neither", traversing<&Subject::packed, neither, ScalarSlab>},
    {"recursion", traversing<&Subject::packed, recursive, ScalarSlab>},
    {"SIMD", traversing<&Subject::packed, best, SimdSlab>},
    {"SIMD, recursion", traversing<&Subject::packed, recursive, SimdSlab>},
    {"loop", traversing<&Subject::packed, best, LoopSlab>},
    {"division", traversing<&Subject::packed, best, DividingSlab>},
    {"linked", traversing<&Subject::linked, best, ScalarSlab>},
    {"linked, recursion, division", traversing<&Subject::linked, recursive, DividingSlab>},
    {"test: SIMD", testing<SimdSlab>},
    {"test: branch-free", testing<ScalarSlab>},
    {"test: loop", testing<LoopSlab>},
    {"test: division", testing<DividingSlab>}};

// The works of a measurement: variants, or structures of the product.
void race_variants(Subject& s) {
  std::vector<Contender> contenders;
  for (const std::string& name : s.trial.works()) {
    const auto found = std::ranges::find_if(variants, [&](const auto& v) { return v.first == name; });
    const auto structure = [&] { return s.held([&q = s.trial.make(name)](const Ray& ray) { return q.closest(ray); }); };
    contenders.push_back({name, found != std::end(variants) ? found->second(s) : structure()});
  }
  s.trial.race(contenders);
}

void measure_variants(Trial& t) {
  Subject s(t);
  race_variants(s);
}

template <TraversalOptions options>
double nodes_per_ray(const Subject& subject) {
  std::uint64_t nodes = 0;
  for (const Ray& ray : subject.rays) closest_by<options, ScalarSlab>(subject.tree, subject.packed, ray, ObserveNodes{nodes});
  return static_cast<double>(nodes) / static_cast<double>(subject.rays.size());
}

void measure_order(Trial& t) {
  Subject s(t);
  race_variants(s);
  const double least = nodes_per_ray<best>(s);
  t.count("order_boxes", nodes_per_ray<unordered>(s) / least);
  t.count("both_boxes", nodes_per_ray<neither>(s) / least);
}

// Misses of a traversal, after the first half of the rays has warmed the cache.
template <class Nodes>
double misses_per_ray(const Subject& s, const Nodes& nodes, CacheModel cache) {
  const std::size_t half = s.rays.size() / 2;
  for (std::size_t i = 0; i < s.rays.size(); ++i) {
    if (i == half) cache.reset_counts();
    closest_by<best, ScalarSlab>(s.tree, nodes, s.rays[i], ObserveCache{{&cache}});
  }
  return static_cast<double>(cache.misses()) / static_cast<double>(s.rays.size() - half);
}

void measure_layout(Trial& t) {
  Subject s(t);
  race_variants(s);
  const CacheModel first(32 << 10, 8), second(1 << 20, 16);
  const auto misses = [&](const CacheModel& cache) {
    return misses_per_ray(s, s.linked, cache) / std::max(1e-9, misses_per_ray(s, s.packed, cache));
  };
  t.count("misses", misses(first));
  t.count("misses_second", misses(second));
  t.remark(
      "Misses are simulated (32 KiB in 8 ways, and 1 MiB in 16, of 64-byte lines that hold nodes alone): a virtual machine "
      "shows no hardware counters. Times are measured.");
}

void measure_counting(Trial& t) {
  const std::vector<Ray> rays = t.record_rays().closest;
  std::vector<Contender> contenders;
  for (const char* label : {"binned-sah", "binned-sah layout=bvh16"}) {
    const RayQuery& query = t.make(label);
    contenders.push_back({label, tracing(rays, [&query](const Ray& ray) { return query.closest(ray); })});
    contenders.push_back({fmt::format("{}, counted", label), timed([&rays, &query] {
                            TraversalCounters counters;
                            float sum = 0;
                            for (const Ray& ray : rays) sum += query.closest_counted(ray, counters).t < infinity;
                            keep_answer(sum);
                            keep_answer(counters);
                          })});
  }
  t.race(contenders);
}

}  // namespace

std::vector<Measurement> traversal_measurements() {
  constexpr auto factor = FigureKind::factor;
  return {
      {"order",
       "time without the order of children, or pruning, over that with both",
       {{"order", factor, "first child first over near child first", "unordered", "near first, pruned"},
        {"pruning", factor, "no pruning over pruning", "unpruned", "near first, pruned"},
        {"both", factor, "neither over both", "neither", "near first, pruned"},
        {"order_boxes", factor, "boxes tested, first child first over near child first"},
        {"both_boxes", factor, "boxes tested, neither over both"}},
       measure_order},
      {"recursion",
       "time of a recursive traversal over that of one with a stack",
       {{"iterative", factor, "recursive over iterative", "recursion", "near first, pruned"},
        {"iterative_simd", factor, "recursive over iterative, with the SIMD slab test", "SIMD, recursion", "SIMD"}},
       measure_variants},
      {"node-layout",
       "nodes in one array, by index, against nodes allocated one by one, by pointer",
       {{"misses", factor, "misses of a first cache, linked over packed nodes"},
        {"misses_second", factor, "misses of a second cache, linked over packed nodes"},
        {"time", factor, "time, linked over packed nodes", "linked", "near first, pruned"}},
       measure_layout},
      {"slab-test",
       "slab tests alone and in a traversal",
       {{"simd_alone", factor, "the test alone, scalar loop over SIMD", "test: loop", "test: SIMD"},
        {"simd_over_branch_free", factor, "the test alone, branch-free scalar over SIMD", "test: branch-free", "test: SIMD"},
        {"simd_whole", factor, "the traversal, scalar loop over SIMD", "loop", "SIMD"},
        {"two_boxes_whole", factor, "the traversal, scalar loop over two boxes at once", "loop", "binned-sah"},
        {"reciprocal_alone", factor, "the test alone, division over reciprocal", "test: division", "test: loop"},
        {"reciprocal_whole", factor, "the traversal, division over reciprocal", "division", "loop"}},
       measure_variants},
      // All that is no matter of the tree, at once; both visit the near child first and prune.
      {"point-optimisations",
       "recursion, linked nodes and division, over the product's traversal of the same tree",
       {{"together", factor, "none of them over all", "linked, recursion, division", "binned-sah"},
        {"together_wide", factor, "none of them over the bvh16 layout", "linked, recursion, division",
         "binned-sah layout=bvh16"}},
       measure_variants},
      {"counting",
       "time with counters of nodes and primitives over that without",
       {{"counting", factor, "counted over not, binary layout", "binned-sah, counted", "binned-sah"},
        {"counting_wide", factor, "counted over not, bvh16 layout", "binned-sah layout=bvh16, counted",
         "binned-sah layout=bvh16"}},
       measure_counting}};
}

}  // namespace etendue
