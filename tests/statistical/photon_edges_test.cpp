// The light that density estimation loses at edges and lets through walls, against its formulas, and what the remedies leave of
// it.
#include "framework/scene/builder.h"
#include "integrators/photons/disc_coverage.h"
#include "integrators/photons/kernel_domain.h"
#include "integrators/photons/photon_gather.h"
#include "tests/block_agreement.h"
#include "tests/image_checks.h"
#include "tests/scene_context.h"
#include "tests/white_plane.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::origin;
using testing::SceneContext;

constexpr Kernel all_kernels[] = {Kernel::box, Kernel::cone, Kernel::epanechnikov, Kernel::gaussian};
constexpr float radius = 0.5f;

// The share that is left of a disc whose centre lies x radii from the straight edge of a surface.
double kept_share(double x) { return x >= 1 ? 1 : 1 - (std::acos(x) - x * std::sqrt(1 - x * x)) / std::numbers::pi; }

// White floor z = 0 for x < edge; with a wall there, or with more floor behind the wall.
struct Floor {
  float edge = 2;
  bool wall = false, behind = false;

  Scene scene() const {
    SceneBuilder b("floor");
    const auto white = b.material(Diffuse{Rgb(1)});
    const float end = behind ? 2 : edge;
    b.mesh(quad({-2, -2, 0}, {end, -2, 0}, {end, 2, 0}, {-2, 2, 0}), white);
    if (wall) b.mesh(quad({edge, -2, 0}, {edge, 2, 0}, {edge, 2, 2}, {edge, -2, 2}), white);
    return b.finish();
  }
};

// Photons of one per square metre and watt, where `lit`, relative to full even light.
class LitFloor {
 public:
  static constexpr int n = 200;
  static constexpr float spacing = 0.01f;

  LitFloor(const Floor& floor, const GatherOptions& options, float height = 0, const vec3& facing = {0, 0, 1}, float from = -9,
           float to = 9)
      : floor_(floor.scene()) {
    Photons photons;
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const vec3 p(vec2(x - n / 2, y - n / 2) * spacing + 0.5f * spacing, height);
        if (p.x > from && p.x < to) photons.add(p, Rgb(square(spacing) * pi), facing, 1, facing, photon_indirect, 1);
      }
    map_.build(std::move(photons), find_point_structure("brute", {}).make(), options);
  }
  double share() const {
    const Bsdf bsdf(floor_.scene, origin);
    return map_.radiance(floor_.context, origin, bsdf, {0, 0, 1}, photon_any, 64).x;
  }

 private:
  SceneContext floor_;
  PhotonMap map_;
};

GatherOptions fixed(Kernel kernel, Edges edges, bool side_test = true) {
  return {.k = 0, .radius = radius, .kernel = kernel, .side_test = side_test, .largest_radius = infinity, .edges = edges};
}

TEST(PhotonEdges, KernelWithinIsTheIntegralOfItsShape) {
  for (const Kernel kernel : all_kernels) {
    double sum = 0;
    for (int i = 0; i < 1000; ++i) {
      EXPECT_NEAR(kernel_within(kernel, static_cast<float>(i) / 1000), sum, 2e-4);
      sum += kernel_shape(kernel, (static_cast<float>(i) + 0.5f) / 1000) / 1000;
    }
    EXPECT_NEAR(kernel_within(kernel, 1), 1, 1e-5);
  }
}

TEST(PhotonEdges, LossAtAnEdgeIsTheShareOfTheDiscOffTheSurfaceAndVisibleAreaRestoresIt) {
  for (const double x : {0.02, 0.2, 0.5, 0.8, 1.1}) {
    const float edge = static_cast<float>(x) * radius;
    EXPECT_NEAR(LitFloor({edge}, fixed(Kernel::box, Edges::disc), 0, {0, 0, 1}, -9, edge).share(), kept_share(x), 0.01) << x;
    for (const bool wall : {false, true})
      for (const Kernel kernel : all_kernels)
        EXPECT_NEAR(LitFloor({edge, wall}, fixed(kernel, Edges::visible), 0, {0, 0, 1}, -9, edge).share(), 1, 0.02)
            << x << wall << static_cast<int>(kernel);
  }
}

TEST(PhotonEdges, LightBehindAWallLeaksThroughTheDiscAndNotThroughTheVisiblePart) {
  for (const double x : {0.1, 0.3, 0.6}) {
    const float edge = static_cast<float>(x) * radius;
    const Floor floor{edge, true, true};
    EXPECT_NEAR(LitFloor(floor, fixed(Kernel::box, Edges::disc), 0, {0, 0, 1}, edge, 9).share(), 1 - kept_share(x), 0.01) << x;
    EXPECT_EQ(LitFloor(floor, fixed(Kernel::box, Edges::visible), 0, {0, 0, 1}, edge, 9).share(), 0) << x;
  }
}

TEST(PhotonEdges, SideTestStopsTheLeakThroughAThinPlate) {
  // Photons arrive on the far face of a plate of thickness t: without the test 1 - (t / r)^2 of them is counted.
  for (const double t : {0.1, 0.5, 0.9}) {
    const float z = -static_cast<float>(t) * radius;
    EXPECT_NEAR(LitFloor({}, fixed(Kernel::box, Edges::disc, false), z, {0, 0, -1}).share(), 1 - t * t, 0.015);
    for (const Edges edges : {Edges::disc, Edges::visible, Edges::hull})
      EXPECT_EQ(LitFloor({}, fixed(Kernel::box, edges), z, {0, 0, -1}).share(), 0);
  }
}

// Mean and standard error of an estimate over maps of random photons, of a density of 300 per square metre, for x < edge.
std::pair<double, double> over_random_maps(const GatherOptions& options, float edge, const SceneContext& floor) {
  constexpr int trials = 400, photons_in_all = 1200;  // in 2 m x 2 m, binomial
  const Bsdf bsdf(floor.scene, origin);
  double sum = 0, squares = 0;
  for (int trial = 0; trial < trials; ++trial) {
    Pcg32 random(23, static_cast<std::uint64_t>(trial));
    Photons photons;
    for (int i = 0; i < photons_in_all; ++i) {
      const float x = 2 * random.next_float() - 1;
      const vec3 p(x, 2 * random.next_float() - 1, 0);
      if (x < edge) photons.add(p, Rgb(pi / 300), {0, 0, 1}, 1, {0, 0, 1}, photon_indirect, 1);
    }
    PhotonMap map;
    map.build(std::move(photons), find_point_structure("kd-tree", {}).make(), options);
    const double share = map.radiance(floor.context, origin, bsdf, {0, 0, 1}, photon_any, 64).x;
    sum += share;
    squares += share * share;
  }
  const double mean = sum / trials;
  return {mean, std::sqrt((squares / trials - mean * mean) / trials)};
}

TEST(PhotonEdges, HullIsUnbiasedAtAnEdgeForEveryKernelAndForNearestPhotons) {
  for (const double x : {0.0, 0.4, 2.0}) {
    const float edge = static_cast<float>(x) * 0.25f;
    const SceneContext floor(Floor{edge}.scene());
    for (const Kernel kernel : all_kernels) {
      GatherOptions options = fixed(kernel, Edges::hull);
      options.radius = 0.25f;
      const auto [mean, error] = over_random_maps(options, edge, floor);
      EXPECT_NEAR(mean, 1, 4.5 * error + 0.002) << x << " " << static_cast<int>(kernel);
      EXPECT_LT(error, 0.02);
    }
    GatherOptions nearest = fixed(Kernel::box, Edges::hull);
    nearest.k = 40;
    const auto [mean, error] = over_random_maps(nearest, edge, floor);
    EXPECT_NEAR(mean, 1, 4.5 * error + 0.002) << x << " nearest";
    nearest.edges = Edges::disc;
    const auto [lost, lost_error] = over_random_maps(nearest, edge, floor);
    if (x == 0) {
      EXPECT_NEAR(lost, 0.5, 4.5 * lost_error + 0.002);
    }
  }
}

// Photons are few where they are seen in these two scenes, and kernels wide: 15 % of the image was lost without a word.
TEST(PhotonEdges, PhotonMapTellsOfTheLightItLoses) {
  const auto left_out = [](const char* name, const char* edges) {
    testing::RenderOptions options;
    options.resolution = {32, 32};
    options.iterations = 4;
    options.params = testing::params_of({{"retrace", "true"}, {"edges", edges}});
    const Scene scene = load_scene(name);
    const auto rendered = testing::render(scene, "photon-map", options);
    options.iterations = 64;
    options.params = {};
    const Image reference = testing::render(scene, "path", options).image;
    EXPECT_LT(std::abs(bias(rendered.image, reference)), rendered.expectation.bias_bound) << name << " " << edges;
    return rendered.expectation.left_out;
  };
  EXPECT_EQ(left_out("builtin:cornell-box", "disc"), "");
  EXPECT_EQ(left_out("builtin:stadium", "visible"), "");
  EXPECT_NE(left_out("builtin:stadium", "disc"), "");
  EXPECT_NE(left_out("builtin:exterior", "disc"), "");
}

std::string left_out_by_photon_map(const Scene& scene, const char* parameter, const char* value) {
  testing::RenderOptions options;
  options.resolution = {32, 32};
  options.iterations = 1;
  options.params = testing::params_of({{parameter, value}});
  return testing::render(scene, "photon-map", options).expectation.left_out;
}

// Beside the light that metals leave out, once some of the houses are of glass.
TEST(PhotonEdges, PhotonMapTellsOfAllThatItLoses) {
  Scene scene = load_scene("builtin:exterior");
  scene.materials[1] = Dielectric{.eta = 1.5f};
  scene.materials.emplace_back(Conductor{.alpha = vec2(0.05f)});
  const std::string metals = left_out_by_photon_map(scene, "edges", "visible"),
                    both = left_out_by_photon_map(scene, "edges", "disc");
  EXPECT_TRUE(metals.ends_with("vcm brings it")) << metals;
  EXPECT_TRUE(both.starts_with(metals + "; kernels reach beyond edges")) << both;
}

// The field is a 192nd as wide as what the sun shines on: no photon lands there that would tell where to lead others.
TEST(PhotonEdges, PhotonMapTellsThatNoPhotonWasLedToWhatIsSeen) {
  const Scene scene = load_scene("builtin:sunlit-field?surroundings=192");
  EXPECT_NE(left_out_by_photon_map(scene, "emission", "visibility").find("no photon found a way"), std::string::npos);
  EXPECT_EQ(left_out_by_photon_map(scene, "emission", "power"), "");
}

TEST(PhotonEdges, InsideOfASphereTheWholeDiscIsVisible) {
  SceneBuilder b("sphere");
  b.quadric(Sphere{vec3(0), 1}, b.material(Diffuse{Rgb(1)}), std::nullopt, true);
  const SceneContext sphere(b.finish());
  Pcg32 random(4, 4);
  for (int i = 0; i < 50; ++i) {
    const vec3 p = glm::normalize(vec3(random.next_float(), random.next_float(), random.next_float()) - 0.5f);
    for (const float r : {0.05f, 0.15f, 0.3f})
      for (const Kernel kernel : all_kernels) EXPECT_NEAR(VisibleDomain(sphere.context, p, -p, r).share(kernel), 1, 1e-4) << r;
  }
}

// An edge that runs between two of the directions that are tried first is missed where it cuts off little.
TEST(PhotonEdges, WholeDiscsTakeFewRaysAndHardlyAnyEdgeIsMissed) {
  const auto rays_so_far = [] { return read_counters()[static_cast<std::size_t>(Counter::rays)]; };
  const SceneContext wide(Floor().scene());
  for (const bool alone : {true, false}) {
    const auto before = rays_so_far();
    EXPECT_TRUE(VisibleDomain(wide.context, vec3(0), {0, 0, 1}, radius, alone).is_disc());
    EXPECT_EQ(rays_so_far() - before, alone ? 8u : 16u);
  }
  for (const double x : {0.2, 0.8, 0.93, 0.97}) {
    const SceneContext floor(Floor{static_cast<float>(x) * radius}.scene());
    for (const bool alone : {true, false})
      for (int turn = 0; turn < 8; ++turn) {  // the frame, and with it the directions
        const float angle = static_cast<float>(turn) * pi / 64;
        const vec3 normal = glm::normalize(vec3(1e-3f * std::cos(angle), 1e-3f * std::sin(angle), 1));
        const double share = VisibleDomain(floor.context, vec3(0), normal, radius, alone).share(Kernel::box);
        EXPECT_LT(share, kept_share(x) + 0.0135) << x << " " << turn;
        EXPECT_GT(share, kept_share(x) - 0.04) << x << " " << turn;  // a polygon, in which alone photons count
      }
  }
}

// The mean of probes over a disc about a point, by 64 x 64 of them.
double probed_share(const SceneContext& stage, const SurfacePoint& point, const vec3& wo, Kernel kernel, float r,
                    const NearWalls& walls = {}) {
  const RoughMaterials rough_materials(stage.scene, 0);
  const DiscCoverage coverage(rough_materials, {kernel, true, SamplerKind::sobol}, ivec2(1), 1);
  const Bsdf bsdf(stage.scene, point);
  const GatherPoint at(point, bsdf, wo, photon_any, 64);
  double sum = 0;
  for (int i = 0; i < 64; ++i)
    for (int k = 0; k < 64; ++k) sum += coverage.probe(stage.context, at, r, (vec2(i, k) + 0.5f) / 64.0f, walls);
  return sum / (64 * 64);
}

TEST(PhotonEdges, ProbesFindTheShareOfTheDiscThatIsSurface) {
  for (const double x : {0.1, 0.2, 0.5, 0.8, 1.1}) {
    const float edge = static_cast<float>(x) * radius;
    const SceneContext floor(Floor{edge}.scene());
    const VisibleDomain domain(floor.context, vec3(0), {0, 0, 1}, radius);
    EXPECT_NEAR(probed_share(floor, origin, {0, 0, 1}, Kernel::box, radius), kept_share(x), 0.01) << x;
    for (const Kernel kernel : all_kernels)
      EXPECT_NEAR(probed_share(floor, origin, {0, 0, 1}, kernel, radius), domain.share(kernel), 0.04)
          << x;  // an edge to r / 64
  }
}

TEST(PhotonEdges, ProbesFindAWholeDiscInsideASphere) {
  SceneBuilder b("sphere");
  b.quadric(Sphere{vec3(0), 1}, b.material(Diffuse{Rgb(1)}), std::nullopt, true);
  const SceneContext sphere(b.finish());
  const SurfacePoint top{{0, 0, 1}, {0, 0, -1}, {0, 0, -1}, {1, 0, 0}, vec2(0), 0, no_id};
  for (const Kernel kernel : all_kernels) EXPECT_NEAR(probed_share(sphere, top, {0, 0, -1}, kernel, 0.3f), 1, 0.01);
}

// Half of the floor lies under a slab of glass, within what probes look at: photons lie there as well.
TEST(PhotonEdges, ProbesFindTheSurfaceUnderGlass) {
  SceneBuilder b("floor under glass");
  const auto white = b.material(Diffuse{Rgb(1)}), glass = b.material(Dielectric{.eta = 1.5f});
  b.mesh(quad({-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}), white);
  b.mesh(box({0, -2, 0.02f}, {2, 2, 0.06f}), glass);
  const SceneContext slab(b.finish());
  for (const Kernel kernel : all_kernels) EXPECT_NEAR(probed_share(slab, origin, {0, 0, 1}, kernel, radius), 1, 1e-3);
}

// A shelf so low that probes begin above it, thick or not, and a mirror or not.
TEST(PhotonEdges, ProbesFindTheFloorUnderALowShelf) {
  SurfacePoint below = origin;
  below.clearance = 1e-5f;
  for (const float thickness : {0.0f, 0.01f})
    for (const bool mirror : {false, true}) {
      SceneBuilder b("shelf");
      const auto white = b.material(Diffuse{Rgb(1)});
      b.mesh(quad({-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}), white);
      const auto shelf = mirror ? b.material(Conductor{.ideal = true}) : white;
      const float low = 0.1f * radius, high = low + thickness;
      b.mesh(thickness > 0 ? box({-1, -1, low}, {1, 1, high}) : quad({-1, -1, low}, {1, -1, low}, {1, 1, low}, {-1, 1, low}),
             shelf);
      const SceneContext stage(b.finish());
      const WallGrid grid(stage.scene, radius);
      const NearWalls walls = grid.near(vec3(0), {0, 0, 1}, radius);
      EXPECT_NEAR(probed_share(stage, below, {0, 0, 1}, Kernel::box, radius, walls), 1, 1e-3) << thickness << mirror;
    }
}

// Photons beyond a kerb that is lower than they are far count, and so does the floor there.
TEST(PhotonEdges, ProbesFindTheFloorBeyondAKerb) {
  for (const float height : {0.11f, 0.6f}) {
    SceneBuilder b("kerb");
    const auto white = b.material(Diffuse{Rgb(1)});
    b.mesh(quad({-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}), white);
    b.mesh(box({0.2f, -2, 0}, {0.201f, 2, height}), white);
    const SceneContext stage(b.finish());
    SurfacePoint before = origin;
    before.clearance = 1e-5f;
    const WallGrid grid(stage.scene, radius);
    const double share = probed_share(stage, before, {0, 0, 1}, Kernel::box, radius, grid.near(vec3(0), {0, 0, 1}, radius));
    EXPECT_NEAR(share, height < 0.2f ? 1 : kept_share(0.2 / radius), 0.01) << height;
  }
}

TEST(PhotonEdges, ProbesDoNotCountWhatStoresNoPhotons) {
  // Half of the floor is a mirror.
  SceneBuilder b("half a mirror");
  const auto white = b.material(Diffuse{Rgb(1)});
  b.mesh(quad({-2, -2, 0}, {0.001f, -2, 0}, {0.001f, 2, 0}, {-2, 2, 0}), white);
  b.mesh(quad({0.001f, -2, 0}, {2, -2, 0}, {2, 2, 0}, {0.001f, 2, 0}), b.material(Conductor{.ideal = true}));
  const SceneContext half(b.finish());
  EXPECT_NEAR(probed_share(half, origin, {0, 0, 1}, Kernel::box, radius), 0.5, 0.01);
}

// Pixels at growing distances from the floor's edge, sixteen iterations.
// A ball of radius 1 in another of radius 2, and what stands on the inner one's wall at z = -1.
NearWalls walls_in_ball(const vec3& normal, float reach, const std::optional<Material>& plate = std::nullopt,
                        bool side_test = true) {
  SceneBuilder b("balls");
  const auto white = b.material(Diffuse{Rgb(1)});
  b.quadric(Sphere{vec3(0), 1}, white);
  b.quadric(Sphere{vec3(0), 2}, white);
  if (plate) b.mesh(quad({0.05f, -1, -1}, {0.05f, 1, -1}, {0.05f, 1, 1}, {0.05f, -1, 1}), b.material(*plate));
  return WallGrid(b.finish(), reach).near({0, 0, -1}, normal, reach, side_test);
}

TEST(PhotonEdges, OnABallNothingHidesButWhatStandsThere) {
  const vec3 inside(0, 0, 1), outside(0, 0, -1);
  EXPECT_TRUE(walls_in_ball(inside, 0.3f).none());
  EXPECT_FALSE(walls_in_ball(inside, 0.3f, std::nullopt, false).none());  // what landed outside, too, may come to be looked at
  EXPECT_TRUE(walls_in_ball(outside, 0.3f).none());
  EXPECT_FALSE(walls_in_ball(outside, 0.3f, std::nullopt, false).none());
  EXPECT_FALSE(walls_in_ball(outside, 0.3f, Diffuse{Rgb(0)}).none());
  EXPECT_FALSE(walls_in_ball(outside, 1.2f).none());  // the outer one
  SceneBuilder b("ball");
  b.quadric(Sphere{vec3(0), 1}, b.material(Diffuse{Rgb(1)}));
  const Scene ball = b.finish();
  for (const float reach : {0.9f, 1.2f})  // around a smaller ball light may land on its far side, from within
    EXPECT_EQ(WallGrid(ball, reach).near({0, 0, -1}, outside, reach, true).none(), reach < 1) << reach;
  EXPECT_FALSE(walls_in_ball(inside, 0.6f).none());  // of the outer one's inside
  EXPECT_FALSE(walls_in_ball(inside, 0.3f, Diffuse{Rgb(0)}).none());
}

TEST(PhotonEdges, SmoothGlassIsNoWall) {
  const vec3 inside(0, 0, 1);
  EXPECT_TRUE(walls_in_ball(inside, 0.3f, Dielectric{.eta = 1.5f}).none());
  EXPECT_FALSE(walls_in_ball(inside, 0.3f, Dielectric{.eta = 1.5f, .alpha = 0.2f}).none());
  EXPECT_FALSE(walls_in_ball(inside, 0.3f, Dielectric{.eta = 1.5f, .transmit_tint = Rgb(0.5f)}).none());
  EXPECT_FALSE(walls_in_ball(inside, 0.3f, Conductor{.ideal = true}).none());
}

TEST(PhotonEdges, DiscsAreMeasuredWhereAProbeFoundOneCutAndElsewhereHardlyTried) {
  const float edge = 0.5f * radius;
  const SceneContext floor(Floor{edge}.scene());
  const RoughMaterials rough_materials(floor.scene, 0);
  const ivec2 resolution(64, 4);
  DiscCoverage coverage(rough_materials, {Kernel::box, true, SamplerKind::sobol}, resolution, 256);
  const Bsdf bsdf(floor.scene, origin);
  const auto at_pixel = [&](const ivec2& pixel) {
    SurfacePoint point = origin;
    point.position.x = edge - 0.5f * radius - 0.02f * static_cast<float>(pixel.x);
    return GatherPoint(point, bsdf, {0, 0, 1}, photon_any, 64);
  };
  std::vector<DiscCoverage::Disc> discs;
  for (int y = 0; y < resolution.y; ++y)
    for (int x = 0; x < resolution.x; ++x)
      discs.push_back({static_cast<std::size_t>(y) * resolution.x + x, {x, y}, at_pixel({x, y}), radius, 1});
  reset_counters();
  for (std::uint32_t iteration = 0; iteration < 16; ++iteration) coverage.measure(floor.context, {}, iteration, discs);
  const auto rays = read_counters()[static_cast<std::size_t>(Counter::rays)];
  EXPECT_NEAR(coverage.correction(0), 1 / kept_share(0.5), 0.05);
  EXPECT_EQ(coverage.correction(63), 1) << "whole, and never measured";
  // Discs are cut up to the 12th pixel, so that five blocks of 16 are measured; the others have two probes each.
  EXPECT_LT(rays, 6 * 16 * 16 * 5 + 11 * 16 * 2);
  EXPECT_GT(rays, 12 * 4 * 31);
}

}  // namespace
}  // namespace etendue
