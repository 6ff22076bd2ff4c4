// The places where methods fail along the parameter of a scene, against theory: a failure map draws these predictions.
#include "experiments/kinds/stress/stress_figures.h"
#include "experiments/run/closed_form.h"
#include "tests/render_scene.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::render;
using testing::RenderOptions;

struct Hazard {
  const char* scene;
  const char* method;
  ParamMap params;
  std::uint32_t iterations;
  const char* figure;
  double expected, tolerance;
  int seeds = 2;
};

ParamValue text(const char* value) { return {std::string(value), {}}; }

ParamMap independent(ParamMap params = {}) {
  params["sampler"] = text("independent");
  return params;
}

// A box kernel of fixed radius, of photons that are counts of independent events.
ParamMap photons(double radius, ParamMap params = {}) {
  params["k"] = {std::int64_t{0}, {}};
  params["radius"] = {radius, {}};
  params["kernel"] = text("box");
  params["photons"] = {std::int64_t{1}, {}};
  params["caustic_photons"] = {std::int64_t{200'000}, {}};
  return independent(std::move(params));
}

void expect_figure(const Hazard& h) {
  const Scene scene = load_scene(h.scene);
  RenderOptions options;
  options.params = h.params;
  options.iterations = h.iterations;
  const Image exact = integrate_closed_form(scene, options.resolution);
  double mean = 0;
  for (int seed = 1; seed <= h.seeds; ++seed) {
    options.seed = static_cast<std::uint64_t>(seed);
    mean += find_stress_figure(h.figure, {}).compute(render(scene, h.method, options).image, exact) / h.seeds;
  }
  ::testing::Test::RecordProperty(h.scene, std::to_string(mean));
  EXPECT_NEAR(mean, h.expected, h.tolerance) << h.scene << " " << h.method << " " << h.figure;
}

// A ball of radius r about a point of the plate's underside cuts a disc of radius sqrt(r^2 - t^2) out of its top.
TEST(Hazards, PlatesLeakTheDiscThatTheKernelCuts) {
  constexpr double sun_over_glow = 15.87;
  for (const double thickness : {0.09, 0.075})
    expect_figure({thickness == 0.09 ? "builtin:thin-plate?thickness=0.09" : "builtin:thin-plate?thickness=0.075", "photon-map",
                   photons(0.1, {{"side_test", {false, {}}}}), 1, "middle",
                   1 + sun_over_glow * (1 - thickness * thickness / 0.01), 0.2});
}

// Per metre of border, 2 r / (3 pi) of the light is lost.
TEST(Hazards, BordersDarkenByTheirLength) {
  expect_figure({"builtin:edge?size=1", "photon-map", photons(0.1), 1, "bias", -4 * 2 * 0.1 / (3 * pi), 0.01});
}

TEST(Hazards, BallsDarkenByTheCapsMeanCosine) {
  expect_figure({"builtin:sunlit-ball?radius=0.2236", "photon-map", photons(0.1), 1, "middle", 0.95, 0.01});
  expect_figure({"builtin:sunlit-ball?radius=0.1", "photon-map", photons(0.1), 1, "middle", 0.75, 0.015});
}

// The photons in a kernel are a Poisson count, and fall with the area of the scene's bounding sphere's disc.
TEST(Hazards, DilutedPhotonsScatterAsTheirCount) {
  const auto count = [](double x) { return 200'000 * 0.0025 / (2 * x * x + 0.5625); };
  expect_figure(
      {"builtin:sunlit-field?surroundings=4", "photon-map", photons(0.05), 1, "relmse", 1 / count(4), 0.2 / count(4), 4});
  expect_figure(
      {"builtin:sunlit-field?surroundings=16", "photon-map", photons(0.05), 1, "relmse", 1 / count(16), 0.2 / count(16), 4});
}

TEST(Hazards, NarrowLobesScatterPhotonsByTheirSolidAngle) {
  constexpr double in_kernel = 200'000 / 16 * 0.01, cos2 = 0.604;
  expect_figure({"builtin:glossy-furnace?alpha=0.05", "photon-map", photons(0.1, {{"carry_below", {0.0, {}}}}), 1, "relmse",
                 1 / (12 * 0.0025 * cos2 * in_kernel), 0.1, 4});
}

// The relative variance of (k - 1) / (pi r_k^2) is 1 / (k - 2).
TEST(Hazards, FewNearestPhotonsScatterAsTheirNumber) {
  ParamMap params = photons(0);
  params["k"] = {std::int64_t{10}, {}};
  expect_figure({"builtin:sunlit-field", "photon-map", params, 1, "relmse", 1.0 / 8, 0.02});
}

// With the chance p = (a/d)^2 cos to find a lamp of radius a, n samples have a relative variance of (1 - p) / (n p): the mean
// over this view is 0.00514 a^-2 at 256 samples.
TEST(Hazards, SmallLampsBehindGlassScatterAsTheirSolidAngle) {
  expect_figure({"builtin:veiled-lamp?radius=0.2", "path", independent(), 64, "relmse", 4 * 0.1256, 0.06});
  expect_figure({"builtin:veiled-lamp?radius=0.1", "path", independent(), 64, "relmse", 4 * 0.514, 0.35});
}

TEST(Hazards, SmallLampsBehindGlassLookCalmOnceNothingFindsThem) {
  for (const char* method : {"path", "guided"})
    expect_figure({"builtin:veiled-lamp?radius=0.0005", method, {}, 4, "bias", -1, 1e-6, 1});
  for (const char* method : {"hash-cache", "irradiance-cache", "radiance-cache"})
    expect_figure({"builtin:veiled-lamp?radius=0.0005", method, {{"caustic_map", text("off")}}, 4, "bias", -1, 1e-6, 1});
  for (const char* method : {"sppm", "photon-map"})
    expect_figure({"builtin:veiled-lamp?radius=0.0005", method, {}, 4, "bias", 0, 0.03, 1});
}

// So few are chosen by power.
TEST(Hazards, LampsThatLightNothingScatterAsTheirNumber) {
  expect_figure({"builtin:many-lamps?lamps=3", "path", independent({{"lights", text("power")}}), 16, "relmse", 2.0 / 16, 0.02});
  expect_figure({"builtin:many-lamps?lamps=8", "path", independent({{"lights", text("power")}}), 16, "relmse", 7.0 / 16, 0.05});
}

// With q = 4 alpha^2 cos / size^2, directions of the lobe have a relative variance of q, points of the lamp one of
// (1 + q)^2 / (3 q) - 1, and either is mended by the other.
TEST(Hazards, LampsInRoughMirrorsAskForOneStrategyOrTheOther) {
  const auto by = [](const char* strategy) { return independent({{"mis", text(strategy)}}); };
  const auto q = [](double alpha, double size) { return 4 * alpha * alpha * std::sqrt(0.5) / (size * size); };
  const double small = q(0.1, 0.01), wide = q(0.01, 0.1);
  expect_figure(
      {"builtin:glossy-lamp?alpha=0.1,size=0.01", "path", by("bsdf"), 16, "relmse", small / 16, 0.15 * small / 16, 4});
  expect_figure({"builtin:glossy-lamp?alpha=0.01,size=0.1", "path", by("light"), 16, "relmse",
                 (square(1 + wide) / (3 * wide) - 1) / 16, 0.15, 4});
  expect_figure({"builtin:glossy-lamp?alpha=0.1,size=0.01", "path", by("power"), 16, "relmse", 0, 0.02});
  expect_figure({"builtin:glossy-lamp?alpha=0.01,size=0.1", "path", by("power"), 16, "relmse", 0, 0.02});
}

// Paths end after 64 events.
TEST(Hazards, WhiteRoomsAreTruncated) {
  expect_figure({"builtin:furnace?albedo=0.97", "path", {}, 16, "bias", -std::pow(0.97, 65), 0.01});
  expect_figure({"builtin:lambert-sphere?albedo=0.97", "light-trace", {}, 16, "bias", -std::pow(0.97, 64), 0.01});
}

// A floor seen from above is left from 16 clearances of 6 / 2^24 of the distance above it, less the camera's slant.
TEST(Hazards, FarFromTheOriginShadowsOfLowThingsShrink) {
  for (const int distance : {370, 3000}) {
    const double clearance = 6 * 0x1p-24 * distance, seen = 0.828;
    expect_figure({distance == 370 ? "builtin:far-kerb?distance=370" : "builtin:far-kerb?distance=3000",
                   "path",
                   {},
                   16,
                   "bias",
                   0.97 * 16 * clearance / 0.05 / seen,
                   0.05 * 0.97 * 16 * clearance / 0.05 / seen,
                   1});
  }
}

}  // namespace
}  // namespace etendue
