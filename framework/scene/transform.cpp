#include "framework/scene/transform.h"

#include "framework/core/check.h"
#include "framework/core/elementary.h"
#include "framework/scene/clearance.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

namespace etendue {

namespace {

// Is the linear part orthonormal, so that its inverse is its transpose?
bool is_orthonormal(const mat3& m) {
  constexpr float tolerance = 1e-6f;
  const mat3 product = glm::transpose(m) * m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (std::abs(product[i][j] - (i == j ? 1.0f : 0.0f)) > tolerance) return false;
  return true;
}

mat3 absolute(const mat3& m) { return {glm::abs(m[0]), glm::abs(m[1]), glm::abs(m[2])}; }

mat3 inverse_in_double(const mat3& m) { return mat3(glm::inverse(glm::dmat3(m))); }

}  // namespace

std::optional<Transform> Transform::from_matrix(const mat4& m) {
  const mat3 linear(m);
  const vec3 offset(m[3]);
  if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1) return std::nullopt;
  const mat3 inverse_linear = is_orthonormal(linear) ? glm::transpose(linear) : inverse_in_double(linear);
  const vec3 inverse_offset = -(inverse_linear * offset);
  for (int i = 0; i < 3; ++i)
    if (!is_finite(linear[i]) || !is_finite(inverse_linear[i])) return std::nullopt;
  if (!is_finite(offset) || !is_finite(inverse_offset)) return std::nullopt;
  return Transform(linear, offset, inverse_linear, inverse_offset);
}

Transform Transform::translate(const vec3& offset) { return {mat3(1), offset, mat3(1), -offset}; }

Transform Transform::scale(const vec3& factors) {
  CHECK(factors.x != 0 && factors.y != 0 && factors.z != 0);
  mat3 linear(0), inverse(0);
  for (int i = 0; i < 3; ++i) {
    linear[i][i] = factors[i];
    inverse[i][i] = 1 / factors[i];
  }
  return {linear, vec3(0), inverse, vec3(0)};
}

Transform Transform::rotate(float radians, const vec3& axis) {
  const double half = 0.5 * static_cast<double>(radians);
  const mat3 linear(glm::mat3_cast(glm::dquat(math::cos(half), math::sin(half) * glm::normalize(dvec3(axis)))));
  return {linear, vec3(0), glm::transpose(linear), vec3(0)};
}

std::optional<Transform> Transform::look_at(const vec3& eye, const vec3& target, const vec3& up) {
  const dvec3 forward = dvec3(target) - dvec3(eye);
  if (glm::length(forward) == 0) return std::nullopt;
  const dvec3 direction = glm::normalize(forward);
  const dvec3 right = glm::cross(dvec3(up), direction);
  if (!(glm::length(right) > 1e-12)) return std::nullopt;
  const dvec3 x = glm::normalize(right), y = glm::cross(direction, x);
  const mat3 linear{vec3(x), vec3(y), vec3(direction)};
  const mat3 transposed = glm::transpose(linear);
  return Transform(linear, eye, transposed, -(transposed * eye));
}

Bounds Transform::bounds(const Bounds& b) const {
  Bounds result;
  if (b.empty()) return result;
  for (int corner = 0; corner < 8; ++corner)
    result.extend(
        point({corner & 1 ? b.upper.x : b.lower.x, corner & 2 ? b.upper.y : b.lower.y, corner & 4 ? b.upper.z : b.lower.z}));
  return result;
}

// Each coordinate is a sum of up to four products: it is off by at most four roundings of the sum of their sizes.
vec3 Transform::error(const vec3& world, const vec3& local, float local_error) const {
  constexpr float gamma = 4 * unit_roundoff;
  const vec3 there = gamma * (absolute(linear_) * glm::abs(local) + glm::abs(offset_));
  const vec3 back = gamma * (absolute(inverse_linear_) * glm::abs(world - offset_));
  return there + absolute(linear_) * (back + local_error);
}

Transform Transform::moved(const vec3& by) const {
  return {linear_, offset_ + by, inverse_linear_, -(inverse_linear_ * (offset_ + by))};
}

Transform Transform::inverse() const { return {inverse_linear_, inverse_offset_, linear_, offset_}; }

Transform Transform::operator*(const Transform& inner) const {
  return {linear_ * inner.linear_, linear_ * inner.offset_ + offset_, inner.inverse_linear_ * inverse_linear_,
          inner.inverse_linear_ * inverse_offset_ + inner.inverse_offset_};
}

std::optional<float> Transform::similarity_scale() const {
  const float scale = glm::length(linear_[0]);
  const mat3 normalised = linear_ / scale, product = glm::transpose(normalised) * normalised;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!(std::abs(product[i][j] - (i == j ? 1.0f : 0.0f)) < 1e-4f)) return std::nullopt;
  return scale;
}

}  // namespace etendue
