#include "framework/io/pbrt/quadrics.h"

#include "framework/core/elementary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

// More than a turn is one, as in pbrt.
float read_phi(const PbrtParams& params) { return std::min(params.number("phimax", 360, 1e-3f), 360.0f) * (pi / 180); }

bool is_whole(float phi) { return phi > 2 * pi * (1 - 1e-6f); }

float read_radius(const PbrtParams& params) { return params.number("radius", 1, 1e-30f); }

// v runs from -z to +z.
PbrtQuadric read_sphere(const PbrtParams& params) {
  const float radius = read_radius(params), phi = read_phi(params);
  float a = params.number("zmin", -radius), b = params.number("zmax", radius);
  if (a > b) std::swap(a, b);
  const float theta_low = math::acos(std::clamp(a / radius, -1.0f, 1.0f)),
              theta_high = math::acos(std::clamp(b / radius, -1.0f, 1.0f));
  if (!(theta_high < theta_low)) params.fail("zmax", "leaves nothing of the sphere");
  const float slope = theta_high - theta_low;
  const auto theta = [=](float v) { return theta_low + v * slope; };
  PbrtQuadric sphere;
  sphere.patch = revolved(
      phi, arc_segments(-slope), [=](float v) { return radius * from_pole(theta(v)); },
      [=](float v) { return vec2(math::cos(theta(v)), -math::sin(theta(v))) * slope; });
  if (is_whole(phi) && theta_low >= pi * (1 - 1e-6f) && theta_high <= 1e-6f) sphere.whole = Sphere{vec3(0), radius};
  return sphere;
}

PbrtQuadric read_cylinder(const PbrtParams& params) {
  const float radius = read_radius(params), phi = read_phi(params);
  float a = params.number("zmin", -1), b = params.number("zmax", 1);
  if (a == b) params.fail("zmax", "equals zmin: the cylinder has no height");
  if (a > b) std::swap(a, b);
  PbrtQuadric cylinder;
  cylinder.patch = revolved(
      phi, 1, [=](float v) { return vec2(radius, glm::mix(a, b, v)); }, [](float) { return vec2(0, 1); });
  if (is_whole(phi)) cylinder.whole = Cylinder{{0, 0, a}, radius, {0, 0, 1}, b - a, false};
  return cylinder;
}

// v runs from the rim inwards.
PbrtQuadric read_disk(const PbrtParams& params) {
  const float radius = read_radius(params), phi = read_phi(params), inner = params.number("innerradius", 0, 0);
  const float height = params.number("height", 0);
  if (!(inner < radius)) params.fail("innerradius", fmt::format("is {}; expected less than the radius, {}", inner, radius));
  PbrtQuadric disk;
  disk.patch = revolved(
      phi, 1, [=](float v) { return vec2(glm::mix(radius, inner, v), height); }, [](float) { return vec2(-1, 0); });
  if (is_whole(phi)) disk.whole = Disk{{0, 0, height}, radius, {0, 0, 1}, inner};
  return disk;
}

// v runs from the base to the tip, which the surface stops short of by a millionth: there it has no normal.
SurfacePatch read_cone(const PbrtParams& params) {
  const float radius = read_radius(params), phi = read_phi(params), height = params.number("height", 1);
  if (height == 0) params.fail("height", "is 0: the cone has no side");
  return revolved(
      phi, 8, [=](float v) { return vec2(radius * std::max(1 - v, 1e-6f), height * v); },
      [=](float) { return vec2(-radius, height); });
}

SurfacePatch read_paraboloid(const PbrtParams& params) {
  const float radius = read_radius(params), phi = read_phi(params);
  float a = params.number("zmin", 0), b = params.number("zmax", 1);
  if (a > b) std::swap(a, b);
  if (!(b > 0) || a == b) params.fail("zmax", "leaves nothing of the paraboloid");
  a = std::max(a, 1e-6f * b);
  // The radius is r at zmax: z = zmax (distance / r)^2. Rows are even in distance, along which the surface bends.
  const float from = std::sqrt(a / b);
  const auto share = [=](float v) { return std::sqrt(glm::mix(a, b, v) / b); };
  SurfacePatch by_v = revolved(
      phi, 64, [=](float v) { return vec2(radius * share(v), glm::mix(a, b, v)); },
      [=](float v) { return vec2(radius / (2 * std::max(share(v), from)), b); });
  return by_v;
}

// The surface that a segment sweeps as it turns about z.
SurfacePatch read_hyperboloid(const PbrtParams& params) {
  vec3 p1 = params.point("p1", {0, 0, 0}), p2 = params.point("p2", {1, 1, 1});
  const float phi = read_phi(params);
  if (p1 == p2) params.fail("p2", "equals p1: there is no segment to turn");
  if (p2.z == 0) std::swap(p1, p2);  // as pbrt-v3 does, which changes the side and v
  const auto at = [=](float u, float v) {
    const float c = math::cos(u * phi), s = math::sin(u * phi);
    const auto turned = [&](const vec3& p) { return vec3(p.x * c - p.y * s, p.x * s + p.y * c, p.z); };
    const vec3 p = turned(glm::mix(p1, p2, v));
    return PatchPoint{p, glm::cross(vec3(-p.y, p.x, 0), turned(p2 - p1))};
  };
  return {at, arc_segments(phi), 64};
}

}  // namespace

std::optional<PbrtQuadric> read_quadric(const std::string& type, const PbrtParams& params) {
  if (type == "sphere") return read_sphere(params);
  if (type == "cylinder") return read_cylinder(params);
  if (type == "disk") return read_disk(params);
  if (type == "cone") return PbrtQuadric{std::nullopt, read_cone(params)};
  if (type == "paraboloid") return PbrtQuadric{std::nullopt, read_paraboloid(params)};
  if (type == "hyperboloid") return PbrtQuadric{std::nullopt, read_hyperboloid(params)};
  return std::nullopt;
}

}  // namespace etendue
