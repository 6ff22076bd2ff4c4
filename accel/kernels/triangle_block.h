// Four triangles side by side, tested together: the watertight test of framework/scene/intersect.h with a triangle per SIMD
// lane.
//
// The operations and their order are those of intersect_triangle, so each lane gives the same bits as the scalar test. Where
// that turns to double precision, for an edge function that is zero or for a needle, the whole block is tested by it.
#pragma once

#include "framework/scene/intersect.h"

#include <array>
#include <bit>

#if defined(__SSE4_1__)
#include <smmintrin.h>
#endif

namespace etendue {

// Per ray: what the test takes from it.
struct BlockRay {
  const Ray& ray;
  TriangleRay shear;

  explicit BlockRay(const Ray& r) : ray(r), shear(r.direction) {}
};

struct alignas(16) TriangleBlock {
  static constexpr std::uint32_t width = 4;
  struct Hits {
    int mask = 0;  // bit i: triangle i is hit
    alignas(16) std::array<float, width> t, u, v;
  };

  // By vertex and axis. Lanes without a triangle hold NaN, which nothing hits.
  std::array<std::array<std::array<float, width>, 3>, 3> vertices;

  TriangleBlock() {
    for (auto& vertex : vertices)
      for (auto& axis : vertex) axis.fill(std::numeric_limits<float>::quiet_NaN());
  }
  void set(std::uint32_t lane, const vec3& p0, const vec3& p1, const vec3& p2) {
    for (int axis = 0; axis < 3; ++axis) {
      vertices[0][axis][lane] = p0[axis];
      vertices[1][axis][lane] = p1[axis];
      vertices[2][axis][lane] = p2[axis];
    }
  }
  vec3 vertex(std::uint32_t lane, int i) const { return {vertices[i][0][lane], vertices[i][1][lane], vertices[i][2][lane]}; }

  // Fills `hits` in the lanes of its mask: those hit at t in (t_min, t_max]. `any_needle(mask)`: is one of these lanes a
  // needle?
  template <class AnyNeedle>
  void intersect(const BlockRay& ray, float t_max, const AnyNeedle& any_needle, Hits& hits) const;

 private:
  void intersect_each(const BlockRay& ray, float t_max, Hits& hits) const {
    hits.mask = 0;
    for (std::uint32_t lane = 0; lane < width; ++lane) {
      vec2 uv;
      if (!intersect_triangle(ray.ray, ray.shear, vertex(lane, 0), vertex(lane, 1), vertex(lane, 2), t_max, hits.t[lane], uv))
        continue;
      hits.mask |= 1 << lane;
      hits.u[lane] = uv.x;
      hits.v[lane] = uv.y;
    }
  }
};

#if defined(__SSE4_1__)

template <class AnyNeedle>
void TriangleBlock::intersect(const BlockRay& ray, float t_max, const AnyNeedle& any_needle, Hits& hits) const {
  const TriangleRay& shear = ray.shear;
  const float* const origin = &ray.ray.origin.x;
  const __m128 ox = _mm_set1_ps(origin[shear.kx]), oy = _mm_set1_ps(origin[shear.ky]), oz = _mm_set1_ps(origin[shear.kz]);
  const __m128 sx = _mm_set1_ps(shear.sx), sy = _mm_set1_ps(shear.sy), sz = _mm_set1_ps(shear.sz);
  __m128 x[3], y[3], z[3];  // vertices a, b, c in the sheared space, z not yet scaled
  for (int i = 0; i < 3; ++i) {
    z[i] = _mm_sub_ps(_mm_load_ps(vertices[i][shear.kz].data()), oz);
    x[i] = _mm_sub_ps(_mm_sub_ps(_mm_load_ps(vertices[i][shear.kx].data()), ox), _mm_mul_ps(sx, z[i]));
    y[i] = _mm_sub_ps(_mm_sub_ps(_mm_load_ps(vertices[i][shear.ky].data()), oy), _mm_mul_ps(sy, z[i]));
  }
  const __m128 u = _mm_sub_ps(_mm_mul_ps(x[2], y[1]), _mm_mul_ps(y[2], x[1]));
  const __m128 v = _mm_sub_ps(_mm_mul_ps(x[0], y[2]), _mm_mul_ps(y[0], x[2]));
  const __m128 w = _mm_sub_ps(_mm_mul_ps(x[1], y[0]), _mm_mul_ps(y[1], x[0]));
  const __m128 zero = _mm_setzero_ps();
  // Signs alone tell the sides apart, once no edge function is zero; lanes of NaN fall out at the comparison of t.
  const __m128 some_zero = _mm_or_ps(_mm_or_ps(_mm_cmpeq_ps(u, zero), _mm_cmpeq_ps(v, zero)), _mm_cmpeq_ps(w, zero));
  if (_mm_movemask_ps(some_zero) != 0) [[unlikely]]
    return intersect_each(ray, t_max, hits);
  const __m128 differs = _mm_or_ps(_mm_xor_ps(u, v), _mm_xor_ps(v, w));
  hits.mask = ~_mm_movemask_ps(differs) & 0xf;
  if (hits.mask == 0) return;
  if (any_needle(hits.mask)) [[unlikely]]
    return intersect_each(ray, t_max, hits);
  const __m128 det = _mm_add_ps(_mm_add_ps(u, v), w);
  const __m128 reciprocal = _mm_div_ps(_mm_set1_ps(1.0f), det);
  const __m128 depth = _mm_add_ps(_mm_add_ps(_mm_mul_ps(u, _mm_mul_ps(sz, z[0])), _mm_mul_ps(v, _mm_mul_ps(sz, z[1]))),
                                  _mm_mul_ps(w, _mm_mul_ps(sz, z[2])));
  const __m128 t = _mm_mul_ps(depth, reciprocal);
  const __m128 in_range = _mm_and_ps(_mm_cmpgt_ps(t, _mm_set1_ps(ray.ray.t_min)),
                                     _mm_cmple_ps(t, _mm_set1_ps(std::min(t_max, std::numeric_limits<float>::max()))));
  hits.mask &= _mm_movemask_ps(in_range);
  if (hits.mask == 0) return;
  _mm_store_ps(hits.t.data(), t);
  _mm_store_ps(hits.u.data(), _mm_mul_ps(v, reciprocal));
  _mm_store_ps(hits.v.data(), _mm_mul_ps(w, reciprocal));
}

#else

template <class AnyNeedle>
void TriangleBlock::intersect(const BlockRay& ray, float t_max, const AnyNeedle&, Hits& hits) const {
  intersect_each(ray, t_max, hits);
}

#endif

}  // namespace etendue
