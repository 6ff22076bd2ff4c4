// The watertight triangle test of [Woop2013] with a triangle, or a ray, in each lane; one lane is the scalar form, which also
// has what single precision cannot tell.
//
// An edge function that is zero is taken in double precision, and so is the distance of a long and thin triangle. Whoever tests
// several triangles at once leaves both to the scalar form, so every structure finds the same hits, to the bit. (FMA
// contraction must be off, which the build sets for the whole project: with it edges leak.)
#pragma once

#include "accel/kernels/floats.h"
#include "framework/query.h"

#include <utility>

namespace etendue {

// The part of the test that depends on the ray alone.
struct TriangleRay {
  int kx, ky, kz;
  float sx, sy, sz;

  TriangleRay() = default;
  explicit TriangleRay(const vec3& direction) {
    // No branch is taken: which axis is the longest cannot be predicted.
    const vec3 a = glm::abs(direction);
    const int y_beats_x = !(a.x > a.y), z_beats_both = !(std::max(a.y, a.x) > a.z);
    kz = 2 * z_beats_both + (y_beats_x & ~z_beats_both);
    static constexpr int next[] = {1, 2, 0, 1};
    const float along = component(direction, kz);
    const int backwards = along < 0;
    kx = next[kz + backwards];
    ky = next[kz + 1 - backwards];
    sx = component(direction, kx) / along;
    sy = component(direction, ky) / along;
    sz = 1.0f / along;
  }
};

// Holds what the signs of three edge functions tell, a lane each. Masks are bits here, or whatever the lanes' comparisons give.
template <class Mask>
struct Sides {
  Mask same, on_edge;  // all positive or all negative; some are zero
};

template <class Lanes>
[[gnu::always_inline]] inline auto below(const Lanes& u, const Lanes& v, const Lanes& w) {
  const Lanes zero{};
  return less(u, zero) | less(v, zero) | less(w, zero);
}
template <class Lanes>
[[gnu::always_inline]] inline auto above(const Lanes& u, const Lanes& v, const Lanes& w) {
  const Lanes zero{};
  return less(zero, u) | less(zero, v) | less(zero, w);
}
template <class Lanes>
[[gnu::always_inline]] inline auto sides(const Lanes& u, const Lanes& v, const Lanes& w) {
  const Lanes zero{};
  const auto same = below(u, v, w) ^ above(u, v, w), on_edge = equal(u, zero) | equal(v, zero) | equal(w, zero);
  return Sides<std::remove_const_t<decltype(same)>>{same, on_edge};
}
// Sign bits tell it in a register. Lanes of NaN may count as the same; no distance there is in range.
template <int width, int widest>
requires(1 < width && width <= widest)
    [[gnu::always_inline]] inline Sides<unsigned> sides(const Floats<width, widest>& u, const Floats<width, widest>& v,
                                                        const Floats<width, widest>& w) {
#if defined(__AVX512DQ__)
  if constexpr (width == 16) {
    const auto bits = [](__m512 a) { return _mm512_castps_si512(a); };
    const __m512i differs = _mm512_ternarylogic_epi32(bits(u.v), bits(v.v), bits(w.v), 0x7e);  // neither all set nor all clear
    const __m512 least = _mm512_range_ps(_mm512_range_ps(u.v, v.v, 2), w.v, 2);                // of magnitudes
    return {static_cast<__mmask16>(~_mm512_movepi32_mask(differs)), _mm512_cmp_ps_mask(least, _mm512_setzero_ps(), _CMP_EQ_OQ)};
  } else
#endif
  {
    using Ints = Vector<std::int32_t, width>;
    const auto bits = [](Vector<float, width> a) { return reinterpret_cast<Ints>(a); };
    const Ints differs = (bits(u.v) ^ bits(v.v)) | (bits(v.v) ^ bits(w.v));
    constexpr Vector<float, width> zero{};
    return {~lane_bits(differs) & ((1u << width) - 1), lane_bits((u.v == zero) | (v.v == zero) | (w.v == zero))};
  }
}
template <int width, int widest>
requires(width > widest)
    [[gnu::always_inline]] inline Sides<unsigned> sides(const Floats<width, widest>& u, const Floats<width, widest>& v,
                                                        const Floats<width, widest>& w) {
  const Sides<unsigned> low = sides(u.low, v.low, w.low), high = sides(u.high, v.high, w.high);
  return {low.same | high.same << width / 2, low.on_edge | high.on_edge << width / 2};
}

template <class Mask>
[[gnu::always_inline]] inline Mask without(Mask a, Mask b) {
  return a ^ (a & b);
}

// Edge functions of the triangles, and what they tell.
template <class Lanes>
struct TriangleEdges {
  using Mask = decltype(less(std::declval<Lanes>(), std::declval<Lanes>()));

  Lanes u, v, w;
  Mask inside;   // the triangles that the ray's line meets
  Mask on_edge;  // and those for which only double precision can tell

  // Corners in the ray's space; `used`: the lanes that count.
  [[gnu::always_inline]] TriangleEdges(const Lanes (&x)[3], const Lanes (&y)[3], Mask used)
      : u(x[2] * y[1] - y[2] * x[1]), v(x[0] * y[2] - y[0] * x[2]), w(x[1] * y[0] - y[1] * x[0]) {
    const auto s = sides(u, v, w);
    on_edge = s.on_edge & used;
    inside = without<Mask>(s.same & used, s.on_edge);
    // Signs that are not zero are right: two that differ tell a miss, as of triangles seen from their edge.
    if (any_lane(on_edge)) [[unlikely]]
      on_edge = without<Mask>(on_edge, below(u, v, w) & above(u, v, w));
  }
};

// Terms of one ray, or of a ray in each lane.
template <class Lanes>
struct TriangleTest {
  Lanes origin_x, origin_y, origin_z;  // along the axes of TriangleRay
  Lanes shear_x, shear_y, shear_z;

  TriangleTest() = default;
  [[gnu::always_inline]] TriangleTest(const Lanes& ox, const Lanes& oy, const Lanes& oz, const Lanes& sx, const Lanes& sy,
                                      const Lanes& sz)
      : origin_x(ox), origin_y(oy), origin_z(oz), shear_x(sx), shear_y(sy), shear_z(sz) {}
  [[gnu::always_inline]] TriangleTest(const TriangleRay& ray, float origin_kx, float origin_ky, float origin_kz)
      : origin_x(Lanes::set(origin_kx)),
        origin_y(Lanes::set(origin_ky)),
        origin_z(Lanes::set(origin_kz)),
        shear_x(Lanes::set(ray.sx)),
        shear_y(Lanes::set(ray.sy)),
        shear_z(Lanes::set(ray.sz)) {}
  [[gnu::always_inline]] TriangleTest(const TriangleRay& ray, const vec3& origin)
      : TriangleTest(ray, component(origin, ray.kx), component(origin, ray.ky), component(origin, ray.kz)) {}

  // The test of the first half of the lanes.
  auto halved() const {
    return TriangleTest<typename Lanes::Half>{origin_x.low, origin_y.low, origin_z.low, shear_x.low, shear_y.low, shear_z.low};
  }

  // Moves vertices, given along the axes of TriangleRay, into the space where the ray is the z axis; z is not yet scaled.
  [[gnu::always_inline]] void move(Lanes& x, Lanes& y, Lanes& z) const {
    z = z - origin_z;
    x = (x - origin_x) - shear_x * z;
    y = (y - origin_y) - shear_y * z;
  }
  [[gnu::always_inline]] Lanes distances(const TriangleEdges<Lanes>& e, const Lanes (&z)[3], const Lanes& reciprocal) const {
    return (e.u * (shear_z * z[0]) + e.v * (shear_z * z[1]) + e.w * (shear_z * z[2])) * reciprocal;
  }
};

// Is a triangle's height less than a 32nd of its extent, or nearly? Rounding its vertices in a ray's space then shifts its
// plane by more than clearance_of allows for: of rays in a box of 100 by 1 by 1, one in 200,000 left it. Where squares of
// metres leave the range of floats, no triangle is one: scenes are larger than that (precision.h) and smaller
// (object_builder.h).
inline bool is_needle(const vec3& p0, const vec3& p1, const vec3& p2) {
  constexpr float least = 1e-18f, most = 1e18f;
  const vec3 e1 = p1 - p0, e2 = p2 - p0;
  const float extent = max_component(glm::max(glm::abs(e1), glm::abs(e2)));
  return 32 * max_component(glm::abs(glm::cross(e1, e2))) < extent * extent && extent > least &&
         std::max(extent, max_component(glm::abs(p0))) < most;
}

// Distance and barycentrics of a needle, in double precision, where the test tells that the ray's line meets it. That is not
// asked again, so that no ray passes between a needle and its neighbours. A ray in the triangle's plane gives false.
bool place_on_needle(const Ray& ray, const TriangleRay& shear, const vec3& p0, const vec3& p1, const vec3& p2, float& t_out,
                     vec2& uv_out);

// The scalar form: distance and barycentrics of the second and third vertex, if t lies in (t_min, t_max].
inline bool intersect_triangle(const Ray& ray, const TriangleRay& shear, const vec3& p0, const vec3& p1, const vec3& p2,
                               float t_max, float& t_out, vec2& uv_out) {
  using One = Floats<1, 1>;
  const TriangleTest<One> test(shear, ray.origin);
  const vec3* const vertices[] = {&p0, &p1, &p2};
  One x[3], y[3], z[3];
  for (int i = 0; i < 3; ++i) {
    x[i] = {component(*vertices[i], shear.kx)};
    y[i] = {component(*vertices[i], shear.ky)};
    z[i] = {component(*vertices[i], shear.kz)};
    test.move(x[i], y[i], z[i]);
  }
  TriangleEdges<One> e(x, y, 1);
  if (e.on_edge != 0) [[unlikely]] {
    const auto edge = [&](int i, int j) {
      return static_cast<float>(static_cast<double>(x[i].v) * y[j].v - static_cast<double>(y[i].v) * x[j].v);
    };
    e.u = {edge(2, 1)};
    e.v = {edge(0, 2)};
    e.w = {edge(1, 0)};
    if (std::min({e.u.v, e.v.v, e.w.v}) < 0 && std::max({e.u.v, e.v.v, e.w.v}) > 0) return false;
  } else if (e.inside == 0) {
    return false;
  }
  const float det = e.u.v + e.v.v + e.w.v;
  if (!(std::abs(det) > 0)) return false;
  const One reciprocal{1.0f / det};
  float t = test.distances(e, z, reciprocal).v;
  vec2 uv(e.v.v * reciprocal.v, e.w.v * reciprocal.v);
  if (is_needle(p0, p1, p2)) [[unlikely]]
    place_on_needle(ray, shear, p0, p1, p2, t, uv);
  if (!(t > ray.t_min && t <= t_max) || t == infinity) return false;  // infinite where 1 / det is
  t_out = t;
  uv_out = uv;
  return true;
}

}  // namespace etendue
