// Emission where photons matter: the same light as emission by power, on more photons.
#include "framework/scene/builder.h"
#include "integrators/photons/emission/visible_region.h"
#include "tests/scene_context.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

constexpr PhotonEmission emissions[] = {PhotonEmission::power, PhotonEmission::importance, PhotonEmission::visibility};

// Sun, or sun and sky, over 100 m x 100 m of ground; what matters is a square of 2 m.
Scene wide_ground(bool sky) {
  SceneBuilder builder("wide ground");
  builder.mesh(quad({-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0}), builder.material(Diffuse{Rgb(0.5f)}));
  builder.light(DirectionalLight{glm::normalize(vec3(1, 0, -1)), Rgb(3)});
  if (sky) builder.light(EnvironmentLight{.scale = Rgb(1), .size = {}, .texels = {}, .light_to_world = {}});
  return builder.finish();
}

// A lamp in a closed box with a hole of 4 cm in its floor, over a table: light comes out straight, and by many bounces.
Scene lamp_in_a_box() {
  SceneBuilder builder("lamp in a box");
  const auto white = builder.material(Diffuse{Rgb(0.5f)});
  builder.mesh(quad({-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}), white);
  const float hole = 0.02f;
  for (const float s : {-1.0f, 1.0f}) {
    builder.mesh(quad({s, -1, 1}, {s, 1, 1}, {s, 1, 3}, {s, -1, 3}), white);
    builder.mesh(quad({-1, s, 1}, {1, s, 1}, {1, s, 3}, {-1, s, 3}), white);
    builder.mesh(quad({-1, s, 1}, {1, s, 1}, {1, s * hole, 1}, {-1, s * hole, 1}), white);
    builder.mesh(quad({s, -hole, 1}, {s, hole, 1}, {s * hole, hole, 1}, {s * hole, -hole, 1}), white);
  }
  builder.mesh(quad({-1, -1, 3}, {1, -1, 3}, {1, 1, 3}, {-1, 1, 3}), white);
  builder.light(PointLight{{0.2f, 0.1f, 2}, Rgb(5)});
  return builder.finish();
}

struct EmissionTrial {
  const Scene& scene;
  const VisibleRegion& region;
  std::uint32_t count = 20000;
  int threads = 2;

  Photons photons(PhotonEmission emission, std::uint64_t key) const {
    const testing::SceneContext traced(scene, {8, 8}, 7);
    Photons photons;
    with_threads(threads, [&] {
      photons = trace_photons(traced.context, RoughMaterials(scene, 0.25f),
                              {.count = count, .key = key, .max_scatterings = 20, .emission = emission, .visible = &region});
    });
    return photons;
  }
};

// Holds what lands within the region over several passes: power, its standard error, and as how many photons of equal power.
struct Landed {
  double power = 0, error = 0, photons = 0;
};

Landed landed(const EmissionTrial& trial, PhotonEmission emission, int passes) {
  double sum = 0, squares = 0, photons = 0;
  for (int pass = 0; pass < passes; ++pass) {
    const Photons traced = trial.photons(emission, static_cast<std::uint64_t>(pass));
    double power = 0, power_squares = 0;
    for (std::size_t i = 0; i < traced.size(); ++i)
      if (trial.region.contains(traced.position[i], traced.side[i].normal())) {
        power += traced.power[i].x;
        power_squares += square(traced.power[i].x);
      }
    sum += power;
    squares += power * power;
    if (power > 0) photons += power * power / power_squares;
  }
  const double mean = sum / passes;
  return {mean, std::sqrt(std::max(0.0, squares / passes - mean * mean) / (passes - 1)), photons / passes};
}

TEST(VisibleRegion, ContainsAllOfEachBallItWasMarkedWith) {
  const vec3 up(0, 0, 1);
  VisibleRegion region({{-1, 0, 2}, {3, 1, 2}}, 0.1f);
  EXPECT_FALSE(region.contains({0, 0.5f, 2}, up));
  region.mark({0, 0.5f, 2}, 0.1f);
  Pcg32 random(3, 3);
  for (int i = 0; i < 1000; ++i) {
    const vec3 d = 2.0f * vec3(random.next_float(), random.next_float(), random.next_float()) - 1.0f;
    if (glm::length(d) <= 1) {
      EXPECT_TRUE(region.contains(vec3(0, 0.5f, 2) + 0.1f * d, up));
    }
  }
  EXPECT_FALSE(region.contains({0.3f, 0.5f, 2}, up));
  EXPECT_LT(region.share(), 0.05);
  region.mark({90, 90, 90}, 1);
  EXPECT_TRUE(region.contains({3, 1, 2}, up)) << "what lies outside counts to the nearest cell";
}

TEST(VisibleRegion, KnowsWhichSideOfAWallMatters) {
  VisibleRegion region({{-1, -1, -1}, {1, 1, 1}}, 0.1f);
  Pcg32 random(8, 8);
  const auto direction = [&] {
    const float x = random.next_float(), y = random.next_float();
    return glm::normalize(vec3(x, y, random.next_float()) - 0.5f);
  };
  for (int i = 0; i < 200; ++i) {
    const vec3 normal = direction(), at = 0.9f * direction();
    VisibleRegion one({{-1, -1, -1}, {1, 1, 1}}, 0.5f);
    one.mark(at, 0.1f, normal);
    for (int j = 0; j < 50; ++j)
      if (const vec3 photon = direction(); glm::dot(photon, normal) >= 0.1f) {
        EXPECT_TRUE(one.contains(at, photon));
      }
  }
  region.mark(vec3(0), 0.1f, {0, 0, 1});
  EXPECT_FALSE(region.contains(vec3(0), {0, 0, -1}));
}

TEST(PhotonEmission, WideGroundGetsTheLightOfItsPartThatMatters) {
  // The sky's irradiance is pi on either side, the sun's 3 / sqrt 2.
  for (const bool sky : {false, true}) {
    const Scene scene = wide_ground(sky);
    VisibleRegion region(scene.bounds(), 1);
    region.mark({10.2f, 5.2f, 0}, 0.9f);
    int inside = 0;  // of a lattice of 0.1 m
    for (int i = 0; i < 1000000; ++i)
      inside += region.contains({0.1f * static_cast<float>(i % 1000) - 49.95f, 0.1f * static_cast<float>(i / 1000) - 49.95f, 0},
                                {0, 0, 1});
    const double expected = inside * 0.01 * (3 / std::numbers::sqrt2 + (sky ? 2 * std::numbers::pi : 0));
    const EmissionTrial trial{scene, region, 60000};
    const double by_power = landed(trial, PhotonEmission::power, 8).photons;
    for (const PhotonEmission emission : emissions) {
      const Landed l = landed(trial, emission, 8);
      EXPECT_NEAR(l.power, expected, 4.5 * l.error + 0.03 * expected) << sky << static_cast<int>(emission);
      if (emission == PhotonEmission::visibility) {
        EXPECT_GT(l.photons, 50 * by_power) << sky;
      }
      if (emission == PhotonEmission::importance) {
        EXPECT_GT(l.photons, (sky ? 1 : 4) * by_power) << sky;
      }
    }
  }
}

// Both halves of each number that a photon is emitted by are as useful as each other then.
TEST(PhotonEmission, ImportanceFindsWhatLiesInTheMiddle) {
  const Scene scene = wide_ground(false);
  VisibleRegion region(scene.bounds(), 1);
  region.mark({0, 0, 0}, 7);
  const EmissionTrial trial{scene, region, 60000};
  EXPECT_GT(landed(trial, PhotonEmission::importance, 4).photons, 4 * landed(trial, PhotonEmission::power, 4).photons);
}

TEST(PhotonEmission, AHoleLetsTheSameLightThrough) {
  const Scene scene = lamp_in_a_box();
  VisibleRegion region(scene.bounds(), 0.1f);
  for (int i = 0; i < 441; ++i)
    region.mark({-1.9f + 0.19f * static_cast<float>(i % 21), -1.9f + 0.19f * static_cast<float>(i / 21), 0}, 0.1f);
  const Landed expected = landed({scene, region, 200000}, PhotonEmission::power, 4);
  const EmissionTrial trial{scene, region, 20000};
  const double by_power = expected.photons / 10;
  for (const PhotonEmission emission : {PhotonEmission::importance, PhotonEmission::visibility}) {
    const Landed l = landed(trial, emission, 12);
    EXPECT_NEAR(l.power, expected.power, 4.5 * std::hypot(l.error, expected.error)) << static_cast<int>(emission);
    // Light that comes by way of the walls cannot be guided at emission.
    EXPECT_GT(l.photons, (emission == PhotonEmission::visibility ? 8 : 0.7) * by_power) << static_cast<int>(emission);
  }
}

TEST(PhotonEmission, SamePhotonsAtAnyThreadCount) {
  const Scene scene = lamp_in_a_box();
  VisibleRegion region(scene.bounds(), 0.1f);
  region.mark(vec3(0), 1);
  for (const PhotonEmission emission : {PhotonEmission::importance, PhotonEmission::visibility}) {
    const Photons one = EmissionTrial{scene, region, 30000, 1}.photons(emission, 2);
    EXPECT_GT(one.size(), 100u);
    EXPECT_TRUE(one == (EmissionTrial{scene, region, 30000, 2}.photons(emission, 2)));
    EXPECT_TRUE(one == (EmissionTrial{scene, region, 30000, 3}.photons(emission, 2)));
  }
}

TEST(PhotonEmission, NoPhotonWhereNoneIsVisible) {
  const Scene scene = wide_ground(true);
  VisibleRegion region(scene.bounds(), 1);
  EXPECT_TRUE((EmissionTrial{scene, region, 5000}.photons(PhotonEmission::visibility, 0).empty()));
  EXPECT_GT((EmissionTrial{scene, region, 5000}.photons(PhotonEmission::importance, 0).size()), 100u);
}

}  // namespace
}  // namespace etendue
