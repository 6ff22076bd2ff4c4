// The four queries of a ray structure, closest and occluded and their counted forms, from one template: its
// `trace<any_hit>(ray, count)`, which answers a hit; where any hit will do, only Hit::primitive tells. Without counting,
// nothing of the counters is left in the code.
#pragma once

#include "accel/kernels/primitive_test.h"

namespace etendue {

struct CountNothing {
  static constexpr bool of_primitives = false;
  void node() {}
  void primitives(std::uint32_t) {}
  // The answer of an inner structure.
  template <bool any_hit, class Structure>
  Hit trace(const Structure& structure, const Ray& ray) const {
    if constexpr (any_hit)
      return structure.occluded(ray) ? some_hit(ray) : Hit{};
    else
      return structure.closest(ray);
  }
  // A hit of which no more is known than that there is one.
  static Hit some_hit(const Ray& ray) { return {ray.t_min, vec2(0), 0, 0}; }
};

struct CountWork {
  static constexpr bool of_primitives = true;
  TraversalCounters& counters;

  void node() { ++counters.nodes; }
  void primitives(std::uint32_t count) { counters.primitives += count; }
  template <bool any_hit, class Structure>
  Hit trace(const Structure& structure, const Ray& ray) const {
    if constexpr (any_hit)
      return structure.occluded_counted(ray, counters) ? CountNothing::some_hit(ray) : Hit{};
    else
      return structure.closest_counted(ray, counters);
  }
};

template <class Structure>
class Queries {
 public:
  Hit closest(const Ray& ray) const { return self().template trace<false>(ray, CountNothing{}); }
  bool occluded(const Ray& ray) const { return static_cast<bool>(self().template trace<true>(ray, CountNothing{})); }
  Hit closest_counted(const Ray& ray, TraversalCounters& counters) const {
    return self().template trace<false>(ray, CountWork{counters});
  }
  bool occluded_counted(const Ray& ray, TraversalCounters& counters) const {
    return static_cast<bool>(self().template trace<true>(ray, CountWork{counters}));
  }

 private:
  const Structure& self() const { return static_cast<const Structure&>(*this); }
};

// The queries of a structure over one geometry with leaves: `traverse(ray, t_best, count, leaf)` shows those that the ray
// meets, front to back, to `leaf`, which lowers `t_best` and returns true to end the traversal. They are tested by a LeafTest,
// made of the structure's `leaves()` and the ray.
template <class Structure, template <bool any_hit> class LeafTest>
class LeafQueries : public Queries<Structure> {
 public:
  template <bool any_hit, class Count>
  Hit trace(const Ray& ray, Count count) const {
    if (!is_traceable(ray)) return {};
    const auto& structure = static_cast<const Structure&>(*this);
    LeafTest<any_hit> test(structure.leaves(), ray);
    Hit hit;
    hit.t = farthest_hit(ray);
    structure.traverse(ray, hit.t, count, [&](const auto& leaf) { return test(leaf, hit, count) && any_hit; });
    return placed(hit);
  }
};

}  // namespace etendue
