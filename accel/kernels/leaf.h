// What the leaves of a bottom-level structure hold, and how a ray is tested against them.
//
// A leaf is a run of blocks. A block holds up to four primitives: triangles with copies of their vertices, tested together
// (triangle_block.h), so that no index is followed; quadrics, by their ids, tested one by one in the geometry. `mixed` is false
// for a geometry without quadrics: their test is then not compiled in.
#pragma once

#include "accel/kernels/triangle_block.h"

#include <span>

namespace etendue {

class LeafBlocks {
 public:
  struct Run {
    std::uint32_t first = 0, count = 0;  // blocks
  };

  // `geometry` must outlive this.
  explicit LeafBlocks(const Geometry& geometry) : geometry_(&geometry) {}

  // Adds the primitives of one leaf and returns where they lie.
  Run add(std::span<const std::uint32_t> ids);
  // For trees that change: makes blocks without primitives, and fills one of them (with at most TriangleBlock::width ids).
  void resize(std::size_t blocks) { blocks_.resize(blocks); }
  void set(std::uint32_t block, std::span<const std::uint32_t> ids);

  bool mixed() const { return !geometry_->quadrics.empty(); }
  std::uint64_t references() const;
  std::uint64_t bytes() const { return blocks_.size() * sizeof(Block); }

  // Tests a run, lowering `hit`.
  template <bool mixed, class Count>
  void closest(const BlockRay& ray, Run run, Hit& hit, Count& count) const {
    for (const Block& block : std::span(blocks_).subspan(run.first, run.count)) {
      count.primitives(block.size);
      TriangleBlock::Hits hits;
      block.triangles.intersect(ray, hit.t, block, hits);
      for (auto mask = static_cast<unsigned>(hits.mask); mask != 0; mask &= mask - 1) {
        const int lane = std::countr_zero(mask);
        if (closer(hits.t[lane], block.ids[lane], hit))
          record(hit, hits.t[lane], {hits.u[lane], hits.v[lane]}, block.ids[lane]);
      }
      if constexpr (mixed) {
        for (std::uint32_t lane = block.triangle_count; lane < block.size; ++lane) {
          float t;
          vec2 uv;
          const std::uint32_t id = block.ids[lane];
          if (intersect_quadric(ray.ray, geometry_->quadric(id), hit.t, t, uv) && closer(t, id, hit)) record(hit, t, uv, id);
        }
      }
    }
  }

  template <bool mixed, class Count>
  bool occluded(const BlockRay& ray, Run run, Count& count) const {
    const float t_max = ray.ray.t_max;
    for (const Block& block : std::span(blocks_).subspan(run.first, run.count)) {
      count.primitives(block.size);
      TriangleBlock::Hits hits;
      block.triangles.intersect(ray, t_max, block, hits);
      if (hits.mask != 0) return true;
      if constexpr (mixed) {
        float t;
        vec2 uv;
        for (std::uint32_t lane = block.triangle_count; lane < block.size; ++lane)
          if (intersect_quadric(ray.ray, geometry_->quadric(block.ids[lane]), t_max, t, uv)) return true;
      }
    }
    return false;
  }

 private:
  struct Block {
    TriangleBlock triangles;
    std::array<std::uint32_t, TriangleBlock::width> ids;  // triangles first
    std::uint8_t triangle_count = 0, size = 0;
    std::uint8_t needles = 0;  // a bit per lane

    Block() { ids.fill(no_id); }
    bool operator()(int mask) const { return (needles & mask) != 0; }
  };

  static void record(Hit& hit, float t, const vec2& uv, std::uint32_t id) {
    hit.t = t;
    hit.uv = uv;
    hit.primitive = id;
  }

  // `ids` triangles first.
  void fill(Block& block, std::span<const std::uint32_t> ids) const;

  const Geometry* geometry_ = nullptr;
  std::vector<Block> blocks_;
};

}  // namespace etendue
