// The operations that a wide traversal needs from an instruction set, and its two tests: of one ray against all children of a
// node and against a leaf (kernels/box_test.h, pack_query.h). Each wide_isa_*.cpp, which the build compiles for its set,
// includes this once. All is in an unnamed namespace, so that no code of one set can stand in for another's when the program is
// linked.
#pragma once

#include "accel/bvh/wide/wide_headers.h"

namespace etendue {
namespace {

// Waits on the stack: a place, and for closest hits where the ray enters it. (A WideRef would do for any hit, but types that
// other files know would have the compiler emit functions which the linker could take for theirs.)
struct Waiting {
  WideRef place;
  float entry;
};
struct WaitingAny {
  WideRef place;
};

// The children of a node that a ray enters before its others, and no more than where it enters the second.
struct NearestTwo {
  int first, second;
  float second_entry;
};

// Provides what a traversal asks of an instruction set.
template <int widest_register>
struct Simd {
  static constexpr int widest = widest_register;
  static constexpr bool streams_nearest = false;  // do streams pay for nearest hits?
  template <int width>
  using Floats = etendue::Floats<width, widest>;

  // The children that are leaves, a bit each.
  template <int width>
  static unsigned leaves(const WideNode<width>& node) {
    unsigned mask = 0;
    for (int slot = 0; slot < width; ++slot) mask |= static_cast<unsigned>(node.children[slot].is_leaf()) << slot;
    return mask;
  }

  // To be called where two children or more are met; the entries of the others are infinite.
  template <int width, class Floats>
  static NearestTwo nearest_two(const Floats& entries) {
    alignas(64) float entry[width];
    entries.store(entry);
    const auto first = static_cast<int>(std::min_element(entry, entry + width) - entry);
    entry[first] = infinity;
    const auto second = static_cast<int>(std::min_element(entry, entry + width) - entry);
    return {first, second, entry[second]};
  }

  template <int width, class Floats>
  static Waiting* stack_places(const WideNode<width>& node, const Floats& entries, unsigned lanes, Waiting* top) {
    alignas(64) float entry[width];
    entries.store(entry);
    for (; lanes != 0; lanes &= lanes - 1) *top++ = {node.children[std::countr_zero(lanes)], entry[std::countr_zero(lanes)]};
    return top;
  }

  // Lists those of `count` rays that meet a child, in their order, and answers how many. May write 16 values beyond.
  static std::uint32_t collect(const std::uint32_t* met, const std::uint32_t* ids, std::uint32_t count, int child,
                               std::uint32_t* to) {
    std::uint32_t size = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      to[size] = ids[i];
      size += met[i] >> child & 1;
    }
    return size;
  }

  template <int width>
  static WaitingAny* stack_places(const WideNode<width>& node, unsigned lanes, WaitingAny* top) {
    for (; lanes != 0; lanes &= lanes - 1) (top++)->place = node.children[std::countr_zero(lanes)];
    return top;
  }
};

// Holds what a traversal works out of a ray before all else, the three axes at a time. Many rays take little more than this.
template <class Simd>
struct RayTerms {
  vec3 reciprocal;    // slab_reciprocal
  unsigned negative;  // a bit per axis: the direction's sign
  bool is_traceable;  // by the rule of kernels/primitive_test.h; where it is not, nothing else counts
  TraversalLimit limit;

  [[gnu::always_inline]] RayTerms(const Ray& ray, float extent)
      : RayTerms(ray, extent, Four::load_anywhere(&ray.origin.x), Four::load_anywhere(&ray.direction.x)) {
    static_assert(offsetof(Ray, t_min) == offsetof(Ray, origin) + 3 * sizeof(float) &&
                      offsetof(Ray, t_max) == offsetof(Ray, direction) + 3 * sizeof(float),
                  "four floats are loaded at the origin and at the direction");
  }

 private:
  using Four = typename Simd::template Floats<4>;

  // The fourth lanes hold t_min and t_max.
  [[gnu::always_inline]] RayTerms(const Ray& ray, float extent, Four origin, Four direction)
      : RayTerms(ray, extent, larger(origin, Four::set(0) - origin), larger(direction, Four::set(0) - direction),
                 Four::set(1) / direction) {}

  [[gnu::always_inline]] RayTerms(const Ray& ray, float extent, Four origin_size, Four direction_size, Four reciprocals)
      : reciprocal(first_three(reciprocals)),
        negative(less(reciprocals, Four::set(0)) & 7),
        is_traceable((less(origin_size, Four::set(infinity)) & less(direction_size, Four::set(infinity)) & 7) == 7 &&
                     (less(Four::set(0), direction_size) & 7) != 0 && ray.t_min <= ray.t_max),
        limit(max_component(first_three(origin_size)), extent, max_component(first_three(direction_size))) {
    // The reciprocal of a component that is zero or too small to divide by is a large finite number.
    if ((less_equal(Four::set(infinity), larger(reciprocals, Four::set(0) - reciprocals)) & 7) != 0) [[unlikely]]
      reciprocal = slab_reciprocal(ray.direction);
  }

  [[gnu::always_inline]] static vec3 first_three(Four values) {
    alignas(16) float stored[4];
    values.store(stored);
    return {stored[0], stored[1], stored[2]};
  }
};

// The slab test with a child in each lane.
template <class Simd, int node_width>
class NodeTest : public BoxTest<typename Simd::template Floats<node_width>, node_width> {
  using Boxes = typename Simd::template Floats<node_width>;
  using Base = BoxTest<Boxes, node_width>;

 public:
  using Base::Base;

  // The children that the ray meets before `limit`, a bit each; `near`: where it enters them.
  [[gnu::always_inline]] unsigned met(const WideNode<node_width>& node, const Boxes& limit, Boxes& near) const {
    const float* const planes = node.planes[0];
    return Base::met([planes](std::uint32_t place) { return Boxes::load(planes + place); }, limit, near);
  }
};

// Holds what the triangle test takes from a ray: the origin along the axes of `shear`.
struct LeafTerms {
  TriangleRay shear;
  float origin[3];
  float t_min, t_max;

  LeafTerms() = default;
  explicit LeafTerms(const Ray& ray)
      : shear(ray.direction),
        origin{component(ray.origin, shear.kx), component(ray.origin, shear.ky), component(ray.origin, shear.kz)},
        t_min(ray.t_min),
        t_max(farthest_hit(ray)) {}
};

// A ray against leaves, packs and lists, lowering `hit` as PackQuery does.
template <class Simd, class Pack, bool any_hit, class Count>
class LeafQuery : PackQuery<typename Simd::template Floats<Pack::lanes>, Pack, any_hit> {
  using Lanes = typename Simd::template Floats<Pack::lanes>;
  using Packs = PackQuery<Lanes, Pack, any_hit>;

 public:
  using Outcome = typename Packs::Outcome;

  [[gnu::always_inline]] LeafQuery(const vec3& origin, const TriangleRay& shear) : Packs(origin, shear) {}
  [[gnu::always_inline]] explicit LeafQuery(const LeafTerms& terms)
      : LeafQuery(terms.shear, terms.origin[0], terms.origin[1], terms.origin[2]) {}
  [[gnu::always_inline]] LeafQuery(const TriangleRay& shear, float origin_kx, float origin_ky, float origin_kz)
      : Packs(shear, {shear, origin_kx, origin_ky, origin_kz}) {}

  // Whether a leaf has any hit, found with no branch on what the ray meets in a pack.
  template <class View>
  [[gnu::always_inline]] static bool occluded(const View& view, const Ray& ray, const LeafTerms& terms, WideRef leaf) {
    if (leaf.is_pack()) [[likely]] {
      bool rare;
      const bool found = LeafQuery(terms).Packs::occluded(view.tree.packs[leaf.index()], terms.t_min, terms.t_max, rare);
      if (!rare) [[likely]]
        return found;
    }
    Hit hit;
    hit.t = terms.t_max;
    Count nothing;
    return test_rare(view, ray, terms.shear, leaf, hit, nothing);
  }

  // A leaf by SIMD instructions alone. `rare`: it takes more, nothing was done, and test_rare must be asked.
  template <class View>
  [[gnu::always_inline]] Outcome test_common(const View& view, float t_min, WideRef leaf, Hit& hit, Count& count) const {
    if (!leaf.is_pack()) [[unlikely]]
      return Outcome::rare;
    const Pack& pack = view.tree.packs[leaf.index()];
    const Outcome outcome = Packs::test_common(pack, t_min, hit);
    if (outcome != Outcome::rare) count_triangles(pack, count);
    return outcome;
  }

  // Lists of primitives, and packs of which some triangle takes double precision.
  template <class View>
  static bool test_rare(const View& view, const Ray& ray, const TriangleRay& shear, WideRef leaf, Hit& hit, Count& count) {
    if (Count::of_primitives && leaf.is_pack())
      count_triangles(view.tree.packs[leaf.index()], count);
    else if (Count::of_primitives && !leaf.is_none())
      count.primitives(view.tree.lists[leaf.index()].count);
    return test_rare_leaf(view, ray, shear, leaf, any_hit, hit);
  }

  template <class View>
  [[gnu::always_inline]] bool test(const View& view, const Ray& ray, WideRef leaf, Hit& hit, Count& count) const {
    const Outcome outcome = test_common(view, ray.t_min, leaf, hit, count);
    if (outcome == Outcome::rare) [[unlikely]]
      return test_rare(view, ray, this->shear(), leaf, hit, count);  // a copy: its address goes to a call
    return outcome == Outcome::found;
  }

 private:
  [[gnu::always_inline]] static void count_triangles(const Pack& pack, Count& count) {
    if constexpr (Count::of_primitives)
      count.primitives(static_cast<std::uint32_t>(Pack::lanes - std::count(pack.ids, pack.ids + Pack::lanes, no_id)));
  }
};

// The lines of a node or pack that is visited soon, all at once: each would otherwise be waited for in turn.
template <std::size_t size>
[[gnu::always_inline]] inline void prefetch_lines(const void* begin) {
#pragma GCC unroll 8
  for (std::size_t offset = 0; offset < size; offset += 64) __builtin_prefetch(static_cast<const char*>(begin) + offset);
}

template <class Tree>
[[gnu::always_inline]] inline void prefetch(const Tree& tree, WideRef place) {
  if (!place.is_leaf())
    prefetch_lines<sizeof(tree.nodes[0])>(&tree.nodes[place.node()]);
  else if (place.is_pack())
    prefetch_lines<offsetof(typename Tree::LeafPack, ids)>(&tree.packs[place.index()]);
}

}  // namespace
}  // namespace etendue
