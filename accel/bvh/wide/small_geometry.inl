// A batch of rays against all primitives of a small geometry, a ray in each lane, for one instruction set; included like
// wide_tests.inl.
//
// Every vertex is moved into each ray's space once; the triangles then come in the order of their ids, so that the first of
// those at equal distance wins. A lane does what the scalar test does, to the bit; where that turns to double precision, and
// for primitives that are no triangles, the scalar test is asked.
#pragma once

#include "accel/bvh/wide/wide_tests.inl"
#include "framework/core/lanes_wide.inl"

namespace etendue {
namespace {

// The comparisons of TriangleEdges.
inline WideMask less(WideFloats a, WideFloats b) { return a < b; }
inline WideMask equal(WideFloats a, WideFloats b) { return a == b; }
inline bool any_lane(WideMask mask) { return any(mask); }
inline Sides<WideMask> sides(const WideFloats& u, const WideFloats& v, const WideFloats& w) {
#if defined(__AVX512F__)
  using Lanes = Floats<16, 16>;
  const Sides<unsigned> s = sides(Lanes{u.v}, Lanes{v.v}, Lanes{w.v});
  return {WideMask(static_cast<__mmask16>(s.same)), WideMask(static_cast<__mmask16>(s.on_edge))};
#else
  const auto bits = [](const WideFloats& a) { return reinterpret_cast<IntVector>(a.v); };
  return {WideMask(((bits(u) ^ bits(v)) | (bits(v) ^ bits(w))) >= 0), (u == 0.0f) | (v == 0.0f) | (w == 0.0f)};
#endif
}

// One coordinate of a vertex in each lane, as `axis` says.
inline WideFloats coordinate(const SmallGeometry::Vertex& vertex, WideBits axis) {
#if defined(__AVX512F__)
  const __m512 all = _mm512_broadcast_f32x4(_mm_load_ps(vertex.coordinates));
  return WideFloats::of(_mm512_permutevar_ps(all, reinterpret_cast<__m512i>(axis.v)));
#elif defined(__AVX2__)
  const __m256 all = _mm256_broadcast_ps(reinterpret_cast<const __m128*>(vertex.coordinates));
  return WideFloats::of(_mm256_permutevar_ps(all, reinterpret_cast<__m256i>(axis.v)));
#else
  WideFloats picked;
  for (int lane = 0; lane < widest_lanes; ++lane) picked.v[lane] = vertex.coordinates[axis.v[lane]];
  return picked;
#endif
}

template <bool any_hit>
class SmallGeometryQuery {
 public:
  // Answers the first widest_lanes rays at most. `answer(i, hit)` is called for each.
  template <class Answer>
  static void run(const SmallGeometry& small, const Geometry& geometry, std::span<const Ray> rays, const Answer& answer) {
    SmallGeometryQuery query(small, geometry, rays);
    query.move_vertices();
    query.test_triangles();
    query.finish(answer);
  }

 private:
  SmallGeometryQuery(const SmallGeometry& small, const Geometry& geometry, std::span<const Ray> rays)
      : small_(small), geometry_(geometry), rays_(rays) {
    alignas(64) float fields[8][widest_lanes];
    static_assert(sizeof(Ray) == 8 * sizeof(float));
    for (int lane = 0; lane < widest_lanes; ++lane) {
      const float* const ray = &rays[std::min<std::size_t>(lane, rays.size() - 1)].origin.x;
      for (int field = 0; field < 8; ++field) fields[field][lane] = ray[field];
    }
    const auto field = [&](int i) { return WideFloats::load(fields[i]); };
    origin_ = {field(0), field(1), field(2)};
    t_min_ = field(3);
    direction_ = {field(4), field(5), field(6)};
    const WideFloats t_max = field(7);
    const WideVec3 origin_size = abs(origin_), size = abs(direction_);
    const WideMask finite = (origin_size.x < infinity) & (origin_size.y < infinity) & (origin_size.z < infinity) &
                            (size.x < infinity) & (size.y < infinity) & (size.z < infinity);
    live_ = finite & !is_black(direction_) & (t_min_ <= t_max);
    // The next float above farthest_hit: what is nearer than that is a hit.
    best_ = float_of(bits_of(select(t_max < std::numeric_limits<float>::max(), t_max, std::numeric_limits<float>::max())) + 1u);
    limit_ = best_ * 1.00001f;
    set_shears(size);
  }

  // Does what TriangleRay's constructor does.
  void set_shears(const WideVec3& size) {
    const WideMask is_z = !(max(size.y, size.x) > size.z), is_y = !(size.x > size.y) & !is_z;
    const auto pick = [&](auto x, auto y, auto z) { return select(is_z, z, select(is_y, y, x)); };
    const WideFloats along = pick(direction_.x, direction_.y, direction_.z);
    const WideMask backwards = along < 0;
    const WideBits next = pick(WideBits(1u), WideBits(2u), WideBits(0u)),
                   after = pick(WideBits(2u), WideBits(0u), WideBits(1u));
    kx_ = select(backwards, after, next);
    ky_ = select(backwards, next, after);
    kz_ = pick(WideBits(0u), WideBits(1u), WideBits(2u));
    const auto by_axis = [&](const WideVec3& v, WideBits axis) {
      return select(is_axis(axis, 0), v.x, select(is_axis(axis, 1), v.y, v.z));
    };
    test_.origin_x = by_axis(origin_, kx_);
    test_.origin_y = by_axis(origin_, ky_);
    test_.origin_z = by_axis(origin_, kz_);
    test_.shear_x = by_axis(direction_, kx_) / along;
    test_.shear_y = by_axis(direction_, ky_) / along;
    test_.shear_z = 1.0f / along;
  }
  static WideMask is_axis(WideBits axis, std::uint32_t number) { return to_float(axis) == static_cast<float>(number); }

  void move_vertices() {
    for (std::size_t i = 0; i < small_.vertices.size(); ++i) {
      const SmallGeometry::Vertex& vertex = small_.vertices[i];
      WideFloats x = coordinate(vertex, kx_), y = coordinate(vertex, ky_), z = coordinate(vertex, kz_);
      test_.move(x, y, z);
      moved_[i] = {x, y, test_.shear_z * z};
    }
  }

  void test_triangles() {
    for (const SmallGeometry::Triangle& triangle : small_.triangles) {
      const WideVec3 &a = moved_[triangle.corners[0]], &b = moved_[triangle.corners[1]], &c = moved_[triangle.corners[2]];
      const TriangleEdges<WideFloats> e({a.x, b.x, c.x}, {a.y, b.y, c.y}, live_);
      const WideFloats det = e.u + e.v + e.w, along = e.u * a.z + e.v * b.z + e.w * c.z;
      WideMask inside = e.inside;
      if constexpr (any_hit) {  // most rays are occluded by none, which shows without a division
        const WideFloats forward = float_of(bits_of(along) ^ (bits_of(det) & 0x80000000u));
        inside = inside & (forward > 0.0f) & (forward <= limit_ * abs(det) + 1e-36f);
      }
      if (any(inside)) take_nearer(inside, e, along, 1.0f / det, triangle.id);
      if (any(e.on_edge)) [[unlikely]]
        test_scalar(e.on_edge, triangle.id);
      if (any_hit && !any(live_)) return;
    }
  }

  // `along`: distances times the sums of the edge functions.
  void take_nearer(WideMask inside, const TriangleEdges<WideFloats>& e, WideFloats along, WideFloats reciprocal,
                   std::uint32_t id) {
    const WideFloats t = along * reciprocal;
    const WideMask hit = inside & (t_min_ < t) & (t < best_);
    if constexpr (any_hit) {
      found_ = found_ | hit;
      live_ = live_ & !hit;
    } else {
      best_ = select(hit, t, best_);
      best_u_ = select(hit, e.v * reciprocal, best_u_);
      best_v_ = select(hit, e.w * reciprocal, best_v_);
      best_id_ = select(hit, WideBits(id), best_id_);
    }
  }

  [[gnu::noinline, gnu::flatten]] void test_scalar(WideMask lanes, std::uint32_t id) {
    for_lanes(lanes, [&](int i) {
      if (static_cast<std::size_t>(i) >= rays_.size()) return;
      Hit hit = hit_of(i);
      if (!intersect_primitive(geometry_, id, rays_[i], TriangleRay(rays_[i].direction), hit)) return;
      best_.v[i] = hit.t;
      best_u_.v[i] = hit.uv.x;
      best_v_.v[i] = hit.uv.y;
      best_id_.v[i] = id;
      found_ = found_ | only(i);
      if (any_hit) live_ = live_ & !only(i);
    });
  }
  static WideMask only(int lane) { return WideMask::first(lane + 1) & !WideMask::first(lane); }

  Hit hit_of(int lane) const {
    const std::uint32_t id = best_id_.v[lane];
    Hit hit{best_.v[lane], {best_u_.v[lane], best_v_.v[lane]}, no_id, id};
    if (id == no_id) hit.t = farthest_hit(rays_[lane]);
    return hit;
  }

  // The lanes whose ray's line meets a sphere, by the discriminant of intersect_quadric, or may do so where that is corrected;
  // of other quadrics all.
  WideMask may_meet(std::uint32_t id) const {
    if (geometry_.is_triangle(id)) return live_;
    const auto* const sphere = std::get_if<Sphere>(&geometry_.quadric(id));
    if (sphere == nullptr) return live_;
    const WideVec3 o = origin_ - WideVec3(sphere->centre);
    const WideFloats squared = dot(direction_, direction_);
    const WideVec3 remainder = o + (-dot(o, direction_) / squared) * direction_;
    const float radius2 = square(sphere->radius);
    const WideMask rounded = square(dot(remainder, direction_)) > most_along * squared * radius2;
    return live_ & (rounded | !(radius2 - dot(remainder, remainder) < 0));
  }

  template <class Answer>
  void finish(const Answer& answer) {
    for (const std::uint32_t id : small_.others)
      if (const WideMask lanes = may_meet(id); any(lanes)) test_scalar(lanes, id);
    const unsigned found = found_.lanes();
    for (int lane = 0; lane < static_cast<int>(std::min<std::size_t>(widest_lanes, rays_.size())); ++lane) {
      Hit hit;
      if constexpr (any_hit)
        hit.primitive = found >> lane & 1 ? 0 : no_id;
      else
        hit = hit_of(lane);
      answer(static_cast<std::size_t>(lane), hit);
    }
  }

  const SmallGeometry& small_;
  const Geometry& geometry_;
  const std::span<const Ray> rays_;
  WideVec3 origin_, direction_;
  WideFloats t_min_;
  WideBits kx_, ky_, kz_;
  TriangleTest<WideFloats> test_;
  WideMask live_, found_{false};  // rays that may hit something yet; and that have
  WideFloats best_, limit_;       // strict bounds of t; and a little more
  WideFloats best_u_{0.0f}, best_v_{0.0f};
  WideBits best_id_{no_id};
  WideVec3 moved_[SmallGeometry::most_vertices];  // z scaled
};

}  // namespace
}  // namespace etendue
