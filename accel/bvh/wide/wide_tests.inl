// The two tests of a wide traversal, of one ray against all children of a node and against all triangles of a pack, for one
// instruction set. Included once by each wide_isa_*.cpp, which the build compiles for its set. All is in an unnamed namespace,
// so that no code of one set can stand in for another's when the program is linked. Their rules are those of the scalar tests
// in framework/scene/intersect.h (is_traceable, slab_reciprocal, slab_entry, intersect_triangle): what changes there changes
// here. Only, far distances are padded by NodeTest in another step.
//
// `Simd::Floats<width>` is a vector of floats: load, set, store, + - * /, `larger` and `smaller` (which answer their second
// operand when one is NaN, as x86 does), and comparisons that give a bit per lane. Each operation rounds by itself (the project
// is compiled without FMA contraction), so all instruction sets give the same bits, and those of the scalar tests.
#pragma once

#include "accel/kernels/simd_lanes.inl"

namespace etendue {
namespace {

// What a traversal works out of a ray before all else, the three axes at a time: many rays take little more than this.
template <class Simd>
struct RayTerms {
  vec3 reciprocal;    // slab_reciprocal
  unsigned negative;  // a bit per axis: the direction's sign
  bool is_traceable;  // by the rule of framework/scene/intersect.h; where it is not, nothing else counts
  TraversalLimit limit;

  [[gnu::always_inline]] RayTerms(const Ray& ray, float extent)
      : RayTerms(ray, extent, Four::load_anywhere(&ray.origin.x), Four::load_anywhere(&ray.direction.x)) {
    static_assert(offsetof(Ray, t_min) == offsetof(Ray, origin) + 3 * sizeof(float) &&
                      offsetof(Ray, t_max) == offsetof(Ray, direction) + 3 * sizeof(float),
                  "four floats are loaded at the origin and at the direction");
  }

 private:
  using Four = typename Simd::template Floats<4>;

  // With t_min and t_max in the fourth lanes.
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

// What the slab test takes from a ray.
template <int node_width>
struct SlabTerms {
  vec3 origin, reciprocal, padded_reciprocal;  // padded: for far planes
  float t_min;
  std::uint32_t negative;  // a bit per axis: the direction's sign

  SlabTerms() = default;
  template <class Simd>
  [[gnu::always_inline]] SlabTerms(const Ray& ray, const RayTerms<Simd>& terms)
      : origin(ray.origin),
        reciprocal(terms.reciprocal),
        padded_reciprocal(terms.reciprocal * slab_pad),
        t_min(ray.t_min),
        negative(terms.negative) {}
};

// By signs of a direction: where the near and the far planes of each axis begin in WideNode::planes.
struct PlanePlaces {
  std::uint32_t near[3], far[3];
};
template <int node_width>
inline constexpr auto plane_places = [] {
  std::array<PlanePlaces, 8> places{};
  for (std::uint32_t signs = 0; signs < 8; ++signs)
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t negative = signs >> axis & 1;
      places[signs].near[axis] = (2 * axis + negative) * node_width;
      places[signs].far[axis] = (2 * axis + 1 - negative) * node_width;
    }
  return places;
}();

// The slab test with a child in each lane, by the rules of slab_entry in framework/scene/intersect.h; far distances are padded
// by padding the reciprocals they are multiplied with, which takes no step of its own in a visit.
template <class Simd, int node_width>
class NodeTest {
 public:
  using Boxes = typename Simd::template Floats<node_width>;

  [[gnu::always_inline]] explicit NodeTest(const SlabTerms<node_width>& ray)
      : places_(plane_places<node_width>[ray.negative]),
        t_min_(Boxes::set(ray.t_min)),
        x_{Boxes::set(ray.origin.x), Boxes::set(ray.reciprocal.x), Boxes::set(ray.padded_reciprocal.x)},
        y_{Boxes::set(ray.origin.y), Boxes::set(ray.reciprocal.y), Boxes::set(ray.padded_reciprocal.y)},
        z_{Boxes::set(ray.origin.z), Boxes::set(ray.reciprocal.z), Boxes::set(ray.padded_reciprocal.z)} {}

  // The children that the ray meets before `limit`, a bit each; `near`: where it enters them.
  [[gnu::always_inline]] unsigned met(const WideNode<node_width>& node, Boxes limit, Boxes& near) const {
    const float* const planes = node.planes[0];
    near = larger(x_.near(planes + places_.near[0]), t_min_);
    near = larger(y_.near(planes + places_.near[1]), near);
    near = larger(z_.near(planes + places_.near[2]), near);
    Boxes far = smaller(x_.far(planes + places_.far[0]), limit);
    far = smaller(y_.far(planes + places_.far[1]), far);
    far = smaller(z_.far(planes + places_.far[2]), far);
    return less_equal(near, far);
  }

 private:
  // What the planes of an axis take from the ray.
  struct Axis {
    Boxes origin, reciprocal, padded_reciprocal;
    [[gnu::always_inline]] Boxes near(const float* planes) const { return (Boxes::load(planes) - origin) * reciprocal; }
    [[gnu::always_inline]] Boxes far(const float* planes) const { return (Boxes::load(planes) - origin) * padded_reciprocal; }
  };

  const PlanePlaces& places_;
  const Boxes t_min_;
  const Axis x_, y_, z_;
};

// No hit is farther: t is infinite where 1 / det is.
inline float farthest_hit(const Ray& ray) { return std::min(ray.t_max, std::numeric_limits<float>::max()); }

// What the triangle test takes from a ray: the origin along the axes of `shear`.
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

// A ray against leaves, lowering `hit`. Any hit will do for `any_hit`: then Hit::primitive tells that there is one, and nothing
// more.
template <class Simd, class Pack, bool any_hit, class Count>
class LeafTest {
  using Lanes = typename Simd::template Floats<Pack::lanes>;

 public:
  // To be called before the first test.
  [[gnu::always_inline]] void prepare(const vec3& origin, const TriangleRay& shear) {
    prepare(shear, component(origin, shear.kx), component(origin, shear.ky), component(origin, shear.kz));
  }
  [[gnu::always_inline]] void prepare(const LeafTerms& terms) {
    prepare(terms.shear, terms.origin[0], terms.origin[1], terms.origin[2]);
  }
  [[gnu::always_inline]] void prepare(const TriangleRay& shear, float origin_x, float origin_y, float origin_z) {
    shear_ = shear;
    origin_x_ = Lanes::set(origin_x);
    origin_y_ = Lanes::set(origin_y);
    origin_z_ = Lanes::set(origin_z);
    shear_x_ = Lanes::set(shear.sx);
    shear_y_ = Lanes::set(shear.sy);
    shear_z_ = Lanes::set(shear.sz);
  }

  // Whether a leaf has any hit, found with no branch on what the ray meets in a pack.
  template <class View>
  [[gnu::always_inline]] static bool occluded(const View& view, const Ray& ray, const LeafTerms& terms, WideRef leaf) {
    LeafTest test;
    test.prepare(terms);
    Hit hit;
    hit.t = terms.t_max;
    if (leaf.is_pack()) [[likely]] {
      const Pack& pack = view.tree.packs[leaf.index()];
      const Corners c = test.corners(pack);
      const Edges e(c.x, c.y, pack.used());
      const Lanes t = test.distances(e, c.z, Lanes::set(1) / (e.u + e.v + e.w));
      const unsigned inside = e.inside & less(Lanes::set(terms.t_min), t) & less_equal(t, Lanes::set(terms.t_max));
      if (e.on_edge == 0) [[likely]]
        return inside != 0;
    }
    Count nothing;
    return test_rare(view, ray, terms.shear, leaf, hit, nothing);
  }

  // A leaf by SIMD instructions alone. `rare`: it takes more, nothing was done, and test_rare must be asked.
  enum class Outcome { missed, found, rare };
  template <class View>
  [[gnu::always_inline]] Outcome test_common(const View& view, float t_min, WideRef leaf, Hit& hit, Count& count) const {
    if (!leaf.is_pack()) [[unlikely]]
      return Outcome::rare;
    const Pack& pack = view.tree.packs[leaf.index()];
    const Corners c = corners(pack);
    const Edges e(c.x, c.y, pack.used());
    if (e.on_edge != 0) [[unlikely]]
      return Outcome::rare;
    count_triangles(pack, count);
    return test_inside(pack, c, e, t_min, hit) ? Outcome::found : Outcome::missed;
  }

  // Lists of primitives, and packs of which some triangle takes double precision. Out of line: what is called from the midst of
  // a loop keeps the loop's vectors out of registers.
  template <class View>
  [[gnu::noinline, gnu::flatten]] static bool test_rare(const View& view, const Ray& ray, const TriangleRay& shear,
                                                        WideRef leaf, Hit& hit, Count& count) {
    if (leaf.is_pack()) {
      LeafTest test;
      test.prepare(ray.origin, shear);
      return test.test_pack(view.geometry, view.tree.packs[leaf.index()], ray, shear, hit, count);
    }
    const WideList list = view.tree.lists[leaf.index()];
    count.primitives(list.count);
    bool found = false;
    for (std::uint32_t i = list.first; i < list.first + list.count; ++i) {
      found |= intersect_primitive(view.geometry, view.tree.list_ids[i], ray, shear, hit);
      if (any_hit && found) return true;
    }
    return found;
  }

  template <class View>
  [[gnu::always_inline]] bool test(const View& view, const Ray& ray, WideRef leaf, Hit& hit, Count& count) const {
    const Outcome outcome = test_common(view, ray.t_min, leaf, hit, count);
    if (outcome == Outcome::rare) [[unlikely]]
      return test_rare(view, ray, TriangleRay(shear_), leaf, hit, count);  // a copy: its address goes to a call
    return outcome == Outcome::found;
  }

 private:
  [[gnu::always_inline]] static void count_triangles(const Pack& pack, Count& count) {
    if constexpr (Count::of_primitives)
      count.primitives(static_cast<std::uint32_t>(Pack::lanes - std::count(pack.ids, pack.ids + Pack::lanes, no_id)));
  }

  // The corners of a pack's triangles in the space of the watertight test, where the ray is the axis; z not yet scaled.
  struct Corners {
    Lanes x[3], y[3], z[3];
  };

  template <int width>
  [[gnu::always_inline]] Corners corners(const TrianglePack<width>& pack) const {
    Corners c;
    for (int i = 0; i < 3; ++i) {
      c.z[i] = Lanes::load(pack.vertices[i][shear_.kz]) - origin_z_;
      c.x[i] = (Lanes::load(pack.vertices[i][shear_.kx]) - origin_x_) - shear_x_ * c.z[i];
      c.y[i] = (Lanes::load(pack.vertices[i][shear_.ky]) - origin_y_) - shear_y_ * c.z[i];
    }
    return c;
  }

  [[gnu::always_inline]] Corners corners(const SharedPack& pack) const {
    static_assert(SharedPack::slots == SharedPack::lanes);
    const Lanes z = Lanes::load(pack.vertices[shear_.kz]) - origin_z_;
    const typename Simd::Table x_of((Lanes::load(pack.vertices[shear_.kx]) - origin_x_) - shear_x_ * z);
    const typename Simd::Table y_of((Lanes::load(pack.vertices[shear_.ky]) - origin_y_) - shear_y_ * z);
    const typename Simd::Table z_of(z);
    Corners c;
    for (int i = 0; i < 3; ++i) {
      c.x[i] = x_of.pick(pack.corners[i]);
      c.y[i] = y_of.pick(pack.corners[i]);
      c.z[i] = z_of.pick(pack.corners[i]);
    }
    return c;
  }

  // intersect_triangle of framework/scene/intersect.h with a triangle in each lane, in its order of operations: first the edge
  // functions, then the distances.
  struct Edges {
    Lanes u, v, w;
    unsigned inside, on_edge;  // triangles that the ray's line meets; those for which only double precision can tell

    [[gnu::always_inline]] Edges(const Lanes (&x)[3], const Lanes (&y)[3], unsigned used)
        : u(x[2] * y[1] - y[2] * x[1]), v(x[0] * y[2] - y[0] * x[2]), w(x[1] * y[0] - y[1] * x[0]) {
      const Sides sides = Simd::sides(u, v, w);
      inside = sides.same & ~sides.on_edge & used;
      on_edge = sides.on_edge & used;
      if (on_edge == 0) [[likely]]
        return;
      // Signs that are not zero are right: two of them that differ tell a miss, as of triangles seen from their edge.
      const Lanes zero = Lanes::set(0);
      const unsigned negative = less(u, zero) | less(v, zero) | less(w, zero);
      const unsigned positive = less(zero, u) | less(zero, v) | less(zero, w);
      on_edge &= ~(negative & positive);
    }
  };

  [[gnu::always_inline]] Lanes distances(const Edges& e, const Lanes (&z)[3], const Lanes& reciprocal) const {
    return (e.u * (shear_z_ * z[0]) + e.v * (shear_z_ * z[1]) + e.w * (shear_z_ * z[2])) * reciprocal;
  }

  bool test_pack(const Geometry& geometry, const Pack& pack, const Ray& ray, const TriangleRay& shear, Hit& hit,
                 Count& count) const {
    count_triangles(pack, count);
    const Corners c = corners(pack);
    const Edges e(c.x, c.y, pack.used());
    const bool found = test_lanes(geometry, pack, e.on_edge, ray, shear, hit);
    if (any_hit && found) return true;
    return test_inside(pack, c, e, ray.t_min, hit) || found;
  }

  // The triangles that single precision tells of.
  [[gnu::always_inline]] bool test_inside(const Pack& pack, const Corners& c, const Edges& e, float t_min, Hit& hit) const {
    unsigned inside = e.inside;
    if (!any_hit && inside == 0) return false;  // any hit: one branch less that nothing predicts
    const Lanes reciprocal = Lanes::set(1) / (e.u + e.v + e.w);
    const Lanes t = distances(e, c.z, reciprocal);
    inside &= less(Lanes::set(t_min), t) & less_equal(t, Lanes::set(hit.t));
    if (inside == 0) return false;
    if constexpr (any_hit) {
      hit.primitive = 0;  // that there is one: to look its id up would fetch one more line
      return true;
    }
    alignas(64) float distance[Pack::lanes];
    t.store(distance);
    int best = std::countr_zero(inside);
    for (unsigned rest = inside & (inside - 1); rest != 0; rest &= rest - 1)
      if (distance[std::countr_zero(rest)] < distance[best]) best = std::countr_zero(rest);
    if (!closer(distance[best], pack.ids[best], hit)) return false;
    alignas(64) float b1[Pack::lanes], b2[Pack::lanes];
    (e.v * reciprocal).store(b1);
    (e.w * reciprocal).store(b2);
    hit.t = distance[best];
    hit.uv = {b1[best], b2[best]};
    hit.primitive = pack.ids[best];
    return true;
  }

  // Lanes whose edge functions vanish in single precision, and needles: the scalar test turns to double for them.
  static bool test_lanes(const Geometry& geometry, const Pack& pack, unsigned lanes, const Ray& ray, const TriangleRay& shear,
                         Hit& hit) {
    bool found = false;
    for (; lanes != 0; lanes &= lanes - 1)
      found |= intersect_primitive(geometry, pack.ids[std::countr_zero(lanes)], ray, shear, hit);
    return found;
  }

  TriangleRay shear_;
  Lanes origin_x_, origin_y_, origin_z_, shear_x_, shear_y_, shear_z_;
};

// As the caller gets it: a hit in the first instance, or none.
inline Hit placed(const Hit& hit) { return hit ? Hit{hit.t, hit.uv, 0, hit.primitive} : Hit{}; }

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
