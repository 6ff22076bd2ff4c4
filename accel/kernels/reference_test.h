// Leaves by reference: where space is cut and a primitive is listed in many cells, copies of its vertices would cost too much,
// so cells hold ids and the geometry is read when a ray comes.
//
// Up to four triangles that the ray has not met before are gathered into a block and tested together, with the same bits as
// everywhere (triangle_block.h). Mailboxes ([Amanatides1987]) remember what the ray has met. They lie in a small table on the
// ray's stack instead of with the primitives, so threads share nothing; a primitive whose entry was overwritten is tested
// again, which changes no result.
#pragma once

#include "accel/kernels/triangle_block.h"

#include <span>

namespace etendue {

class ReferenceTest {
 public:
  // `geometry` and `ray` must outlive this.
  ReferenceTest(const Geometry& geometry, const Ray& ray) : geometry_(geometry), ray_(ray) { mailboxes_.fill(no_id); }

  // Tests the primitives of one cell, lowering `hit`.
  template <class Count>
  void closest(std::span<const std::uint32_t> ids, Hit& hit, Count& count) {
    for (const std::uint32_t id : ids) {
      if (!first_meeting(id)) continue;
      count.primitives(1);
      if (!geometry_.is_triangle(id)) {
        intersect_primitive(geometry_, id, ray_.ray, ray_.shear, hit);
        continue;
      }
      gather(id);
      if (gathered_ == TriangleBlock::width) test_gathered(hit);
    }
    if (gathered_ > 0) test_gathered(hit);
  }

  template <class Count>
  bool occluded(std::span<const std::uint32_t> ids, Count& count) {
    for (const std::uint32_t id : ids) {
      if (!first_meeting(id)) continue;
      count.primitives(1);
      if (!geometry_.is_triangle(id)) {
        float t;
        vec2 uv;
        if (intersect_quadric(ray_.ray, geometry_.quadric(id), ray_.ray.t_max, t, uv)) return true;
        continue;
      }
      gather(id);
      if (gathered_ == TriangleBlock::width && any_gathered()) return true;
    }
    return gathered_ > 0 && any_gathered();
  }

 private:
  bool first_meeting(std::uint32_t id) {
    std::uint32_t& last = mailboxes_[id % mailboxes_.size()];
    return std::exchange(last, id) != id;
  }

  void gather(std::uint32_t id) {
    const uvec3 v = geometry_.triangles[id];
    const auto& p = geometry_.positions;
    block_.set(gathered_, p[v.x], p[v.y], p[v.z]);
    ids_[gathered_++] = id;
  }

  // Bit i: gathered triangle i is hit. The lanes behind hold triangles of before.
  unsigned intersect_gathered(float t_max, TriangleBlock::Hits& hits) {
    const auto any_needle = [&](int lanes) {
      for (auto rest = static_cast<unsigned>(lanes); rest != 0; rest &= rest - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(rest));
        if (is_needle(block_.vertex(lane, 0), block_.vertex(lane, 1), block_.vertex(lane, 2))) return true;
      }
      return false;
    };
    block_.intersect(ray_, t_max, any_needle, hits);
    return static_cast<unsigned>(hits.mask) & ((1u << std::exchange(gathered_, 0)) - 1);
  }

  void test_gathered(Hit& hit) {
    TriangleBlock::Hits hits;
    for (unsigned mask = intersect_gathered(hit.t, hits); mask != 0; mask &= mask - 1) {
      const int lane = std::countr_zero(mask);
      if (!closer(hits.t[lane], ids_[lane], hit)) continue;
      hit.t = hits.t[lane];
      hit.uv = {hits.u[lane], hits.v[lane]};
      hit.primitive = ids_[lane];
    }
  }

  bool any_gathered() {
    TriangleBlock::Hits hits;
    return intersect_gathered(ray_.ray.t_max, hits) != 0;
  }

  const Geometry& geometry_;
  BlockRay ray_;
  TriangleBlock block_;
  std::uint32_t gathered_ = 0;
  std::array<std::uint32_t, TriangleBlock::width> ids_;
  std::array<std::uint32_t, 64> mailboxes_;
};

// The two queries of a structure whose cells list ids. `traverse(t_best, leaf)` walks the cells, front to back, and gives each
// cell's ids to `leaf`, which returns true to end the walk.
template <class Count, class Traverse>
Hit closest_by_reference(const Geometry& geometry, const Ray& ray, Count& count, const Traverse& traverse) {
  if (!is_traceable(ray)) return {};
  Hit hit;
  hit.t = ray.t_max;
  ReferenceTest test(geometry, ray);
  traverse(hit.t, [&](std::span<const std::uint32_t> ids) {
    test.closest(ids, hit, count);
    return false;
  });
  if (!hit) return {};
  hit.instance = 0;
  return hit;
}

template <class Count, class Traverse>
bool occluded_by_reference(const Geometry& geometry, const Ray& ray, Count& count, const Traverse& traverse) {
  if (!is_traceable(ray)) return false;
  bool found = false;
  ReferenceTest test(geometry, ray);
  traverse(ray.t_max, [&](std::span<const std::uint32_t> ids) { return found = test.occluded(ids, count); });
  return found;
}

}  // namespace etendue
