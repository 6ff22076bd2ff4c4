// Affine transforms of points, vectors and normals.
#pragma once

#include "framework/core/vec.h"

#include <optional>

namespace etendue {

// A 3x3 linear part and a translation, with the inverse beside it. Rigid transforms are inverted by transposing.
class Transform {
 public:
  Transform() = default;
  // Throws nothing; a singular matrix gives no value.
  static std::optional<Transform> from_matrix(const mat4& m);
  static Transform translate(const vec3& offset);
  static Transform scale(const vec3& factors);  // no factor may be zero (CHECK)
  static Transform rotate(float radians, const vec3& axis);
  // Camera to world: looks along +z, y up, x to the right in a left-handed frame, as pbrt does.
  static std::optional<Transform> look_at(const vec3& eye, const vec3& target, const vec3& up);

  vec3 point(const vec3& p) const { return linear_ * p + offset_; }
  vec3 vector(const vec3& v) const { return linear_ * v; }
  // The same in lanes (lanes.h).
  template <class V>
  V point(const V& p) const {
    return vector(p) + V(offset_);
  }
  template <class V>
  V vector(const V& v) const {
    const mat3& m = linear_;
    return {m[0].x * v.x + m[1].x * v.y + m[2].x * v.z, m[0].y * v.x + m[1].y * v.y + m[2].y * v.z,
            m[0].z * v.x + m[1].z * v.y + m[2].z * v.z};
  }
  vec3 normal(const vec3& n) const { return n * inverse_linear_; }  // by the inverse transpose; not normalised
  // Inverses of point and vector. They are as exact far from the origin as near it: the offset goes before anything is rounded.
  vec3 inverse_point(const vec3& p) const { return inverse_linear_ * (p - offset_); }
  vec3 inverse_vector(const vec3& v) const { return inverse_linear_ * v; }
  Bounds bounds(const Bounds& b) const;
  // Bound on how far, along each axis, point(local) = `world` may lie from what rays meet that were moved by inverse_point:
  // both directions round, and their matrices are not quite each other's inverse. `local_error`: of the local point, likewise.
  vec3 error(const vec3& world, const vec3& local, float local_error) const;

  Transform moved(const vec3& by) const;  // by an offset, afterwards; `by` is added and nothing else rounded
  Transform inverse() const;
  Transform operator*(const Transform& inner) const;  // inner first
  bool operator==(const Transform&) const = default;

  bool is_identity() const { return *this == Transform(); }
  float volume_scale() const { return std::abs(glm::determinant(linear_)); }
  bool swaps_handedness() const { return glm::determinant(linear_) < 0; }
  // The uniform scale factor if this is a similarity (rotation or reflection, scale, translation), within 1e-4.
  std::optional<float> similarity_scale() const;

 private:
  Transform(const mat3& linear, const vec3& offset, const mat3& inverse_linear, const vec3& inverse_offset)
      : linear_(linear), inverse_linear_(inverse_linear), offset_(offset), inverse_offset_(inverse_offset) {}

  mat3 linear_{1}, inverse_linear_{1};
  vec3 offset_{0}, inverse_offset_{0};
};

}  // namespace etendue
