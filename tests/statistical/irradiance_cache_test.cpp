// Irradiance gradients against differentiated closed forms; the cache against closed forms, its own order and threads.
#include "framework/core/counters.h"
#include "framework/core/sampler.h"
#include "framework/scene/builder.h"
#include "framework/scenes/exact.h"
#include "integrators/caches/records/irradiance_records.h"
#include "integrators/photons/cache_points.h"
#include "tests/image_checks.h"
#include "tests/scene_context.h"

#include <gtest/gtest.h>

#include <map>

namespace etendue {
namespace {

using testing::exact_image;
using testing::render;
using testing::RenderOptions;

// --- Gradients: incoming radiance given as a function, unit radiance on one light, black elsewhere.

using Seen = std::function<float(const vec3& origin, const vec3& direction)>;  // distance to the light, or infinity

IrradianceEstimate estimate(const vec3& position, const vec3& normal, const Seen& seen, int samples) {
  const HemisphereStrata strata = HemisphereStrata::of(samples);
  const Frame frame = Frame::from_normal(normal);
  std::vector<HemisphereSample> values(static_cast<std::size_t>(strata.count()));
  Sampler sampler(SamplerKind::independent, 7, Stream::test, 0, 0);
  for (int i = 0; i < strata.count(); ++i) {
    const vec3 direction = frame.to_world(strata.direction(i, sampler.get_2d()));
    const float distance = seen(position, direction);
    values[static_cast<std::size_t>(i)] = {Rgb(std::isinf(distance) ? 0.0f : 1.0f), distance};
  }
  return estimate_irradiance(strata, values, frame);
}

float meet_sphere(const vec3& o, const vec3& d, const vec3& centre, float radius) {
  const vec3 to = centre - o;
  const float along = glm::dot(to, d), square_gap = length_squared(to - along * d);
  return along > 0 && square_gap < radius * radius ? along - std::sqrt(radius * radius - square_gap) : infinity;
}

// y = height, facing down; inside(x, z).
template <class Inside>
float meet_ceiling(const vec3& o, const vec3& d, float height, const Inside& inside) {
  if (d.y <= 0) return infinity;
  const float t = (height - o.y) / d.y;
  const vec3 p = o + t * d;
  return inside(p.x, p.z) ? t : infinity;
}

constexpr int many = 400000;
const vec3 up{0, 1, 0};

void expect_translation(const Seen& seen, const vec3& position, const std::function<double(const dvec3&)>& exact,
                        double tolerance) {
  const IrradianceEstimate e = estimate(position, up, seen, many);
  const dvec3 p(position);
  EXPECT_NEAR(e.irradiance.x / exact(p), 1, 0.01);
  const double h = 1e-4;
  const double gx = (exact(p + dvec3(h, 0, 0)) - exact(p - dvec3(h, 0, 0))) / (2 * h);
  const double gz = (exact(p + dvec3(0, 0, h)) - exact(p - dvec3(0, 0, h))) / (2 * h);
  const double size = std::hypot(gx, gz);
  EXPECT_NEAR(e.translation[0].x, gx, tolerance * size);
  EXPECT_NEAR(e.translation[0].y, 0, tolerance * size);
  EXPECT_NEAR(e.translation[0].z, gz, tolerance * size);
}

TEST(IrradianceGradient, TranslationMatchesPolygonLight) {
  const auto seen = [](const vec3& o, const vec3& d) {
    return meet_ceiling(o, d, 1.5f, [](float x, float z) { return std::abs(x) < 0.6f && std::abs(z) < 0.4f; });
  };
  const std::vector<dvec3> corners{{-0.6, 1.5, -0.4}, {0.6, 1.5, -0.4}, {0.6, 1.5, 0.4}, {-0.6, 1.5, 0.4}};
  for (const vec3& p : {vec3(0.5f, 0, 0.2f), vec3(-0.9f, 0, 0.7f), vec3(1.5f, 0.3f, -0.4f)})
    expect_translation(
        seen, p,
        [&](const dvec3& q) {
          return polygon_irradiance(q, {0, 1, 0}, corners);
        },
        0.03);
}

TEST(IrradianceGradient, TranslationMatchesDiscLight) {
  const auto seen = [](const vec3& o, const vec3& d) {
    return meet_ceiling(o, d, 1.5f, [](float x, float z) { return x * x + z * z < 0.25f; });
  };
  for (const vec3& p : {vec3(0.3f, 0, 0), vec3(0.8f, 0, -0.6f)})
    expect_translation(
        seen, p, [](const dvec3& q) { return disc_irradiance(1.5 - q.y, std::hypot(q.x, q.z), 0.5); }, 0.03);
}

TEST(IrradianceGradient, TranslationMatchesSphereLight) {
  // A sphere bends away from its silhouette, so the sampled distances near it are short: the error (4 % here) falls as a root
  // of the strata.
  const auto seen = [](const vec3& o, const vec3& d) { return meet_sphere(o, d, {0, 1.7f, 0}, 0.3f); };
  for (const vec3& p : {vec3(0.5f, 0, 0.1f), vec3(-1, 0.2f, 1)})
    expect_translation(
        seen, p,
        [](const dvec3& q) {
          return sphere_irradiance(q, {0, 1, 0}, {0, 1.7, 0}, 0.3);
        },
        0.06);
}

TEST(IrradianceGradient, RotationMatchesTiltedPolygonLight) {
  const auto seen = [](const vec3& o, const vec3& d) {
    return meet_ceiling(o, d, 1.5f, [](float x, float z) { return std::abs(x) < 0.6f && std::abs(z) < 0.4f; });
  };
  const std::vector<dvec3> corners{{-0.6, 1.5, -0.4}, {0.6, 1.5, -0.4}, {0.6, 1.5, 0.4}, {-0.6, 1.5, 0.4}};
  const vec3 position(0.9f, 0, 0.5f);
  const IrradianceEstimate e = estimate(position, up, seen, many);
  for (const vec3& tilt : {vec3(0.05f, 0, 0), vec3(0, 0, -0.05f), vec3(0.03f, 0, 0.04f)}) {
    const vec3 tilted = glm::normalize(up + tilt), other = glm::normalize(up - tilt);
    const double exact = polygon_irradiance(dvec3(position), dvec3(tilted), corners) -
                         polygon_irradiance(dvec3(position), dvec3(other), corners);
    const double linear = glm::dot(glm::cross(up, tilted) - glm::cross(up, other), e.rotation[0]);
    EXPECT_NEAR(linear / exact, 1, 0.02);
  }
}

TEST(IrradianceGradient, ErrorOfExtrapolationIsOfSecondOrder) {
  // Halving the distance divides the error by two without gradients, by four with.
  const auto seen = [](const vec3& o, const vec3& d) { return meet_sphere(o, d, {0, 1.7f, 0}, 0.5f); };
  const auto exact = [](const dvec3& p) { return sphere_irradiance(p, {0, 1, 0}, {0, 1.7, 0}, 0.5); };
  const vec3 position(0.8f, 0, 0);
  const IrradianceEstimate e = estimate(position, up, seen, 4 * many);
  const auto error = [&](float step, bool gradient) {
    const double e0 = exact(dvec3(position));  // noise of the value itself left out
    const double predicted = e0 + (gradient ? step * e.translation[0].x : 0.0f);
    return std::abs(predicted - exact(dvec3(position + vec3(step, 0, 0))));
  };
  EXPECT_NEAR(error(0.2f, false) / error(0.1f, false), 2, 0.3);
  EXPECT_NEAR(error(0.4f, true) / error(0.2f, true), 4, 0.8);
  EXPECT_LT(error(0.2f, true), 0.2 * error(0.2f, false));
}

TEST(IrradianceEstimate, HarmonicDistanceOfASphereFromItsCentreIsItsRadius) {
  const auto seen = [](const vec3&, const vec3&) { return 2.5f; };
  const IrradianceEstimate e = estimate({0, 0, 0}, up, seen, 1000);
  EXPECT_NEAR(e.harmonic_distance(), 2.5f, 1e-4f);
  EXPECT_NEAR(e.irradiance.x, pi, 1e-4f);
  EXPECT_LT(glm::length(e.translation[0]), 1e-4f);
  EXPECT_LT(glm::length(e.rotation[0]), 1e-4f);
}

// --- Records.

IrradianceRecords records_of(const std::vector<IrradianceRecord>& all, float accuracy) {
  IrradianceRecords records(find_record_structure("octree", {}).make(Bounds{vec3(-2), vec3(2)}), accuracy);
  for (const IrradianceRecord& r : all) records.insert(r);
  return records;
}

TEST(IrradianceRecords, InterpolationDoesNotDependOnTheOrderOfInsertion) {
  std::vector<IrradianceRecord> all;
  Sampler sampler(SamplerKind::independent, 3, Stream::test, 1, 0);
  for (int i = 0; i < 200; ++i) {
    const vec2 u = sampler.get_2d();
    IrradianceRecord r{{2 * u.x - 1, 0, 2 * u.y - 1}, up, 0.5f + sampler.get_1d(), Rgb(sampler.get_1d())};
    r.translation[0] = vec3(sampler.get_1d(), 0, sampler.get_1d());
    all.push_back(r);
  }
  const IrradianceRecords forward = records_of(all, 0.3f);
  std::reverse(all.begin(), all.end());
  const IrradianceRecords backward = records_of(all, 0.3f);
  for (int i = 0; i < 100; ++i) {
    const vec2 u = sampler.get_2d();
    const vec3 p(2 * u.x - 1, 0, 2 * u.y - 1);
    const auto a = forward.interpolate(p, up), b = backward.interpolate(p, up);
    ASSERT_TRUE(a && b);
    EXPECT_NEAR(a->irradiance.x / b->irradiance.x, 1, 1e-5);
  }
}

TEST(IrradianceRecords, RecordInFrontOrTurnedAwayIsRefused) {
  const IrradianceRecords step = records_of({{{0, 0.3f, 0}, up, 2, Rgb(1)}}, 0.4f);
  EXPECT_TRUE(step.covered({0.1f, 0.3f, 0}, up));
  EXPECT_FALSE(step.covered({0.1f, 0.1f, 0}, up)) << "a point below the step it was made on";
  EXPECT_TRUE(step.covered({0.1f, 0.35f, 0}, up)) << "a point above it";
  EXPECT_FALSE(step.covered({0.1f, 0.3f, 0}, -up)) << "the other side of a wall";
  EXPECT_FALSE(step.covered({0.1f, 0.3f, 0}, glm::normalize(vec3(1, 1, 0)))) << "45 degrees apart";
  const IrradianceRecords coarse = records_of({{{0, 0.3f, 0}, up, 2, Rgb(1)}}, 2);
  EXPECT_TRUE(coarse.covered({0.1f, 0.3f, 0}, glm::normalize(vec3(1, 0.1f, 0))));
  EXPECT_FALSE(coarse.covered({0.1f, 0.3f, 0}, -up)) << "the other side of a wall, at the accuracy of first images";
  EXPECT_FALSE(coarse.interpolate({0.1f, 0.3f, 0}, -up).has_value());
}

TEST(IrradianceRecords, GradientsAreOfTheIrradianceTowardsAPointAndANormal) {
  IrradianceRecord record{{0, 0, 0}, up, 2, Rgb(1)};
  record.translation[0] = vec3(0.1f, 0, 0.2f);  // red, per metre
  record.rotation[1] = vec3(0, 0, 0.3f);        // green, per radian about an axis
  const IrradianceRecords records = records_of({record}, 0.9f);
  const auto moved = records.interpolate({0.2f, 0, 0.1f}, up);
  ASSERT_TRUE(moved);
  EXPECT_NEAR(moved->irradiance.x, 1 + 0.02 + 0.02, 1e-6);
  EXPECT_NEAR(moved->irradiance.y, 1, 1e-6);
  // Turned about z, from y towards -x: cross(normal of the record, normal) is along +z.
  const auto turned = records.interpolate({0, 0, 0}, {-std::sin(0.1f), std::cos(0.1f), 0});
  ASSERT_TRUE(turned);
  EXPECT_NEAR(turned->irradiance.x, 1, 1e-6);
  EXPECT_NEAR(turned->irradiance.y, 1 + 0.3 * std::sin(0.1), 1e-6);
}

TEST(IrradianceRecords, AnEllipseReachesLessFarAlongItsNarrowAxis) {
  IrradianceRecord record{{0, 0, 0}, up, 1, Rgb(1)};
  record.anisotropy = vec3(0, 0, std::sqrt(3.0f));  // half as far along z
  const IrradianceRecords records = records_of({record}, 0.5f);
  EXPECT_TRUE(records.covered({0.45f, 0, 0}, up));
  EXPECT_FALSE(records.covered({0, 0, 0.45f}, up));
  EXPECT_TRUE(records.covered({0, 0, 0.24f}, up));
  EXPECT_FALSE(records.covered({0, 0, 0.26f}, up));
}

IrradianceRecord bounded_record(const IrradianceEstimate& estimate, bool extrapolates) {
  const MetricContext context{.accuracy = 0.2f,
                              .scene_size = 1,
                              .pixel_width = 0.01f,
                              .min_spacing = 1,
                              .max_spacing = 0.1f,
                              .extrapolates = extrapolates};
  return make_record({}, up, estimate, extrapolates ? Gradients::both : Gradients::none, CacheMetric::bounded_split_sphere,
                     context);
}

TEST(IrradianceRecords, ReachIsKeptBetweenTheSpacingsAndGradientsDoNotExtrapolateBelowZero) {
  IrradianceEstimate e;
  e.irradiance = Rgb(1);
  e.inverse_distance = 1e3f;
  EXPECT_FLOAT_EQ(bounded_record(e, false).validity_radius, 0.05f);
  e.inverse_distance = 0;
  EXPECT_FLOAT_EQ(bounded_record(e, false).validity_radius, 0.5f);
  for (int c = 0; c < 3; ++c) e.translation[c] = vec3(100, 0, 0);
  const IrradianceRecord steep = bounded_record(e, true);
  EXPECT_FLOAT_EQ(steep.validity_radius, 0.05f);
  EXPECT_LE(glm::length(steep.translation[0]) * steep.validity_radius, 1.0001f);
}

TEST(IrradianceRecords, ClampedReachesObeyTheTriangleInequalityInAnyOrder) {
  std::vector<IrradianceRecord> all;
  Sampler sampler(SamplerKind::independent, 3, Stream::test, 2, 0);
  for (int i = 0; i < 60; ++i) {
    const vec2 u = sampler.get_2d();
    all.push_back({{2 * u.x - 1, 0, 2 * u.y - 1}, up, i % 10 == 0 ? 0.05f : 2, Rgb(1)});
  }
  const auto reaches = [&] {
    IrradianceRecords records(find_record_structure("brute", {}).make(Bounds{vec3(-2), vec3(2)}), 0.3f, 1);
    for (const IrradianceRecord& r : all) records.insert(r);
    std::map<float, float> by_place;
    for (const IrradianceRecord& r : records.all()) {
      by_place[r.position.x] = r.validity_radius;
      for (const IrradianceRecord& other : records.all())
        EXPECT_LE(r.validity_radius, other.validity_radius + glm::length(r.position - other.position) + 1e-5f);
    }
    return by_place;
  };
  const auto forward = reaches();
  std::reverse(all.begin(), all.end());
  for (const auto& [place, reach] : reaches()) EXPECT_NEAR(forward.at(place), reach, 1e-5f);
}

// --- The integrator.

RenderOptions options_for(std::int64_t samples, std::uint32_t iterations) {
  RenderOptions options;
  options.params["samples"] = {samples, {}};
  options.iterations = iterations;
  return options;
}

TEST(IrradianceCache, MatchesClosedFormsWithinItsDeclaredBias) {
  for (const char* name : {"builtin:lambert-sphere", "builtin:lambert-sphere-off-centre", "builtin:furnace"}) {
    const auto b = testing::bias_over_seeds(load_scene(name), "irradiance-cache", options_for(256, 4), 6);
    EXPECT_LT(std::abs(b.mean), b.bound + 4 * b.deviation) << name;
    EXPECT_LT(std::abs(b.mean), 0.004 + 4 * b.deviation) << name << ": far below what is declared for rooms with edges";
    // Pixel by pixel too: the irradiance is smooth, so interpolation is good everywhere.
    EXPECT_LT(b.largest_relmse, 1e-3) << name;
  }
}

TEST(IrradianceCache, DepthLimitTruncatesTheSeries) {
  testing::expect_truncated_series("irradiance-cache", options_for(512, 4), 4e-3);
}

// builtin:lambert-sphere, seen through a pane that lets light pass straight on, over the whole view or its left half.
Scene sphere_behind_pane(bool whole) {
  SceneBuilder b("pane");
  b.quadric(Sphere{vec3(0), 1}, b.material(Diffuse{Rgb(0.5f)}), std::nullopt, true);
  b.light(PointLight{vec3(0), Rgb(1)});
  const float side = 0.012f, right = whole ? side : 0;
  b.mesh(quad({-side, -side, -0.49f}, {right, -side, -0.49f}, {right, side, -0.49f}, {-side, side, -0.49f}),
         b.material(Dielectric{.eta = 1}));
  b.camera({0, 0, -0.5f}, {0, 0, 1}, 70, {16, 16});
  return b.finish();
}

TEST(IrradianceCache, DepthLimitHoldsBehindGlass) {
  // The pane is an event of its own, so that light of at most d events has radiance (1 - 2^-(d - 1)) / pi behind it.
  const auto mean = [](const Scene& scene, const char* method, int depth) {
    RenderOptions options = options_for(128, 8);
    options.resolution = {16, 16};
    options.params["max_depth"] = {std::int64_t{depth}, {}};
    options.params["caustic_map"] = {std::string("off"), {}};
    const Image image = render(scene, method, options).image;
    double sum = 0;
    for (const dvec3& p : image.pixels) sum += p.x / static_cast<double>(image.pixels.size());
    return sum * std::numbers::pi;
  };
  for (const char* method : {"irradiance-cache", "radiance-cache"})
    for (int depth = 2; depth <= 5; ++depth) {
      const double open = 1 - std::pow(0.5, depth), behind = 1 - std::pow(0.5, depth - 1);
      EXPECT_NEAR(mean(sphere_behind_pane(true), method, depth) / behind, 1, 0.01) << method << ", depth " << depth;
      EXPECT_NEAR(mean(sphere_behind_pane(false), method, depth) / (0.5 * (open + behind)), 1, 0.01)
          << method << ", depth " << depth;
    }
}

// A box with walls from x to x + 2, and a window in its front near `window`.
void add_room(SceneBuilder& b, float x, float window, float reflectance) {
  const std::uint32_t paint = b.material(Diffuse{Rgb(reflectance)});
  const float y[] = {-1, -0.3f, 0.3f, 1}, across[] = {x, window, window + 0.35f, x + 2};
  const auto corner = [](float u, float v, float w) { return vec3(u, v, w); };
  const auto wall = [&](const vec3& p, const vec3& u, const vec3& v) { b.mesh(quad(p, p + u, p + u + v, p + v), paint); };
  const vec3 low = corner(x, -1, -1), along_x(2, 0, 0), along_y(0, 2, 0), along_z(0, 0, 2);
  wall(low, along_x, along_y);
  wall(low, along_x, along_z);
  wall(low + along_y, along_x, along_z);
  wall(low, along_y, along_z);
  wall(low + along_x, along_y, along_z);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      if (row != 1 || column != 1)
        wall(corner(across[column], y[row], 1), {across[column + 1] - across[column], 0, 0}, {0, y[row + 1] - y[row], 0});
}

// A limit of five events cuts off a quarter of the light in a white room, and nothing in a dark one: where both are seen, a
// share of the limit's light that stands for both would make the white room 11 to 30 % too bright.
TEST(IrradianceCache, DepthLimitHoldsInAWhiteRoomBesideADarkOne) {
  SceneBuilder b("rooms");
  add_room(b, -2.02f, -0.4f, 0.95f);
  add_room(b, 0.02f, 0.05f, 0.1f);
  b.light(PointLight{{-1.6f, 0.5f, 0.7f}, Rgb(1)});
  b.light(PointLight{{1.6f, 0.5f, 0.7f}, Rgb(300)});
  b.camera({0, 0, 1.2f}, {0, 0, 0}, 110, {32, 24});
  const Scene scene = b.finish();
  const auto white_room = [&](const char* method, std::uint32_t iterations, std::uint64_t seed) {
    RenderOptions options;
    options.iterations = iterations;
    options.resolution = {32, 24};
    options.seed = seed;
    options.params["max_depth"] = {std::int64_t{5}, {}};
    const Image image = render(scene, method, options).image;
    double sum = 0;
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 16; ++x) sum += image.at(x, y).x / (16 * 24);
    return sum;
  };
  const double by_paths = white_room("path", 512, 1);
  double by_records = 0;
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) by_records += white_room("irradiance-cache", 16, seed) / 4;
  EXPECT_NEAR(by_records / by_paths, 1, 0.06);
}

TEST(IrradianceCache, SameBitsAtAnyThreadCount) {
  for (const char* scene : {"builtin:cornell-spheres", "builtin:lambert-sphere"})
    testing::expect_same_bits_at_any_thread_count(load_scene(scene), "irradiance-cache", options_for(32, 2));
}

TEST(IrradianceCache, EveryParameterChangesTheImage) {
  const Scene scene = load_scene("builtin:cornell-spheres");
  RenderOptions options = options_for(32, 2);
  const std::uint64_t plain = render(scene, "irradiance-cache", options).hash;
  const std::pair<const char*, decltype(ParamValue::value)> changes[] = {
      {"accuracy", 0.4},
      {"samples", std::int64_t{512}},
      {"min_spacing", 4.0},
      {"max_spacing", 0.02},
      {"neighbour_clamping", false},
      {"gradients", "none"},
      {"gradients", "rotation"},
      {"max_depth", std::int64_t{2}},
      {"overture", false},
      {"sampler", "independent"},
      {"gradients", "mesh"},
      {"cache_direct", true},
      {"records", std::int64_t{200}},
      {"extra_samples", 0.5},
      {"metric", "tabellion"},
      {"metric", "split-sphere"},
      {"metric", "radiometric-hessian"},
      {"metric", "geometric-hessian"},
      {"metric", "occlusion-hessian"},
  };
  for (const auto& [name, value] : changes) {
    RenderOptions changed = options;
    changed.params[name] = {value, {}};
    EXPECT_NE(render(scene, "irradiance-cache", changed).hash, plain) << name;
  }
  RenderOptions brute = options;
  brute.params["structure"] = {std::string("brute"), {}};
  EXPECT_EQ(render(scene, "irradiance-cache", brute).hash, plain) << "structures answer alike";
}

TEST(IrradianceCache, FirstImageTakesFewOfTheRaysOfAWholeCache) {
  const Scene scene = load_scene("builtin:cornell-box");
  const auto rays_of = [&](bool refines) {
    RenderOptions options = options_for(768, 1);
    options.params["refine"] = {refines, {}};
    reset_counters();
    render(scene, "irradiance-cache", options);
    return read_counters()[static_cast<std::size_t>(Counter::rays)];
  };
  EXPECT_LT(10 * rays_of(true), rays_of(false));
}

TEST(IrradianceCache, BlackSurfacesNeedNoRecords) {
  const testing::SceneContext scene(load_scene("builtin:two-occluders?veil=false"), {48, 48});
  int found = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 48; ++x)
      if (const CachePoint point = find_cache_point(scene.context, {x, y}, 4, SamplerKind::sobol)) {
        ++found;
        EXPECT_NEAR(point.position.y, 0, 1e-4) << "the floor; all else is black or emits";
        EXPECT_EQ(point.depth, 0) << "nothing is seen in black surfaces";
      }
  EXPECT_GT(found, 400);
}

TEST(IrradianceCache, WhiteFurnaceStaysWhite) {
  // Diffuse, plastic, glass and mirror in a unit environment: the coated base, the coat and the specular surfaces each keep
  // their share.
  const Scene scene = load_scene("builtin:white-furnace");
  const RenderOptions options = options_for(256, 32);
  EXPECT_LT(std::abs(bias(render(scene, "irradiance-cache", options).image, exact_image(scene, options.resolution))), 3e-3);
}

TEST(IrradianceCache, LosesNoLightBetweenPixelsThatFinerRecordsLeaveUncovered) {
  // Paths find in later iterations, of another weight, the light that coarse records of the first ones covered.
  const Scene scene = load_scene("builtin:lambert-sphere");
  RenderOptions options = options_for(64, 6);
  options.params["accuracy"] = {0.03, {}};
  EXPECT_LT(std::abs(bias(render(scene, "irradiance-cache", options).image, exact_image(scene, options.resolution))), 0.02);
}

// --- What the cache says of its own error.

TEST(IrradianceEstimate, StatesTheVarianceOfItsNoise) {
  // Radiance that is noise alone: the estimates' scatter against what each states.
  const HemisphereStrata strata = HemisphereStrata::of(100);
  const Frame frame = Frame::from_normal(up);
  Sampler sampler(SamplerKind::independent, 11, Stream::test, 0, 0);
  double sum = 0, squares = 0, stated = 0;
  constexpr int estimates = 4000;
  for (int i = 0; i < estimates; ++i) {
    std::vector<HemisphereSample> values(static_cast<std::size_t>(strata.count()));
    for (HemisphereSample& value : values) value = {Rgb(sampler.get_1d()), 1};
    IrradianceEstimate estimate = estimate_irradiance(strata, values, frame);
    for (HemisphereSample& value : values) value = {Rgb(sampler.get_1d()), 1};
    estimate.average_in(estimate_irradiance(strata, values, frame), 2);
    const double e = luminance(estimate.irradiance);
    sum += e, squares += e * e, stated += estimate.variance;
  }
  const double mean = sum / estimates;
  EXPECT_NEAR(stated / (squares - estimates * mean * mean), 1, 0.08);  // its standard error: 2.2 %
}

}  // namespace
}  // namespace etendue
