// Tells builders which runs of primitives fit into a pack, so that they do not divide runs which the collapse would join again.
#pragma once

#include "accel/bvh/build/vertex_ids.h"

#include <array>
#include <cstdint>
#include <span>

namespace etendue {

class PackTest {
 public:
  template <class Pack>
  static PackTest of(const VertexIds& vertices) {
    return {vertices, Pack::lanes, Pack::fits};
  }

  std::uint32_t lanes() const { return lanes_; }
  // `id(i)` for i < count: the run.
  template <class Id>
  bool takes(std::uint32_t count, const Id& id) const {
    if (count > lanes_) return false;
    std::array<uvec3, max_lanes> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!vertices_->geometry().is_triangle(id(i))) return false;
      triangles[i] = (*vertices_)(id(i));
    }
    return fits_(std::span(triangles).first(count));
  }

 private:
  using Fits = bool (*)(std::span<const uvec3>);
  static constexpr std::uint32_t max_lanes = 16;

  PackTest(const VertexIds& vertices, std::uint32_t lanes, Fits fits) : vertices_(&vertices), lanes_(lanes), fits_(fits) {}

  const VertexIds* vertices_;
  std::uint32_t lanes_;
  Fits fits_;
};

}  // namespace etendue
