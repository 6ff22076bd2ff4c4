// Second derivatives of irradiance against closed forms differentiated twice, and the metrics that use them.
#include "integrators/caches/records/irradiance_hessian.h"
#include "framework/core/sampler.h"
#include "framework/scenes/exact.h"
#include "integrators/caches/records/cache_metric.h"

#include <gtest/gtest.h>

#include <functional>

namespace etendue {
namespace {

const vec3 zenith{0, 1, 0};

// Holds what a ray meets: distance (infinity: nothing), radiance, normal.
struct SeenPoint {
  float distance = infinity;
  float radiance = 0;
  vec3 normal{0};
};
using World = std::function<SeenPoint(const vec3& origin, const vec3& direction)>;

struct Hemisphere {
  HemisphereStrata strata;
  Frame frame;
  std::vector<HemisphereSample> samples;
};

Hemisphere look(const World& world, const vec3& position, int count, std::uint64_t seed = 7) {
  Hemisphere h{HemisphereStrata::of(count), Frame::from_normal(zenith), {}};
  Sampler sampler(SamplerKind::independent, seed, Stream::test, 0, 0);
  for (int i = 0; i < h.strata.count(); ++i) {
    const vec3 direction = h.frame.to_world(h.strata.direction(i, sampler.get_2d()));
    const SeenPoint seen = world(position, direction);
    h.samples.push_back({Rgb(seen.radiance), seen.distance, direction, seen.normal});
  }
  return h;
}

// The ceiling y = height, bright where inside(x, z).
template <class Inside>
World ceiling(float height, const Inside& inside) {
  return [=](const vec3& o, const vec3& d) {
    if (d.y <= 0) return SeenPoint{};
    const float t = (height - o.y) / d.y;
    const vec3 p = o + t * d;
    return SeenPoint{t, inside(p.x, p.z) ? 1.0f : 0.0f, vec3(0, -1, 0)};
  };
}

using Exact = std::function<double(const dvec3&)>;

TangentMatrix exact_hessian(const Exact& exact, const vec3& position, const Frame& frame) {
  const double h = 1e-3;
  const dvec3 p(position), u(frame.tangent), v(frame.bitangent);
  const auto at = [&](double a, double b) { return exact(p + h * (a * u + b * v)); };
  return {(at(1, 0) - 2 * at(0, 0) + at(-1, 0)) / (h * h), (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / (4 * h * h),
          (at(0, 1) - 2 * at(0, 0) + at(0, -1)) / (h * h)};
}

void expect_near(const TangentMatrix& estimate, const TangentMatrix& exact, double tolerance) {
  const double size = std::hypot(exact.xx, exact.yy, exact.xy);
  EXPECT_NEAR(estimate.xx, exact.xx, tolerance * size);
  EXPECT_NEAR(estimate.xy, exact.xy, tolerance * size);
  EXPECT_NEAR(estimate.yy, exact.yy, tolerance * size);
}

const std::vector<dvec3> corners{{-0.6, 1.5, -0.4}, {0.6, 1.5, -0.4}, {0.6, 1.5, 0.4}, {-0.6, 1.5, 0.4}};
const auto rectangle = [](float x, float z) { return std::abs(x) < 0.6f && std::abs(z) < 0.4f; };
const Exact rectangle_exact = [](const dvec3& q) { return polygon_irradiance(q, {0, 1, 0}, corners); };

TEST(EdgeDerivatives, MatchFiniteDifferences) {
  Sampler sampler(SamplerKind::independent, 5, Stream::test, 2, 0);
  const auto number = [&] { return 2.0 * sampler.get_1d() - 1; };
  for (int i = 0; i < 50; ++i) {
    const dvec3 a(number(), number(), number() + 1.5),
        b = i % 5 == 0 ? 3.0 * a + 0.05 * dvec3(number(), number(), 0) : dvec3(number(), number(), number() + 1.5);
    const auto value = [&](double x, double y) { return edge_derivatives(a - dvec3(x, y, 0), b - dvec3(x, y, 0)).value; };
    const EdgeDerivatives e = edge_derivatives(a, b);
    const double h = 1e-4, size = 1 + std::abs(e.hessian.xx) + std::abs(e.hessian.yy);
    EXPECT_NEAR(e.x, (value(h, 0) - value(-h, 0)) / (2 * h), 1e-4 * size) << i;
    EXPECT_NEAR(e.y, (value(0, h) - value(0, -h)) / (2 * h), 1e-4 * size) << i;
    EXPECT_NEAR(e.hessian.xx, (value(h, 0) - 2 * value(0, 0) + value(-h, 0)) / (h * h), 1e-3 * size) << i;
    EXPECT_NEAR(e.hessian.yy, (value(0, h) - 2 * value(0, 0) + value(0, -h)) / (h * h), 1e-3 * size) << i;
    EXPECT_NEAR(e.hessian.xy, (value(h, h) - value(h, -h) - value(-h, h) + value(-h, -h)) / (4 * h * h), 1e-3 * size) << i;
  }
}

TEST(OcclusionHessian, MatchesPolygonLight) {
  for (const vec3& p : {vec3(0.5f, 0, 0.2f), vec3(-0.9f, 0, 0.7f), vec3(1.5f, 0.3f, -0.4f)}) {
    const Hemisphere h = look(ceiling(1.5f, rectangle), p, 200000);
    const MeshDerivatives mesh = occlusion_derivatives(h.strata, h.samples, h.frame);
    EXPECT_NEAR(mesh.irradiance.x / rectangle_exact(dvec3(p)), 1, 0.04);  // the light's rim is known to a stratum
    expect_near(mesh.hessian, exact_hessian(rectangle_exact, p, h.frame), 0.05);
  }
}

TEST(OcclusionHessian, MatchesDiscLight) {
  const Exact exact = [](const dvec3& q) { return disc_irradiance(1.5 - q.y, std::hypot(q.x, q.z), 0.5); };
  for (const vec3& p : {vec3(0.3f, 0, 0), vec3(0.8f, 0, -0.6f)}) {
    const Hemisphere h = look(ceiling(1.5f, [](float x, float z) { return x * x + z * z < 0.25f; }), p, 200000);
    const MeshDerivatives mesh = occlusion_derivatives(h.strata, h.samples, h.frame);
    expect_near(mesh.hessian, exact_hessian(exact, p, h.frame), 0.05);
    const double step = 1e-4;
    for (const vec3& axis : {h.frame.tangent, h.frame.bitangent}) {
      const double slope = (exact(dvec3(p) + step * dvec3(axis)) - exact(dvec3(p) - step * dvec3(axis))) / (2 * step);
      EXPECT_NEAR(glm::dot(mesh.translation[0], axis), slope, 0.01 * exact(dvec3(p)));
    }
  }
}

TEST(OcclusionHessian, MatchesSphereLightWithItsSilhouetteHeld) {
  // Before a black backdrop. The silhouette of a curved occluder slides over it as the point moves, to second order; the mesh
  // keeps it where it is. So what it knows is the light's circle of tangency (its second derivatives are off by about radius
  // over distance from the sphere's own).
  const dvec3 centre(0, 1.7, 0);
  const double radius = 0.3;
  const World world = [](const vec3& o, const vec3& d) {
    const vec3 to = vec3(0, 1.7f, 0) - o;
    const float along = glm::dot(to, d), gap = length_squared(to - along * d);
    if (along <= 0 || gap >= 0.09f) return SeenPoint{6, 0, -d};
    const float t = along - std::sqrt(0.09f - gap);
    return SeenPoint{t, 1, glm::normalize(o + t * d - vec3(0, 1.7f, 0))};
  };
  for (const vec3& p : {vec3(0.5f, 0, 0.1f), vec3(-1, 0.2f, 1)}) {
    const double distance = glm::length(centre - dvec3(p)), leg = std::sqrt(distance * distance - radius * radius);
    const Frame facing = Frame::from_normal(vec3((centre - dvec3(p)) / distance));
    std::vector<dvec3> circle;
    for (int i = 0; i < 256; ++i) {
      const double angle = -2 * std::numbers::pi * i / 256;
      const dvec3 out = std::cos(angle) * dvec3(facing.tangent) + std::sin(angle) * dvec3(facing.bitangent);
      circle.push_back(dvec3(p) + leg / distance * (leg * dvec3(facing.normal) + radius * out));
    }
    const double sign = polygon_irradiance(dvec3(p), {0, 1, 0}, circle) > 0 ? 1 : -1;
    const Exact exact = [&](const dvec3& q) { return sign * polygon_irradiance(q, {0, 1, 0}, circle); };
    EXPECT_NEAR(exact(dvec3(p)) / sphere_irradiance(dvec3(p), {0, 1, 0}, centre, radius), 1, 1e-3);
    const Hemisphere h = look(world, p, 400000);
    expect_near(occlusion_derivatives(h.strata, h.samples, h.frame).hessian, exact_hessian(exact, p, h.frame), 0.1);
  }
}

TEST(RadiometricHessian, MatchesPolygonLightThatNothingHides) {
  for (const vec3& p : {vec3(0.5f, 0, 0.2f), vec3(-0.9f, 0, 0.7f)}) {
    const Hemisphere h = look(ceiling(1.5f, rectangle), p, 200000);
    expect_near(radiometric_hessian(h.strata, h.samples, h.frame), exact_hessian(rectangle_exact, p, h.frame), 0.03);
  }
}

// A small black plate half-way to the light: what it hides is a square of the light that moves with the point.
TEST(RadiometricHessian, MissesWhatAnOccluderDoesAndTheOcclusionHessianDoesNot) {
  const World light = ceiling(2, [](float x, float z) { return std::abs(x) < 1 && std::abs(z) < 1; });
  const World world = [=](const vec3& o, const vec3& d) {
    const float t = d.y > 0 ? (1 - o.y) / d.y : infinity;
    const vec3 p = o + t * d;
    if (t < infinity && std::abs(p.x - 0.2f) < 0.25f && std::abs(p.z) < 0.25f) return SeenPoint{t, 0, vec3(0, -1, 0)};
    return light(o, d);
  };
  const auto square = [](double x, double half, double y) {
    return std::vector<dvec3>{{x - half, y, -half}, {x + half, y, -half}, {x + half, y, half}, {x - half, y, half}};
  };
  // The plate lies wholly before the light at the points below.
  const Exact exact = [&](const dvec3& q) {
    return polygon_irradiance(q, {0, 1, 0}, square(0, 1, 2)) - polygon_irradiance(q, {0, 1, 0}, square(0.2, 0.25, 1));
  };
  const vec3 p(0.1f, 0, 0.1f);
  const Hemisphere h = look(world, p, 200000);
  const TangentMatrix expected = exact_hessian(exact, p, h.frame);
  expect_near(occlusion_derivatives(h.strata, h.samples, h.frame).hessian, expected, 0.1);
  EXPECT_LT(eigen(radiometric_hessian(h.strata, h.samples, h.frame)).first, 0.5 * std::abs(eigen(expected).first));
}

TEST(GeometricHessian, BoundsWhatAnyRadianceCouldDoInTheOpen) {
  const vec3 p(0.3f, 0, 0.2f);
  const Hemisphere lit = look(ceiling(1.5f, rectangle), p, 20000);
  EXPECT_GT(eigen(geometric_hessian(lit.strata, lit.samples, lit.frame)).first,
            std::abs(eigen(exact_hessian(rectangle_exact, p, lit.frame)).first));
}

TEST(TangentEigen, ReassemblesTheMatrix) {
  for (const TangentMatrix& m : {TangentMatrix{2, 1, -1}, {-3, 0.5, 1}, {0, 1, 0}, {1, 0, 1}, {-1, 0, -2}}) {
    const TangentEigen e = eigen(m);
    EXPECT_GE(std::abs(e.first), std::abs(e.second) - 1e-12);
    const dvec2 u = e.axis;
    EXPECT_NEAR(e.first * u.x * u.x + e.second * u.y * u.y, m.xx, 1e-12);
    EXPECT_NEAR((e.first - e.second) * u.x * u.y, m.xy, 1e-12);
    EXPECT_NEAR(e.first * u.y * u.y + e.second * u.x * u.x, m.yy, 1e-12);
  }
}

TEST(HessianReach, GrowsAsTheFourthRootAndTakesTheEllipse) {
  const Frame frame = Frame::from_normal(zenith);
  const MetricContext context{.accuracy = 0.2f, .scene_size = 10};
  const ValidityRadius one = hessian_radius({1, 0, 1}, frame, context),
                       sixteenth = hessian_radius({0.0625, 0, 0.0625}, frame, context);
  EXPECT_NEAR(sixteenth.length / one.length, 2, 1e-5);
  EXPECT_LT(glm::length(one.anisotropy), 1e-3f);
  const ValidityRadius ellipse = hessian_radius({1, 0, 0.0625}, frame, context);
  EXPECT_NEAR(ellipse.length / one.length, 2, 1e-5);
  const vec3 narrow = one.length * frame.tangent, wide = sixteenth.length * frame.bitangent;
  const auto distance = [&](const vec3& d) { return std::sqrt(length_squared(d) + square(glm::dot(d, ellipse.anisotropy))); };
  EXPECT_NEAR(distance(narrow) / ellipse.length, 1, 1e-4);
  EXPECT_NEAR(distance(wide) / ellipse.length, 1, 1e-4);
  EXPECT_NEAR(hessian_radius({1, 0, 1e-6}, frame, context).length / one.length, 2, 1e-5) << "no longer than twice its width";
}

TEST(RadiometricReach, IsOfAbsoluteErrorAndTheOcclusionHessiansOfRelative) {
  const Frame frame = Frame::from_normal(zenith);
  const MetricContext context{.accuracy = 0.2f, .scene_size = 10};
  const auto reach = [&](CacheMetric metric, float light) {
    IrradianceEstimate estimate;
    estimate.irradiance = Rgb(light);
    estimate.hessian = {light, 0, light};
    return metric_radius(metric, estimate, frame, context).length;
  };
  EXPECT_NEAR(reach(CacheMetric::radiometric_hessian, 1) / reach(CacheMetric::radiometric_hessian, 16), 2, 1e-5);
  EXPECT_NEAR(reach(CacheMetric::occlusion_hessian, 1) / reach(CacheMetric::occlusion_hessian, 16), 1, 1e-5);
}

TEST(OcclusionReach, BlackSurroundingsFallBackOnGeometry) {
  IrradianceEstimate estimate;
  estimate.geometric = {4, 0, 2};
  const Frame frame = Frame::from_normal(zenith);
  const MetricContext context{.accuracy = 0.2f, .scene_size = 10};
  const float geometric = metric_radius(CacheMetric::geometric_hessian, estimate, frame, context).length;
  EXPECT_FLOAT_EQ(metric_radius(CacheMetric::occlusion_hessian, estimate, frame, context).length, geometric);
  estimate.irradiance = Rgb(1);
  EXPECT_GT(metric_radius(CacheMetric::occlusion_hessian, estimate, frame, context).length, geometric);
  EXPECT_LT(metric_radius(CacheMetric::occlusion_hessian, estimate, frame, context).length,
            context.scene_size / context.accuracy);
}

}  // namespace
}  // namespace etendue
