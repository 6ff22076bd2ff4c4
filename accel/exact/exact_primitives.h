// One primitive against one ray in double precision, for exact.h.
//
// Triangles are tested by the signs of three volumes, one per edge: an edge shared by two triangles gets exactly opposite
// values in them, so no ray slips through between. Vertices may be moved by as much as single precision rounds them.
#pragma once

#include "framework/core/rng.h"
#include "framework/scene/scene.h"

#include <array>
#include <bit>
#include <cmath>
#include <glm/gtc/matrix_access.hpp>
#include <optional>

namespace etendue {

// The places where single precision may put the vertices of a mesh. It rounds each by itself, so a vertex lies at one place for
// all the triangles that have it. Lengths are spread over powers of two: a crack beside a vertex opens where that moves less
// than what lies farther along.
struct VertexRounding {
  double distance = 0;  // along each axis, at most
  std::uint64_t key = 0;

  dvec3 at(const vec3& p) const {
    const auto bits = std::bit_cast<std::array<std::uint32_t, 3>>(p + 0.0f);
    std::uint64_t h = hash_keys(key, bits[0], bits[1], bits[2]);
    const double most = std::ldexp(distance, -static_cast<int>(h >> 60));
    dvec3 move;
    for (int axis = 0; axis < 3; ++axis, h = mix_bits(h))
      move[axis] = most * (2.0 * to_unit_float(static_cast<std::uint32_t>(h)) - 1);
    return move;
  }
};

struct ExactRay {
  dvec3 origin, direction;
  double t_min, t_max;
  VertexRounding rounding;
  dvec3 box_slack{0};  // by which the vertices may lie outside their boxes

  explicit ExactRay(const Ray& ray) : origin(ray.origin), direction(ray.direction), t_min(ray.t_min), t_max(ray.t_max) {}
  dvec3 at(double t) const { return origin + t * direction; }
  bool in_range(double t) const { return t > t_min && t <= t_max; }
};

// The place where a ray crosses a surface.
struct ExactCrossing {
  double t;
  dvec3 normal;  // not normalised
};

// A ray in an instance's space, with the transforms there and back.
struct ExactLocalRay {
  ExactRay ray;
  glm::dmat3 to_local{1}, to_world{1};
  dvec3 offset{0};

  ExactLocalRay(const Transform& transform, const ExactRay& r) : ray(r) {
    if (transform.is_identity()) return;
    to_world =
        glm::dmat3(dvec3(transform.vector({1, 0, 0})), dvec3(transform.vector({0, 1, 0})), dvec3(transform.vector({0, 0, 1})));
    offset = transform.point(vec3(0));
    to_local = glm::inverse(to_world);
    ray.origin = to_local * (ray.origin - offset);
    ray.direction = to_local * ray.direction;
    for (int axis = 0; axis < 3; ++axis) {
      const dvec3 row = glm::abs(glm::row(to_local, axis));
      ray.box_slack[axis] = ray.rounding.distance * (row.x + row.y + row.z);
    }
  }
  dvec3 vertex(const vec3& p) const { return ray.rounding.distance > 0 ? dvec3(p) + to_local * ray.rounding.at(p) : dvec3(p); }
  dvec3 world(const vec3& p) const { return to_world * dvec3(p) + offset; }
  double cos_surface(const ExactCrossing& crossing, const ExactRay& world_ray) const {
    return std::abs(glm::dot(glm::normalize(world_ray.direction), glm::normalize(crossing.normal * to_local)));
  }
};

// `rim`: how far outside a surface, as a share of its size, still counts as inside.
std::optional<ExactCrossing> cross(const Geometry& geometry, std::uint32_t primitive, const ExactLocalRay& local, double rim);
std::optional<ExactCrossing> cross(const InfinitePlane& plane, const ExactRay& ray);

// The distance in metres from a point to the nearest point of a segment or triangle.
double distance_to_segment(const dvec3& p, const dvec3& a, const dvec3& b);
double distance_to_triangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c);

}  // namespace etendue
