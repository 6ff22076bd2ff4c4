// The vertices of a geometry by position: readers of meshes often repeat one where its normal or texture coordinates change.
#pragma once

#include "framework/scene/geometry.h"

#include <cstdint>
#include <vector>

namespace etendue {

class VertexIds {
 public:
  explicit VertexIds(const Geometry& geometry);

  // A triangle's corners as indices into Geometry::positions, equal at the same position.
  uvec3 operator()(std::uint32_t triangle) const {
    const uvec3& v = geometry_->triangles[triangle];
    return first_equal_.empty() ? v : uvec3(first_equal_[v.x], first_equal_[v.y], first_equal_[v.z]);
  }
  const Geometry& geometry() const { return *geometry_; }

 private:
  const Geometry* geometry_;
  std::vector<std::uint32_t> first_equal_;  // by vertex; empty where few vertices can be repeated
};

}  // namespace etendue
