// The kernels of accel/kernels/ by themselves: the slab test, and rays against quadrics. Triangles are held to double precision
// in tests/oracle/ray_structures_test.cpp.
#include "accel/kernels/box_test.h"
#include "accel/kernels/primitive_test.h"
#include "framework/core/sampler.h"
#include "framework/scene/transform.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

TEST(Quadrics, HitsMatchDoublePrecision) {
  for (int i = 0; i < 2000; ++i) {
    Sampler s(SamplerKind::independent, 1, Stream::test, i, 0);
    const auto number = [&](float low, float high) { return glm::mix(low, high, s.get_1d()); };
    const vec3 centre(number(-1, 1), number(-1, 1), number(-1, 1));
    const Ray ray{.origin = {number(-40, 40), number(-40, 40), number(-40, 40)},
                  .direction = glm::normalize(centre + 0.4f * vec3(number(-1, 1), number(-1, 1), number(-1, 1)))};
    const Sphere sphere{centre, 0.5f};
    const dvec3 o = dvec3(ray.origin) - dvec3(centre), d(ray.direction);
    const double a = glm::dot(d, d), b = glm::dot(o, d), c = glm::dot(o, o) - 0.25, discriminant = b * b - a * c;
    float t;
    vec2 uv;
    const bool hit = intersect_quadric(ray, sphere, infinity, t, uv);
    if (std::abs(discriminant) < 1e-4) continue;  // grazing: either answer is right
    ASSERT_EQ(hit, discriminant > 0 && -b + std::sqrt(discriminant) > 0) << i;
    if (hit) {
      const double near = (-b - std::sqrt(discriminant)) / a;
      EXPECT_NEAR(t, near > 0 ? near : (-b + std::sqrt(discriminant)) / a, 2e-4 * std::abs(t) + 1e-5);
    }
  }
}

TEST(Quadrics, CappedCylinderIsClosed) {
  // From inside, every ray leaves through the tube or a cap; from outside, the caps are hit from above and below.
  const Cylinder cylinder{{0, 0, 0}, 0.5f, {0, 0, 1}, 2, true};
  float t;
  vec2 uv;
  for (int i = 0; i < 1000; ++i) {
    Sampler s(SamplerKind::independent, 1, Stream::test, i, 1);
    const float z = 2 * s.get_1d() - 1, phi = 2 * pi * s.get_1d();
    const vec3 direction(std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z);
    EXPECT_TRUE(intersect_quadric({.origin = {0.1f, 0.2f, 1}, .direction = direction}, cylinder, infinity, t, uv));
  }
  ASSERT_TRUE(intersect_quadric({.origin = {0.2f, 0, 5}, .direction = {0, 0, -1}}, cylinder, infinity, t, uv));
  EXPECT_FLOAT_EQ(t, 3);
  EXPECT_EQ(uv.y, 1);
  Cylinder open = cylinder;
  open.caps = false;
  EXPECT_FALSE(intersect_quadric({.origin = {0.2f, 0, 5}, .direction = {0, 0, -1}}, open, infinity, t, uv));
}

TEST(Quadrics, AnnulusHasAHole) {
  const Disk ring{{0, 0, 0}, 1, {0, 1, 0}, 0.5f};
  float t;
  vec2 uv;
  EXPECT_FALSE(intersect_quadric({.origin = {0.2f, 1, 0}, .direction = {0, -1, 0}}, ring, infinity, t, uv));
  EXPECT_TRUE(intersect_quadric({.origin = {0.7f, 1, 0}, .direction = {0, -1, 0}}, ring, infinity, t, uv));
}

TEST(Quadrics, BoxesHoldDisksAndCylindersTiltedLittle) {
  for (const float tilt : {1e-1f, 1e-2f, 1e-3f, 2e-4f, 1e-5f})
    for (int axis = 0; axis < 3; ++axis) {
      vec3 n(0.6f * tilt, 0.8f * tilt, 0.3f * tilt);
      n[axis] = 1;
      n = glm::normalize(n);
      const Bounds disk = quadric_bounds(Disk{vec3(0), 1, n}), cylinder = quadric_bounds(Cylinder{vec3(0), 1, n, 1e-6f, true});
      const dvec3 normal = glm::normalize(dvec3(n)), any = normal.x * normal.x < 0.5 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
      const dvec3 tangent = glm::normalize(glm::cross(normal, any)), bitangent = glm::cross(normal, tangent);
      for (int i = 0; i < 64; ++i) {
        const dvec3 p = std::cos(0.1 * i) * tangent + std::sin(0.1 * i) * bitangent;
        for (const Bounds& box : {disk, cylinder})
          for (int k = 0; k < 3; ++k) EXPECT_TRUE(box.lower[k] <= p[k] && p[k] <= box.upper[k]) << tilt << " along " << k;
      }
    }
}

// Rays from 5 to 10 m away, as an instance sees them that is flattened to a ten-millionth along z.
TEST(Quadrics, FlatInstancesLoseNoHit) {
  const Transform flat = Transform::scale({1, 1, 1e-7f});
  for (int i = 0; i < 1000; ++i) {
    Sampler s(SamplerKind::independent, 1, Stream::test, i, 2);
    const float distance = 2 * s.get_1d(), phi = 2 * pi * s.get_1d();
    if (std::abs(distance - 1) < 0.02f) continue;
    const vec3 origin(3, -4, 1 + 8 * s.get_1d()), target(distance * std::cos(phi), distance * std::sin(phi), 0);
    const Ray ray{.origin = flat.inverse_point(origin), .direction = flat.inverse_vector(glm::normalize(target - origin))};
    float t;
    vec2 uv;
    EXPECT_EQ(intersect_quadric(ray, Sphere{vec3(0), 1}, infinity, t, uv), distance < 1) << distance;
    EXPECT_EQ(intersect_quadric(ray, Disk{vec3(0), 1, {0, 0, 1}}, infinity, t, uv), distance < 1) << distance;
  }
}

// Shadow rays: the direction is the whole way, whose square times that of the radius is no float.
TEST(Quadrics, WholeWaysAreMetAtAnySize) {
  for (const float size : {1e-12f, 1e-3f, 1e9f, 7e10f})
    for (const float aside : {0.0f, 0.3f, 0.9f}) {
      const Ray ray{.origin = size * vec3(aside, 0, -10), .direction = size * vec3(0, 0, 20)};
      const float half = std::sqrt(1 - aside * aside);
      float t;
      vec2 uv;
      EXPECT_TRUE(intersect_quadric(ray, Sphere{vec3(0), size}, 1, t, uv)) << size;
      EXPECT_NEAR(t, (10 - half) / 20, 1e-5f) << size;
      EXPECT_TRUE(intersect_quadric(ray, Cylinder{{0, -size, 0}, size, {0, 1, 0}, 2 * size, false}, 1, t, uv)) << size;
      EXPECT_NEAR(t, (10 - half) / 20, 1e-5f) << size;
    }
}

TEST(SlabTest, OriginOnAFaceAndZeroComponentsLoseNothing) {
  const Bounds box{vec3(0), vec3(1)};
  for (const float zero : {0.0f, -0.0f}) {
    for (const float x : {0.0f, 0.5f, 1.0f}) {
      const Ray ray{.origin = {x, 0.5f, -1}, .direction = {zero, zero, 1}};
      const BoxInterval interval = box_interval(SlabRay(ray), box, infinity);
      EXPECT_EQ(interval.entry, 1) << x;
      EXPECT_FALSE(interval.empty()) << x;
    }
    const Ray outside{.origin = {1.5f, 0.5f, -1}, .direction = {zero, zero, 1}};
    EXPECT_TRUE(box_interval(SlabRay(outside), box, infinity).empty());
  }
}

}  // namespace
}  // namespace etendue
