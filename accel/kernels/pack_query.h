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
  using Edges = TriangleEdges<Lanes>;
  enum class Outcome { missed, found, rare };

  PackQuery() = default;
  [[gnu::always_inline]] PackQuery(const TriangleRay& shear, const TriangleTest<Lanes>& test) : shear_(shear), test_(test) {}
  [[gnu::always_inline]] PackQuery(const vec3& origin, const TriangleRay& shear) : shear_(shear), test_(shear, origin) {}

  TriangleRay shear() const { return shear_; }

  // By SIMD instructions alone. `rare`: it takes more, nothing was done, and test_rare must be asked.
  [[gnu::always_inline]] Outcome test_common(const Pack& pack, float t_min, Hit& hit) const {
    const Corners c = corners(pack);
    const Edges e(c.x, c.y, pack.used());
    if ((e.on_edge | (e.inside & pack.needles())) != 0) [[unlikely]]
      return Outcome::rare;
    return test_inside(pack, c, e, e.inside, t_min, hit) ? Outcome::found : Outcome::missed;
  }

  // All of a pack, where some triangle takes double precision.
  bool test_rare(const Geometry& geometry, const Pack& pack, const Ray& ray, Hit& hit) const {
    return test_all(geometry, pack, pack.used(), ray, hit, [&](unsigned inside) { return inside & pack.needles(); });
  }
  // The triangles in lanes `used`; `needles(inside)`: which of some are needles.
  template <class Needles>
  bool test_all(const Geometry& geometry, const Pack& pack, unsigned used, const Ray& ray, Hit& hit,
                const Needles& needles) const {
    const Corners c = corners(pack);
    const Edges e(c.x, c.y, used);
    unsigned rare = e.on_edge;
    if (e.inside != 0) rare |= needles(e.inside);
    bool found = false;
    for (unsigned rest = rare; rest != 0 && !(any_hit && found); rest &= rest - 1)
      found |= intersect_primitive(geometry, pack.ids[std::countr_zero(rest)], ray, shear_, hit);
    return (any_hit && found) || test_inside(pack, c, e, e.inside & ~rare, ray.t_min, hit) || found;
  }

  // Whether a pack has any hit, with no branch on what the ray meets; `rare` as above.
  [[gnu::always_inline]] bool occluded(const Pack& pack, float t_min, float t_max, bool& rare) const {
    const Corners c = corners(pack);
    const Edges e(c.x, c.y, pack.used());
    const Lanes t = test_.distances(e, c.z, Lanes::set(1) / (e.u + e.v + e.w));
    rare = (e.on_edge | (e.inside & pack.needles())) != 0;
    return (e.inside & less(Lanes::set(t_min), t) & less_equal(t, Lanes::set(t_max))) != 0;
  }

 private:
  // Of a pack's triangles in the ray's space.
  struct Corners {
    Lanes x[3], y[3], z[3];
  };

  template <int width>
  [[gnu::always_inline]] Corners corners(const TrianglePack<width>& pack) const {
    Corners c;
    for (int i = 0; i < 3; ++i) {
      c.z[i] = Lanes::load(pack.vertices[i][shear_.kz]);
      c.x[i] = Lanes::load(pack.vertices[i][shear_.kx]);
      c.y[i] = Lanes::load(pack.vertices[i][shear_.ky]);
      test_.move(c.x[i], c.y[i], c.z[i]);
    }
    return c;
  }

  [[gnu::always_inline]] Corners corners(const SharedPack& pack) const {
    static_assert(SharedPack::slots == SharedPack::lanes);
    Lanes x = Lanes::load(pack.vertices[shear_.kx]), y = Lanes::load(pack.vertices[shear_.ky]),
          z = Lanes::load(pack.vertices[shear_.kz]);
    test_.move(x, y, z);
    Corners c;
    for (int i = 0; i < 3; ++i) {
      c.x[i] = x.pick(pack.corners[i]);
      c.y[i] = y.pick(pack.corners[i]);
      c.z[i] = z.pick(pack.corners[i]);
    }
    return c;
  }

  // The triangles that single precision tells of. Ids ascend, so the first of those at the least distance is the lowest.
  [[gnu::always_inline]] bool test_inside(const Pack& pack, const Corners& c, const Edges& e, unsigned inside, float t_min,
                                          Hit& hit) const {
    if (!any_hit && inside == 0) return false;  // any hit: one branch less that nothing predicts
    const Lanes reciprocal = Lanes::set(1) / (e.u + e.v + e.w);
    const Lanes t = test_.distances(e, c.z, reciprocal);
    inside &= less(Lanes::set(t_min), t) & less_equal(t, Lanes::set(hit.t));
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
