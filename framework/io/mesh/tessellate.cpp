#include "framework/io/mesh/tessellate.h"

#include "framework/core/elementary.h"
#include "framework/core/fuzzing.h"
#include "framework/core/sampling.h"

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

struct OnCurve {
  vec3 position, tangent;
};

// Uses de Casteljau's algorithm.
OnCurve evaluate(const std::vector<vec3>& control, float t) {
  std::vector<vec3> p = control;
  while (p.size() > 2) {
    for (std::size_t i = 0; i + 1 < p.size(); ++i) p[i] = glm::mix(p[i], p[i + 1], t);
    p.pop_back();
  }
  return {glm::mix(p[0], p[1], t), p[1] - p[0]};
}

vec3 unit_or(const vec3& v, const vec3& otherwise) {
  const float length = glm::length(v);
  return length > 0 && std::isfinite(length) ? v / length : otherwise;
}

float length_of(const std::vector<vec3>& control) {
  float length = 0;
  for (std::size_t i = 0; i + 1 < control.size(); ++i) length += glm::length(control[i + 1] - control[i]);
  return length;
}

// Hair comes in hundreds of thousands of curves: few cells where a curve is much longer than it is wide.
bool is_thin(const CurveSegment& curve) {
  return std::max(curve.width_at_start, curve.width_at_end) * 200 < length_of(curve.points);
}

}  // namespace

int arc_segments(float radians) {
  constexpr int turn = unless_fuzzed(200, 8);
  return std::clamp(static_cast<int>(std::ceil(turn * radians / (2 * pi))), 3, turn);
}

vec2 from_pole(float theta) {
  const float sine = math::sin(theta);
  return {std::abs(sine) < 1e-6f ? 0 : sine, math::cos(theta)};
}

SurfacePatch revolved(float radians, int rows, std::function<vec2(float)> profile, std::function<vec2(float)> slope) {
  const auto at = [=](float u, float v) {
    const float c = math::cos(u * radians), s = math::sin(u * radians);
    const vec2 p = profile(v), d = slope(v);
    // The cross product of the derivatives along u and v, of which the first has the direction (-s, c, 0).
    return PatchPoint{{p.x * c, p.x * s, p.y}, {d.y * c, d.y * s, -d.x}};
  };
  return {at, arc_segments(radians), rows};
}

TriangleMesh tessellate(const SurfacePatch& patch) {
  TriangleMesh mesh;
  const auto columns = static_cast<std::uint32_t>(patch.columns), rows = static_cast<std::uint32_t>(patch.rows);
  for (std::uint32_t j = 0; j <= rows; ++j)
    for (std::uint32_t i = 0; i <= columns; ++i) {
      const vec2 uv(static_cast<float>(i) / static_cast<float>(columns), static_cast<float>(j) / static_cast<float>(rows));
      const PatchPoint p = patch.at(uv.x, uv.y);
      mesh.positions.push_back(p.position);
      mesh.normals.push_back(p.normal);
      mesh.uvs.push_back(uv);
    }
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const auto& p = mesh.positions;
    if (p[a] != p[b] && p[b] != p[c] && p[c] != p[a]) mesh.triangles.emplace_back(a, b, c);
  };
  for (std::uint32_t j = 0; j < rows; ++j)
    for (std::uint32_t i = 0; i < columns; ++i) {
      const std::uint32_t a = j * (columns + 1) + i, b = a + columns + 1;
      add(a, a + 1, b + 1);
      add(a, b + 1, b);
    }
  return mesh;
}

SurfacePatch tube_along(const CurveSegment& curve) {
  const vec3 chord = unit_or(curve.points.back() - curve.points.front(), {0, 0, 1});
  const vec3 reference = Frame::from_normal(chord).tangent;
  const auto at = [=](float u, float v) {
    const OnCurve on = evaluate(curve.points, u);
    const vec3 along = unit_or(on.tangent, chord);
    const vec3 x = unit_or(reference - glm::dot(reference, along) * along, Frame::from_normal(along).tangent);
    const vec3 y = glm::cross(along, x);
    const float angle = -2 * pi * v, radius = 0.5f * glm::mix(curve.width_at_start, curve.width_at_end, u);
    const vec3 normal = math::cos(angle) * x + math::sin(angle) * y;
    return PatchPoint{on.position + radius * normal, normal};
  };
  return is_thin(curve) ? SurfacePatch{at, 12, 4} : SurfacePatch{at, unless_fuzzed(48, 6), unless_fuzzed(32, 4)};
}

SurfacePatch strip_along(const CurveSegment& curve, const vec3& normal_at_start, const vec3& normal_at_end) {
  const vec3 n0 = unit_or(normal_at_start, {0, 0, 1}), n1 = unit_or(normal_at_end, n0);
  const float angle = math::acos(std::clamp(glm::dot(n0, n1), -1.0f, 1.0f));
  const vec3 chord = unit_or(curve.points.back() - curve.points.front(), {0, 0, 1});
  const auto at = [=](float u, float v) {
    const OnCurve on = evaluate(curve.points, u);
    const vec3 along = unit_or(on.tangent, chord);
    const float sine = math::sin(angle);
    const vec3 normal = sine > 1e-4f ? (math::sin((1 - u) * angle) * n0 + math::sin(u * angle) * n1) / sine : n0;
    const vec3 across = unit_or(glm::cross(normal, along), Frame::from_normal(along).tangent);
    const float width = glm::mix(curve.width_at_start, curve.width_at_end, u);
    return PatchPoint{on.position + (v - 0.5f) * width * across, glm::cross(along, across)};
  };
  return is_thin(curve) ? SurfacePatch{at, 12, 1} : SurfacePatch{at, 48, 1};
}

}  // namespace etendue
