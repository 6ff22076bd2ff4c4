// One ray against the triangles of a pack, side by side, lowering a hit: the test of triangle_test.h with a triangle in each
// lane. What takes double precision goes to the scalar form. Any hit will do for `any_hit`: then Hit::primitive tells that
// there is one, and nothing more.
#pragma once

#include "accel/kernels/primitive_test.h"
#include "accel/kernels/shared_pack.h"
#include "accel/kernels/triangle_pack.h"

#include <bit>

namespace etendue {

template <class Lanes, class Pack, bool any_hit>
class PackQuery {
 public:
  enum class Outcome { missed, found, rare };

  PackQuery() = default;
  [[gnu::always_inline]] PackQuery(const TriangleRay& shear, const TriangleTest<Lanes>& test) : shear_(shear), test_(test) {}
  [[gnu::always_inline]] PackQuery(const vec3& origin, const TriangleRay& shear) : shear_(shear), test_(shear, origin) {}

  TriangleRay shear() const { return shear_; }

  // Tests by SIMD instructions alone. `rare`: it takes more, nothing was done, and test_rare must be asked.
  [[gnu::always_inline]] Outcome test_common(const Pack& pack, float t_min, Hit& hit) const {
    if constexpr (halves)
      if (pack.count <= Pack::lanes / 2) return test_common(pack, half_corners(pack), test_.halved(), t_min, hit);
    return test_common(pack, corners(pack), test_, t_min, hit);
  }

  // Tests all of a pack, where some triangle takes double precision.
  bool test_rare(const Geometry& geometry, const Pack& pack, const Ray& ray, Hit& hit) const {
    return test_all(geometry, pack, pack.used(), ray, hit, [&](unsigned inside) { return inside & pack.needles(); });
  }
  // Tests the triangles in lanes `used`; `needles(inside)` tells which of some are needles.
  template <class Needles>
  bool test_all(const Geometry& geometry, const Pack& pack, unsigned used, const Ray& ray, Hit& hit,
                const Needles& needles) const {
    const Corners<Lanes> c = corners(pack);
    const TriangleEdges<Lanes> e(c.x, c.y, used);
    unsigned rare = e.on_edge;
    if (e.inside != 0) rare |= needles(e.inside);
    bool found = false;
    for (unsigned rest = rare; rest != 0 && !(any_hit && found); rest &= rest - 1)
      found |= intersect_primitive(geometry, pack.ids[std::countr_zero(rest)], ray, shear_, hit);
    return (any_hit && found) || test_inside(pack, c, test_, e, e.inside & ~rare, ray.t_min, hit) || found;
  }

  // Whether a pack has any hit, with no branch on what the ray meets; `rare` as above.
  [[gnu::always_inline]] bool occluded(const Pack& pack, float t_min, float t_max, bool& rare) const {
    if constexpr (halves)
      if (pack.count <= Pack::lanes / 2) return occluded(pack, half_corners(pack), test_.halved(), t_min, t_max, rare);
    return occluded(pack, corners(pack), test_, t_min, t_max, rare);
  }

 private:
  // Where lanes are two registers, packs that are at most half full take one.
  static constexpr bool halves = requires(Lanes l, Pack p) {
    l.low;
    p.count;
  };

  // These are a pack's triangles in the ray's space.
  template <class L>
  struct Corners {
    L x[3], y[3], z[3];
  };

  template <class L>
  [[gnu::always_inline]] Outcome test_common(const Pack& pack, const Corners<L>& c, const TriangleTest<L>& test, float t_min,
                                             Hit& hit) const {
    const TriangleEdges<L> e(c.x, c.y, pack.used());
    if ((e.on_edge | (e.inside & pack.needles())) != 0) [[unlikely]]
      return Outcome::rare;
    return test_inside(pack, c, test, e, e.inside, t_min, hit) ? Outcome::found : Outcome::missed;
  }
  template <class L>
  [[gnu::always_inline]] static bool occluded(const Pack& pack, const Corners<L>& c, const TriangleTest<L>& test, float t_min,
                                              float t_max, bool& rare) {
    const TriangleEdges<L> e(c.x, c.y, pack.used());
    const L t = test.distances(e, c.z, L::set(1) / (e.u + e.v + e.w));
    rare = (e.on_edge | (e.inside & pack.needles())) != 0;
    return (e.inside & less(L::set(t_min), t) & less_equal(t, L::set(t_max))) != 0;
  }

  template <int width>
  [[gnu::always_inline]] Corners<Lanes> corners(const TrianglePack<width>& pack) const {
    Corners<Lanes> c;
    for (int i = 0; i < 3; ++i) {
      c.z[i] = Lanes::load(pack.vertices[i][shear_.kz]);
      c.x[i] = Lanes::load(pack.vertices[i][shear_.kx]);
      c.y[i] = Lanes::load(pack.vertices[i][shear_.ky]);
      test_.move(c.x[i], c.y[i], c.z[i]);
    }
    return c;
  }
  [[gnu::always_inline]] Corners<Lanes> corners(const SharedPack& pack) const {
    return picked_corners<Lanes>(pack, [](const Lanes& all, const std::uint8_t* slots) { return all.pick(slots); });
  }
  [[gnu::always_inline]] auto half_corners(const SharedPack& pack) const {
    return picked_corners<typename Lanes::Half>(
        pack, [](const Lanes& all, const std::uint8_t* slots) { return all.pick_half(slots); });
  }
  template <class L, class Pick>
  [[gnu::always_inline]] Corners<L> picked_corners(const SharedPack& pack, const Pick& pick) const {
    static_assert(SharedPack::slots == SharedPack::lanes);
    Lanes x = Lanes::load(pack.vertices[shear_.kx]), y = Lanes::load(pack.vertices[shear_.ky]),
          z = Lanes::load(pack.vertices[shear_.kz]);
    test_.move(x, y, z);
    Corners<L> c;
    for (int i = 0; i < 3; ++i) {
      c.x[i] = pick(x, pack.corners[i]);
      c.y[i] = pick(y, pack.corners[i]);
      c.z[i] = pick(z, pack.corners[i]);
    }
    return c;
  }

  // The triangles that single precision tells of. Ids ascend, so the first of those at the least distance is the lowest.
  template <class L>
  [[gnu::always_inline]] static bool test_inside(const Pack& pack, const Corners<L>& c, const TriangleTest<L>& test,
                                                 const TriangleEdges<L>& e, unsigned inside, float t_min, Hit& hit) {
    if (!any_hit && inside == 0) return false;  // any hit: one branch less that nothing predicts
    const L reciprocal = L::set(1) / (e.u + e.v + e.w);
    const L t = test.distances(e, c.z, reciprocal);
    inside &= less(L::set(t_min), t) & less_equal(t, L::set(hit.t));
    if (inside == 0) return false;
    if constexpr (any_hit) {
      hit.primitive = 0;  // to look its id up would fetch one more line
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

  TriangleRay shear_;
  TriangleTest<Lanes> test_;
};

}  // namespace etendue
