// Leaves by reference: where space is cut and a primitive is listed in many cells, copies of its vertices would cost too much,
// so cells hold ids and the geometry is read when a ray comes.
//
// Up to four triangles that the ray has not met before are gathered into a pack and tested together, with the same bits as
// everywhere. Mailboxes ([Amanatides1987]) remember what the ray has met. They lie in a small table on the ray's stack instead
// of with the primitives, so threads share nothing; a primitive whose entry was overwritten is tested again, which changes no
// result.
#pragma once

#include "accel/kernels/pack_query.h"
#include "accel/kernels/queries.h"

#include <span>

namespace etendue {

template <bool any_hit>
class ReferenceTest {
  using Pack = TrianglePack<4>;

 public:
  // `geometry` and `ray` must outlive this.
  ReferenceTest(const Geometry& geometry, const Ray& ray)
      : geometry_(geometry), ray_(ray), query_(ray.origin, TriangleRay(ray.direction)) {
    mailboxes_.fill(no_id);
  }

  // Tests the primitives of one cell, whose ids ascend, lowering `hit`.
  template <class Count>
  bool operator()(std::span<const std::uint32_t> ids, Hit& hit, Count& count) {
    bool found = false;
    for (const std::uint32_t id : ids) {
      if (std::exchange(mailboxes_[id % mailboxes_.size()], id) == id) continue;
      count.primitives(1);
      if (!geometry_.is_triangle(id)) {
        found |= intersect_primitive(geometry_, id, ray_, query_.shear(), hit);
      } else {
        gather(id);
        if (gathered_ == Pack::lanes) found |= test_gathered(hit);
      }
      if (any_hit && found) return true;
    }
    if (gathered_ > 0) found |= test_gathered(hit);
    return found;
  }

 private:
  void gather(std::uint32_t id) {
    const uvec3 v = geometry_.triangles[id];
    const auto& p = geometry_.positions;
    pack_.place(gathered_, p[v.x], p[v.y], p[v.z]);
    pack_.ids[gathered_++] = id;
  }

  // The lanes behind those gathered hold triangles of before.
  bool test_gathered(Hit& hit) {
    const auto needles = [&](unsigned lanes) {
      unsigned found = 0;
      for (; lanes != 0; lanes &= lanes - 1) {
        const int lane = std::countr_zero(lanes);
        if (is_needle(pack_.vertex(lane, 0), pack_.vertex(lane, 1), pack_.vertex(lane, 2))) found |= 1u << lane;
      }
      return found;
    };
    return query_.test_all(geometry_, pack_, (1u << std::exchange(gathered_, 0)) - 1, ray_, hit, needles);
  }

  const Geometry& geometry_;
  const Ray& ray_;
  const PackQuery<Floats<4, native_width>, Pack, any_hit> query_;
  Pack pack_;
  std::uint32_t gathered_ = 0;
  std::array<std::uint32_t, 64> mailboxes_;
};

}  // namespace etendue
