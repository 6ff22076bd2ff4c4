// Photons and their density: kernels and nearest neighbours against theory, the map against closed forms.
#include "framework/core/counters.h"
#include "framework/scene/builder.h"
#include "framework/structure_names.h"
#include "integrators/photons/photon_gather.h"
#include "integrators/photons/photon_maps.h"
#include "tests/image_checks.h"
#include "tests/lit_sheet.h"
#include "tests/scene_context.h"
#include "tests/white_plane.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::bias_over_seeds;
using testing::exact_image;
using testing::origin;
using testing::render;
using testing::RenderOptions;
using testing::SceneContext;
using testing::white_plane;

constexpr Kernel kernels[] = {Kernel::box, Kernel::cone, Kernel::epanechnikov, Kernel::gaussian};

std::unique_ptr<PointQuery> points_over(const std::vector<vec3>& points) {
  auto query = find_point_structure("brute", {}).make();
  query->build(points);
  return query;
}

double density(const PointQuery& query, const vec3& at, int k, float radius, Kernel kernel) {
  Neighbours found;
  const KernelDisc disc = find_disc(query, at, k, radius, found);
  double sum = 0;
  for (std::size_t i = 0; i < disc.count; ++i) sum += disc.shape(kernel, found[i].distance_squared);
  return sum * disc.per_area();
}

TEST(Kernel, EachIntegratesToOneOverItsDisc) {
  for (const Kernel kernel : kernels) {
    double sum = 0;
    constexpr int steps = 100000;
    for (int i = 0; i < steps; ++i) sum += kernel_shape(kernel, (static_cast<float>(i) + 0.5f) / steps);
    EXPECT_NEAR(sum / steps, 1, 1e-4) << name_of(kernel);
  }
}

TEST(NearestPhotons, DensityIsUnbiasedForEveryKernelAndItsVarianceIsKnown) {
  // n = 100 uniform photons in 100 m^2, k = 20. The share U of the square within the k-th distance is Beta(k, n - k + 1), of
  // which follow the mean 1 and, for the box, the variance (n - k + 1) / ((k - 2) n): 1 / (k - 2) as n grows.
  constexpr int trials = 4000, k = 20;
  constexpr float half = 5;
  struct Case {
    Kernel kernel;
    float r_max;
  };
  std::vector<Case> cases;
  for (const Kernel kernel : kernels) cases.push_back({kernel, infinity});
  cases.push_back({Kernel::box, 2.5f});  // the bound stops about half of the searches: 19.6 photons expected
  cases.push_back({Kernel::epanechnikov, 2.5f});
  std::vector<double> sum(cases.size()), squares(cases.size());
  for (int trial = 0; trial < trials; ++trial) {
    Pcg32 random(17, static_cast<std::uint64_t>(trial));
    std::vector<vec3> points(100);
    for (vec3& p : points) p = vec3(random.next_float() * 2 - 1, random.next_float() * 2 - 1, 0) * half;
    const auto query = points_over(points);
    for (std::size_t c = 0; c < cases.size(); ++c) {
      const double d = density(*query, vec3(0), k, cases[c].r_max, cases[c].kernel);
      sum[c] += d;
      squares[c] += d * d;
    }
  }
  for (std::size_t c = 0; c < cases.size(); ++c) {
    const double mean = sum[c] / trials, variance = squares[c] / trials - mean * mean;
    EXPECT_NEAR(mean, 1, 4.5 * std::sqrt(variance / trials)) << name_of(cases[c].kernel) << " " << cases[c].r_max;
  }
  const double mean = sum[0] / trials, variance = squares[0] / trials - mean * mean;
  EXPECT_NEAR(variance * (k - 2) / 0.81, 1, 0.1);
}

TEST(PhotonMap, DepthBoundAndHistorySelectPhotons) {
  const SceneContext plane(white_plane());
  Photons photons;
  photons.add({0, 0, 0}, Rgb(1), {0, 0, 1}, 1, {0, 0, 1}, photon_direct, 0);
  photons.add({0.1f, 0, 0}, Rgb(2), {0, 0, 1}, 1, {0, 0, 1}, photon_caustic, 1);
  photons.add({0, 0.1f, 0}, Rgb(4), {0, 0, 1}, 1, {0, 0, 1}, photon_indirect, 2);
  PhotonMap map;
  map.build(std::move(photons), find_point_structure("brute", {}).make(), {0, 1, Kernel::box, true});
  const Bsdf bsdf(plane.scene, origin);
  const auto sum = [&](PhotonHistory keep, int depth) {
    return std::lround(map.radiance(plane.context, origin, bsdf, {0, 0, 1}, keep, depth).x * pi * pi);
  };
  EXPECT_EQ(sum(photon_any, 9), 7);
  EXPECT_EQ(sum(photon_any, 1), 3);
  EXPECT_EQ(sum(photon_any, 0), 1);
  EXPECT_EQ(sum(photon_any, -1), 0);
  EXPECT_EQ(sum(photon_caustic, 9), 2);
  EXPECT_EQ(sum(photon_caustic | photon_indirect, 1), 2);
}

TEST(PhotonMap, DistanceIsFoundFromTheSmallestRadiusOfTheSearch) {
  Photons photons;
  for (const float x : {1.0f, 2.0f, 3.0f}) photons.add({x, 0, 0}, Rgb(1), {0, 0, 1}, 1, {0, 0, 1}, photon_direct, 0);
  PhotonMap map;
  map.build(std::move(photons), find_point_structure("brute", {}).make(),
            {0, std::numeric_limits<float>::denorm_min(), Kernel::box, true});
  const GatherPoint at = GatherPoint::irradiance(vec3(0), {0, 0, 1}, {0, 0, 1});
  const testing::SceneContext stage(testing::white_plane());
  EXPECT_EQ(map.distance_to(stage.context, 2, at, 10), 2);
  EXPECT_EQ(map.distance_to(stage.context, 4, at, 10), 10);
  for (const float guess : {0.01f, 1.9f, 2.0f, 2.5f, 9.0f, 40.0f})
    EXPECT_EQ(map.distance_to(stage.context, 2, at, 10, guess), 2) << guess;
}

// A map that is built anew in every iteration holds one photon in some of them, and their light would be lost.
TEST(PhotonMap, OnePhotonKeepsItsPower) {
  const SceneContext plane(white_plane());
  Photons photons;
  photons.add({0.3f, 0.2f, 0}, Rgb(1), {0, 0, 1}, 1, {0, 0, 1}, photon_caustic, 1);
  PhotonMap map;
  map.build(std::move(photons), find_point_structure("brute", {}).make(), {.k = 10, .alone = 0.5f});
  constexpr int side = 60;
  constexpr float spacing = 0.05f;
  double power = 0;
  for (int i = 0; i < side * side; ++i) {
    SurfacePoint point = origin;
    point.position = vec3(static_cast<float>(i % side - side / 2), static_cast<float>(i / side - side / 2), 0) * spacing;
    const Bsdf bsdf(plane.scene, point);
    power += pi * square(spacing) * map.radiance(plane.context, point, bsdf, {0, 0, 1}, photon_any, 64).x;
  }
  EXPECT_NEAR(power, 1, 0.01);
}

TEST(PhotonMap, SheetsKeepTheirLightBesideWallsOnEitherSide) {
  for (const float height : {0.6f, -0.6f}) {
    SCOPED_TRACE(height);
    RenderOptions options;
    options.params["edges"] = {std::string("visible"), {}};
    options.params["k"] = {std::int64_t{0}, {}};
    options.params["radius"] = {0.3, {}};
    options.params["photons"] = {std::int64_t{100000}, {}};
    options.iterations = 4;
    options.resolution = testing::sheet_resolution;
    testing::expect_even_sheet(render(testing::sheet_beside_wall(height, true), "photon-map", options).image);
  }
}

// Neither more photons than k nor fewer make a spot another brightness.
TEST(PhotonMap, FewPhotonsAreNotSpreadOverTheBoundOfTheSearch) {
  const SceneContext plane(white_plane());
  const Bsdf bsdf(plane.scene, origin);
  for (const int count : {5, 9, 11, 20}) {
    double sum = 0;
    constexpr int maps = 400;
    for (int trial = 0; trial < maps; ++trial) {
      Pcg32 random(3, static_cast<std::uint64_t>(trial));
      Photons photons;
      while (photons.size() < static_cast<std::size_t>(count)) {
        const vec3 p(2 * random.next_float() - 1, 2 * random.next_float() - 1, 0);
        if (glm::dot(p, p) < 1) photons.add(p, Rgb(1), {0, 0, 1}, 1, {0, 0, 1}, photon_caustic, 1);
      }
      PhotonMap map;
      map.build(std::move(photons), find_point_structure("brute", {}).make(), {.k = 10});
      sum += map.radiance(plane.context, origin, bsdf, {0, 0, 1}, photon_any, 64).x / maps;
    }
    EXPECT_NEAR(sum * pi / (count / pi), 1, 0.4) << count;
  }
}

// Hulls are not for caustics, which then have a map of their own, or discs.
TEST(PhotonMaps, CausticsAreNotDividedByHulls) {
  const SceneContext scene(load_scene("builtin:water"));
  const auto caustic_photons = [&](Edges edges) {
    PhotonMaps maps({.edges = edges}, "");
    maps.prepare(scene.context, {});
    return maps.caustic_photons();
  };
  EXPECT_EQ(caustic_photons(Edges::disc), 0);
  EXPECT_GT(caustic_photons(Edges::hull), 0);
}

// On a slanting plane, whose normal photons know rounded, grazing light is divided by the exact cosine; on another facet by the
// one that its photons know.
TEST(PhotonMap, PhotonsAreDividedByTheCosineWhereTheyLanded) {
  SceneBuilder b("ramp");
  const auto rough = b.material(Plastic{.reflectance = Rgb(0.5f), .coat = 1.5f, .alpha = 0.3f});
  b.mesh(quad({-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}), rough);
  const Scene scene = b.finish();
  const vec3 normal = glm::normalize(vec3(0.5f, 0.866f, 0)), along(normal.y, -normal.x, 0);
  const SurfacePoint point{vec3(0), normal, normal, along, vec2(0), rough, no_id};
  const Bsdf bsdf(scene, point);
  const GatherPoint at(point, bsdf, normal, photon_any, 64);
  const vec3 facet = glm::normalize(vec3(0.1f, 1, 0));
  for (const float height : {0.9f, 0.3f, 0.06f, 0.01f, 0.003f}) {
    const vec3 wi = height * normal + safe_sqrt(1 - height * height) * along;
    const vec3 value = bsdf.evaluate(normal, wi);
    Photons photons;
    for (const vec3& landed : {normal, -normal, facet}) photons.add(vec3(0), Rgb(1), wi, 1, landed, photon_direct, 0);
    for (const std::uint32_t id : {0u, 1u})
      EXPECT_NEAR(at.reflected(photons, id).x / (value.x / height), 1, 1e-6 / height) << height;
    if (height < 0.05f) continue;
    const float cosine = std::abs(glm::dot(wi, facet));
    EXPECT_NEAR(at.reflected(photons, 2).x / (value.x / cosine), 1, 0.006f / cosine) << height;
  }
}

// --- Photon tracing.

// Photons would be gathered in a lobe that hardly one of them hits: by 1.002, what is seen through a ball was 0.42 of it.
TEST(RoughMaterials, GlassThatHardlyRefractsIsFollowed) {
  Scene scene;
  for (const float eta : {1.5f, 1 / 1.5f, 1.1f, 1.002f, 0.999f})
    scene.materials.emplace_back(Dielectric{.eta = eta, .alpha = 0.3f});
  const RoughMaterials rough(scene, 0.25f);
  for (const std::uint32_t strong : {0u, 1u}) EXPECT_TRUE(rough(strong)) << strong;
  for (const std::uint32_t weak : {2u, 3u, 4u}) EXPECT_FALSE(rough(weak)) << weak;
}

Photons photons_of(const Scene& scene, const PhotonPass& pass, int threads = 2) {
  const SceneContext traced(scene);
  Photons photons;
  with_threads(threads, [&] { photons = trace_photons(traced.context, RoughMaterials(scene, 0.25f), pass); });
  return photons;
}

TEST(PhotonTracing, SamePhotonsAtAnyThreadCount) {
  const Scene scene = load_scene("builtin:cornell-spheres");
  const PhotonPass pass{
      .count = 30000, .key = 3, .max_scatterings = 20, .keep = photon_any, .sampler = SamplerKind::independent};
  const Photons one = photons_of(scene, pass, 1);
  EXPECT_GT(one.size(), 10000u);
  EXPECT_TRUE(one == photons_of(scene, pass, 2));
  EXPECT_TRUE(one == photons_of(scene, pass, 3));
}

TEST(PhotonTracing, PowerArrivesInFullAndEvenly) {
  // Central light, albedo 1/2: 4 pi I arrives first, half of it again, and so on; roulette keeps each photon's power.
  const Scene scene = load_scene("builtin:lambert-sphere");
  const Photons photons = photons_of(scene, {.count = 100000, .key = 0, .max_scatterings = 60});
  double power[3] = {};
  for (std::size_t i = 0; i < photons.size(); ++i) {
    if (photons.scatterings[i] < 3) power[photons.scatterings[i]] += photons.power[i].x;
    ASSERT_NEAR(photons.power[i].x / (4 * pi / 100000), 1, 1e-4);
    ASSERT_EQ(photons.side[i].history, photons.scatterings[i] == 0 ? photon_direct : photon_indirect);
    ASSERT_LT(glm::dot(photons.side[i].normal(), photons.position[i]), 0) << "the inner side";
  }
  for (int j = 0; j < 3; ++j) EXPECT_NEAR(power[j] / (4 * std::numbers::pi * std::pow(0.5, j)), 1, 0.02) << j;
}

TEST(PhotonTracing, HistoriesPartitionThePhotons) {
  const Scene scene = load_scene("builtin:cornell-spheres");
  const auto kept = [&](PhotonHistory keep) {
    return photons_of(scene, {.count = 20000, .key = 1, .max_scatterings = 20, .keep = keep}).size();
  };
  const std::size_t direct = kept(photon_direct), caustic = kept(photon_caustic), indirect = kept(photon_indirect);
  EXPECT_GT(caustic, 100u);
  EXPECT_EQ(direct + caustic + indirect, kept(photon_any));
}

// Photons that are kept would have to scatter first, and may not.
TEST(PhotonTracing, NoneAreEmittedOfWhichNoneCanBeKept) {
  const Scene scene = load_scene("builtin:cornell-box");
  const auto emitted = [&](PhotonHistory keep) {
    reset_counters();
    photons_of(scene, {.count = 1000, .key = 1, .max_scatterings = 0, .keep = keep});
    return read_counters()[static_cast<std::size_t>(Counter::photons_emitted)];
  };
  EXPECT_EQ(emitted(photon_indirect | photon_caustic), 0u);
  EXPECT_EQ(emitted(photon_any), 1000u);
}

// --- The integrator.

RenderOptions map_options(std::int64_t photons, std::uint32_t iterations, ParamMap more = {}) {
  RenderOptions options;
  options.params = std::move(more);
  options.params["photons"] = {photons, {}};
  options.iterations = iterations;
  return options;
}

TEST(PhotonMapping, MatchesClosedFormsWithinItsDeclaredBias) {
  for (const char* name : {"builtin:lambert-sphere", "builtin:lambert-sphere-off-centre", "builtin:furnace"})
    for (const ParamMap& params : {ParamMap{},
                                   {{"final_gather", {std::int64_t{3}, {}}}},
                                   {{"k", {std::int64_t{0}, {}}}},
                                   {{"emission", {std::string("importance"), {}}}},
                                   {{"emission", {std::string("visibility"), {}}}}}) {
      const auto b = bias_over_seeds(load_scene(name), "photon-map", map_options(8000, 1, params), 6);
      EXPECT_LT(std::abs(b.mean), b.bound + 4 * b.deviation) << name;
      EXPECT_LT(std::abs(b.mean), 0.003 + 4 * b.deviation) << name << ": no edge, so far below what is declared";
    }
}

TEST(PhotonMapping, FollowsTheClosedFormPixelByPixel) {
  // Light off the centre; indirect light is even, so no kernel blurs it, and what is left is the photons' noise.
  const Scene scene = load_scene("builtin:lambert-sphere-off-centre");
  const RenderOptions options = map_options(60000, 4, {{"k", {std::int64_t{200}, {}}}});
  EXPECT_LT(relmse(render(scene, "photon-map", options).image, exact_image(scene, options.resolution)), 2e-3);
}

TEST(PhotonMapping, SphereHasNoKernelBiasAtAnyRadius) {
  // A ball of radius r cuts pi r^2 out of a sphere, evenly in d^2, so that every kernel is exact at every radius.
  const Scene scene = load_scene("builtin:lambert-sphere");
  for (const char* kernel : {"box", "cone", "epanechnikov", "gaussian"})
    for (const double radius : {0.15, 0.5, 1.0}) {
      RenderOptions options =
          map_options(6000, 1, {{"k", {std::int64_t{0}, {}}}, {"radius", {radius, {}}}, {"kernel", {std::string(kernel), {}}}});
      options.resolution = {16, 16};
      const auto b = bias_over_seeds(scene, "photon-map", options, 6);
      EXPECT_LT(std::abs(b.mean), 6 * b.deviation) << kernel << " " << radius;
    }
}

TEST(PhotonMapping, DepthLimitTruncatesTheSeries) {
  for (const std::int64_t rays : {0, 2})
    testing::expect_truncated_series("photon-map", map_options(40000, 2, {{"final_gather", {rays, {}}}}), 0.02);
}

TEST(PhotonMapping, SameBitsAtAnyThreadCount) {
  const Scene scene = load_scene("builtin:cornell-spheres");
  const ParamMap variants[] = {{},
                               {{"final_gather", {std::int64_t{2}, {}}}, {"precompute", {std::int64_t{4}, {}}}},
                               {{"emission", {std::string("visibility"), {}}}, {"edges", {std::string("visible"), {}}}},
                               {{"emission", {std::string("importance"), {}}}, {"edges", {std::string("hull"), {}}}}};
  for (const ParamMap& variant : variants) {
    RenderOptions options = map_options(10000, 2, variant);
    options.params["retrace"] = {true, {}};
    options.params["caustic_photons"] = {std::int64_t{10000}, {}};
    testing::expect_same_bits_at_any_thread_count(scene, "photon-map", options);
  }
}

TEST(PhotonMapping, EveryParameterChangesTheImage) {
  const Scene scene = load_scene("builtin:veach-mis");  // rough plates
  const Scene spheres = load_scene("builtin:cornell-spheres");
  RenderOptions options =
      map_options(3000, 2, {{"caustic_map", {std::string("on"), {}}}, {"caustic_photons", {std::int64_t{3000}, {}}}});
  const auto hash = [&](const Scene& s, const char* name, const ParamMap::mapped_type& value) {
    RenderOptions changed = options;
    changed.params[name] = value;
    return render(s, "photon-map", changed).hash;
  };
  const std::uint64_t plain = render(spheres, "photon-map", options).hash;
  const std::pair<const char*, decltype(ParamValue::value)> changes[] = {
      {"photons", std::int64_t{4000}},
      {"caustic_photons", std::int64_t{4000}},
      {"k", std::int64_t{20}},
      {"radius", 0.05},
      {"kernel", "box"},
      {"final_gather", std::int64_t{2}},
      {"caustic_map", "off"},
      {"side_test", false},
      {"retrace", true},
      {"further_paths", 0.0},
      {"edges", "visible"},
      {"edges", "hull"},
      {"emission", "importance"},
      {"emission", "visibility"},
      {"max_depth", std::int64_t{2}},
      {"sampler", "independent"},
  };
  for (const auto& [name, value] : changes) EXPECT_NE(hash(spheres, name, {value, {}}), plain) << name;
  options.params["final_gather"] = {std::int64_t{2}, {}};
  const std::uint64_t gathered = render(spheres, "photon-map", options).hash;
  EXPECT_NE(hash(spheres, "gather_sampling", {std::string("bsdf"), {}}), gathered);
  EXPECT_NE(hash(spheres, "precompute", {std::int64_t{4}, {}}), gathered);
  options.params.erase("final_gather");
  EXPECT_NE(hash(scene, "carry_below", {0.01, {}}), render(scene, "photon-map", options).hash);
  for (const char* structure : point_structure_names)
    EXPECT_EQ(hash(spheres, "structure", {std::string(structure), {}}), plain) << "structures answer alike";
  EXPECT_THROW(hash(spheres, "k", {std::int64_t{1}, {}}), Error);
}

TEST(PhotonMapping, CausticsHaveAMapOfTheirOwnWhereGatherRaysLookUpTheOther) {
  const Scene spheres = load_scene("builtin:cornell-spheres"), box = load_scene("builtin:cornell-box");
  const auto hash = [](const Scene& scene, const char* map, std::int64_t gather, std::int64_t photons = 0) {
    return render(scene, "photon-map",
                  map_options(3000, 1,
                              {{"caustic_map", {std::string(map), {}}},
                               {"caustic_photons", {photons, {}}},
                               {"final_gather", {gather, {}}}}))
        .hash;
  };
  EXPECT_EQ(hash(spheres, "auto", 0), hash(spheres, "off", 0)) << "one map is seen directly";
  EXPECT_EQ(hash(spheres, "auto", 0, 3000), hash(spheres, "on", 0, 3000)) << "who gives it photons wants one";
  EXPECT_NE(hash(spheres, "auto", 0), hash(spheres, "on", 0));
  EXPECT_EQ(hash(spheres, "auto", 2), hash(spheres, "on", 2));
  EXPECT_NE(hash(spheres, "auto", 2), hash(spheres, "off", 2));
  EXPECT_EQ(hash(box, "auto", 2), hash(box, "off", 2)) << "nothing makes caustics";
}

// The sun through a pane, on a field from which gather rays see nothing: all light is caustics that the camera sees.
TEST(PhotonMapping, CausticsOfTheGlobalMapAreSeenWhereverGatherRaysLook) {
  for (const char* emission : {"power", "importance", "visibility"}) {
    RenderOptions options;
    options.iterations = 1;
    options.params = {{"final_gather", {std::int64_t{4}, {}}},
                      {"photons", {std::int64_t{20000}, {}}},
                      {"caustic_map", {std::string("off"), {}}},
                      {"emission", {std::string(emission), {}}}};
    const auto b = bias_over_seeds(load_scene("builtin:sunlit-field"), "photon-map", options, 3);
    EXPECT_LT(std::abs(b.mean), 8 * b.deviation + 0.05) << emission << ": " << b.mean << " +- " << b.deviation;
  }
}

// Sorting what every look-up finds by distance would take most of the time.
TEST(PhotonMapping, MoreNeighboursThanPhotonsAreAllWithinTheRadius) {
  const Scene scene = load_scene("builtin:cornell-spheres");
  RenderOptions options = map_options(2000, 1, {{"radius", {0.4, {}}}});
  options.params["caustic_photons"] = {std::int64_t{2000}, {}};
  options.params["k"] = {std::int64_t{1000000}, {}};
  const std::uint64_t nearest = render(scene, "photon-map", options).hash;
  options.params["k"] = {std::int64_t{0}, {}};
  EXPECT_EQ(render(scene, "photon-map", options).hash, nearest);
}

TEST(PhotonMapping, WhiteFurnaceStaysWhite) {
  // Every path leaves for the environment; what the glass and the mirror send on lands on the others as caustics.
  const auto b = bias_over_seeds(load_scene("builtin:white-furnace"), "photon-map",
                                 map_options(40000, 8, {{"caustic_photons", {std::int64_t{40000}, {}}}}), 6);
  EXPECT_LT(std::abs(b.mean), 0.01 + 4 * b.deviation);
}

}  // namespace
}  // namespace etendue
