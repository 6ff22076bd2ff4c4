// The contents of the leaves of a bottom-level structure, and a ray's test against them.
//
// A leaf is a run of packs. A pack holds up to four primitives: triangles with copies of their vertices, tested together, so
// that no index is followed; and quadrics, by their ids behind those of the triangles, tested one by one in the geometry.
#pragma once

#include "accel/kernels/pack_query.h"
#include "accel/kernels/queries.h"

#include <span>

namespace etendue {

class Leaves {
 public:
  struct Pack : TrianglePack<4> {
    std::uint32_t needle_bits = 0;

    unsigned needles() const { return needle_bits; }
  };
  struct Run {
    std::uint32_t first = 0, count = 0;  // packs
  };

  // `geometry` must outlive this.
  explicit Leaves(const Geometry& geometry) : geometry_(&geometry), mixed_(!geometry.quadrics.empty()) {}

  // Adds the primitives of one leaf and returns where they lie.
  Run add(std::span<const std::uint32_t> ids);
  // For trees that change: makes packs without primitives, and fills one of them (with at most Pack::lanes ids).
  void resize(std::size_t packs) { packs_.resize(packs); }
  void set(std::uint32_t pack, std::span<const std::uint32_t> ids);

  const Geometry& geometry() const { return *geometry_; }
  bool mixed() const { return mixed_; }  // with quadrics
  std::span<const Pack> packs(Run run) const { return std::span(packs_).subspan(run.first, run.count); }
  std::uint64_t references() const;
  std::uint64_t bytes() const { return packs_.size() * sizeof(Pack); }

 private:
  // `ids` ascend.
  void fill(Pack& pack, std::span<const std::uint32_t> ids) const;

  const Geometry* geometry_ = nullptr;
  bool mixed_ = false;
  std::vector<Pack> packs_;
};

inline std::uint32_t primitives_of(const Leaves::Pack& pack) {
  std::uint32_t count = 0;
  for (const std::uint32_t id : pack.ids) count += id != no_id;
  return count;
}

// A ray against such leaves, lowering a hit.
template <bool any_hit>
class LeafTest {
  using Query = PackQuery<Floats<4, native_width>, Leaves::Pack, any_hit>;

 public:
  LeafTest(const Leaves& leaves, const Ray& ray) : leaves_(leaves), ray_(ray), query_(ray.origin, TriangleRay(ray.direction)) {}

  template <class Count>
  bool operator()(Leaves::Run run, Hit& hit, Count& count) const {
    bool found = false;
    for (const Leaves::Pack& pack : leaves_.packs(run)) {
      if constexpr (Count::of_primitives) count.primitives(primitives_of(pack));
      const auto outcome = query_.test_common(pack, ray_.t_min, hit);
      found |= outcome == Query::Outcome::found;
      if (outcome == Query::Outcome::rare) [[unlikely]]
        found |= query_.test_rare(leaves_.geometry(), pack, ray_, hit);
      if (leaves_.mixed()) found |= test_quadrics(pack, hit);
      if (any_hit && found) return true;
    }
    return found;
  }

 private:
  bool test_quadrics(const Leaves::Pack& pack, Hit& hit) const {
    bool found = false;
    for (const std::uint32_t id : pack.ids)
      if (id != no_id && !leaves_.geometry().is_triangle(id))
        found |= intersect_primitive(leaves_.geometry(), id, ray_, query_.shear(), hit);
    return found;
  }

  const Leaves& leaves_;
  const Ray& ray_;
  const Query query_;
};

}  // namespace etendue
