#include "framework/io/place_quadric.h"

#include "framework/core/error.h"
#include "framework/io/object_builder.h"

#include <fmt/format.h>

namespace etendue {

namespace {

// Transforms a quadric by a similarity of the given scale.
struct TransformQuadric {
  const Transform& t;
  float scale;

  Quadric operator()(const Sphere& s) const { return Sphere{t.point(s.centre), scale * s.radius}; }
  Quadric operator()(const Cylinder& c) const {
    return Cylinder{t.point(c.base), scale * c.radius, glm::normalize(t.vector(c.axis)), scale * c.length, c.caps};
  }
  Quadric operator()(const Disk& d) const {
    return Disk{t.point(d.centre), scale * d.radius, glm::normalize(t.normal(d.normal)), scale * d.inner_radius};
  }
};

// Does a quadric keep its texture coordinates, which count from the axes of the space it is in?
bool keeps_axes(const Transform& t, float scale) {
  const auto near = [&](const vec3& v, const vec3& axis) { return glm::length(v / scale - axis) < 1e-4f; };
  return near(t.vector({1, 0, 0}), {1, 0, 0}) && near(t.vector({0, 0, 1}), {0, 0, 1}) && !t.swaps_handedness();
}

}  // namespace

std::optional<Quadric> placed_quadric(const Quadric& quadric, const Transform& transform, bool keep_uvs) {
  const auto scale = transform.similarity_scale();
  if (!scale || (keep_uvs && !keeps_axes(transform, *scale))) return std::nullopt;
  const Quadric placed = std::visit(TransformQuadric{transform, *scale}, quadric);
  const Bounds bounds = quadric_bounds(placed);
  if (!within_reach(bounds.lower) || !within_reach(bounds.upper) || !(quadric_area(placed) > 0) ||
      !std::isfinite(quadric_area(placed)))
    throw Error(fmt::format("placed, it lies beyond {:g} m, or is too small for single precision", farthest));
  return placed;
}

}  // namespace etendue
