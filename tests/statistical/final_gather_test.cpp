// Final gathering: directions from photons, and irradiance computed once.
#include "integrators/photons/final_gather.h"
#include "framework/core/parallel.h"
#include "framework/scene/builder.h"
#include "integrators/paths/path.h"
#include "integrators/photons/incident_directions.h"
#include "integrators/photons/photon_camera_path.h"
#include "tests/render_scene.h"
#include "tests/scene_context.h"
#include "tests/white_plane.h"

#include <gtest/gtest.h>

#include <atomic>

namespace etendue {
namespace {

using testing::exact_image;
using testing::origin;
using testing::render;
using testing::RenderOptions;
using testing::SceneContext;
using testing::white_plane;

TEST(IncidentDirections, DensityIntegratesToOneAndIsTheOneThatIsSampled) {
  const SceneContext plane(white_plane());
  Pcg32 random(6, 6);
  Photons photons;
  for (int i = 0; i < 60; ++i) {  // from about a direction, one in four from anywhere
    vec3 from(0.8f, 0.1f, 0.5f);
    if (i % 4 == 0) from = vec3(2 * random.next_float() - 1, 2 * random.next_float() - 1, 0.3f);
    from += 0.2f * vec3(random.next_float(), random.next_float(), random.next_float());
    photons.add({random.next_float(), random.next_float(), 0}, Rgb(1 + random.next_float()), glm::normalize(from), 1, {0, 0, 1},
                photon_indirect, 1);
  }
  photons.add(vec3(0), Rgb(1e6f), {0, 0, 1}, 1, {0, 0, 1}, photon_direct, 0);
  PhotonMap map;
  map.build(std::move(photons), find_point_structure("brute", {}).make(), {.k = 50, .radius = 10});
  const Bsdf bsdf(plane.scene, origin);
  const IncidentDirections directions(map, GatherPoint(origin, bsdf, {0, 0, 1}, photon_indirect, 64), 64);
  ASSERT_FALSE(directions.empty());

  // E[1 / pdf] over the samples is the solid angle of the density's support, and E[g / pdf] the integral of g over it.
  constexpr int n = 400000;
  double integral = 0, over_samples = 0, over_support = 0;
  for (int i = 0; i < n; ++i) {
    const float z = random.next_float(), phi = 2 * pi * random.next_float(), r = safe_sqrt(1 - z * z);
    const vec3 uniform(r * std::cos(phi), r * std::sin(phi), z);
    const float pdf = directions.pdf_solid_angle(uniform);
    integral += 2 * pi * pdf / n;
    if (pdf > 0) over_support += 2 * pi * square(uniform.x) * uniform.z / n;
    const vec3 sampled = directions.sample({random.next_float(), random.next_float()});
    ASSERT_GT(directions.pdf_solid_angle(sampled), 0);
    over_samples += square(sampled.x) * sampled.z / directions.pdf_solid_angle(sampled) / n;
  }
  EXPECT_NEAR(integral, 1, 0.02);
  EXPECT_NEAR(over_samples / over_support, 1, 0.02);
  EXPECT_EQ(directions.pdf_solid_angle({0, 0, -1}), 0);
}

RenderOptions gathering(std::initializer_list<std::pair<const char*, decltype(ParamValue::value)>> more) {
  RenderOptions options;
  options.resolution = {16, 16};
  options.params = {{"photons", {std::int64_t{20000}, {}}}, {"final_gather", {std::int64_t{8}, {}}}};
  for (const auto& [name, value] : more) options.params[name] = {value, {}};
  options.iterations = 8;
  return options;
}

double relative_difference(const Image& a, const Image& b) {
  double difference = 0, sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    difference += a.pixels[i].y - b.pixels[i].y;
    sum += b.pixels[i].y;
  }
  return difference / sum;
}

TEST(FinalGathering, DirectionsFromPhotonsGiveTheSameLightWithLessVariance) {
  const SceneContext box(load_scene("builtin:cornell-box"), {6, 6});
  const RoughMaterials rough_materials(box.scene, 0.25f);
  PhotonMap map;
  map.build(trace_photons(box.context, rough_materials, {.count = 30000, .key = 1, .max_scatterings = 20}),
            find_point_structure("kd-tree", {}).make(), {.k = 50});
  struct Sums {
    double mean = 0, mean_variance = 0, variance = 0;
  } of[2];
  constexpr int rays = 300;
  for (int pixel = 0; pixel < 36; ++pixel)
    for (const bool by_photons : {false, true}) {
      Sampler path(SamplerKind::sobol, 1, Stream::camera, static_cast<std::uint64_t>(pixel), 0), light = path;
      const Ray ray = sample_camera_ray(box.context, {pixel % 6, pixel / 6}, path);
      PhotonCameraPath{box.context, rough_materials, 20}(
          ray, path, light, [&](const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, const Rgb&, int depth, float) {
            const FinalGather gather{box.context, rough_materials,         map, nullptr, 1, 20, by_photons,
                                     false,       SamplerKind::independent};
            double sum = 0, squares = 0;
            for (std::uint32_t i = 0; i < rays; ++i) {
              const double l = gather(point, bsdf, wo, depth, static_cast<std::uint64_t>(pixel), i).y;
              sum += l;
              squares += l * l;
            }
            const double variance = squares / rays - square(static_cast<float>(sum / rays));
            of[by_photons].mean += sum / rays;
            of[by_photons].variance += variance;
            of[by_photons].mean_variance += variance / rays;
          });
    }
  EXPECT_NEAR(of[1].mean, of[0].mean, 4.5 * std::sqrt(of[0].mean_variance + of[1].mean_variance));
  EXPECT_LT(of[1].variance, 0.75 * of[0].variance);
}

// Rays of two centimetres from just above the floor to the wall behind, where the kernel reaches below the floor.
TEST(FinalGathering, NearRaysTracedOnSeeWhatThePhotonsLoseAtAnEdge) {
  const SceneContext box(load_scene("builtin:cornell-box"));
  const RoughMaterials rough_materials(box.scene, 0.25f);
  PhotonMap map;
  map.build(trace_photons(box.context, rough_materials, {.count = 30000, .key = 1, .max_scatterings = 20}),
            find_point_structure("kd-tree", {}).make(), {.k = 50});
  constexpr int rays = 20000;
  double expected = 0, followed = 0, ended = 0;
  for (std::uint32_t i = 0; i < rays; ++i) {
    const Sampler sampler(SamplerKind::independent, 1, Stream::test, 0, i);
    const Ray ray{.origin = {0.4f + 0.4f * static_cast<float>(i) / rays, 0.02f, -0.98f}, .direction = {0, 0, -1}};
    PathSample path{ray, sampler};
    trace_paths(box.context, {&path, 1}, 1, {20, 5, MisMode::power}, false);
    expected += path.radiance.y / rays;
    for (const bool follow_near : {false, true}) {
      const FinalGather gather{box.context, rough_materials, map, nullptr, 1, 20, false, follow_near, SamplerKind::independent};
      Sampler numbers = sampler;
      (follow_near ? followed : ended) += gather.along(ray, trace(box.context, ray), 1, numbers).y / rays;
    }
  }
  EXPECT_NEAR(followed / expected, 1, 0.05);
  EXPECT_LT(ended / expected, 0.9);
}

TEST(FinalGathering, PrecomputedIrradianceKeepsTheImage) {
  const Scene scene = load_scene("builtin:cornell-box");
  const Image plain = render(scene, "photon-map", gathering({{"precompute", std::int64_t{0}}})).image;
  for (const std::int64_t every : {1, 4}) {
    const Image fast = render(scene, "photon-map", gathering({{"precompute", every}})).image;
    EXPECT_NEAR(relative_difference(fast, plain), 0, 0.01) << every;
    EXPECT_LT(relmse(fast, plain), 2e-3) << every;
  }
}

// The sun falls through an opening onto a part of the floor, where sample points lie densest. Their answers would reach far
// into the dark about it: without a bound the room was 7 % too bright.
TEST(FinalGathering, PrecomputedIrradianceOfAPatchOfSunStaysInIt) {
  SceneBuilder builder("sunlit room");
  const auto white = builder.material(Diffuse{Rgb(0.7f)});
  builder.mesh(quad({-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}), white);
  builder.mesh(quad({-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1}), white);
  builder.mesh(quad({-1, 0, -1}, {1, 0, -1}, {1, 2, -1}, {-1, 2, -1}), white);
  builder.mesh(quad({-1, 0, -1}, {-1, 2, -1}, {-1, 2, 1}, {-1, 0, 1}), white);
  builder.mesh(quad({1, 0, -1}, {1, 0, 1}, {1, 1.4f, 1}, {1, 1.4f, -1}), white);
  builder.light(DirectionalLight{glm::normalize(vec3(-0.8f, -1.2f, -0.3f)), Rgb(10)});
  builder.camera({0.2f, 1, 3.6f}, {0, 1, 0}, 45, {16, 16});
  const Scene scene = builder.finish();
  const auto seen = [&](std::int64_t precompute, std::uint64_t seed) {
    RenderOptions options = gathering({{"precompute", precompute}});
    options.seed = seed;
    return render(scene, "photon-map", options).image;
  };
  constexpr int seeds = 8;
  double difference = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) difference += relative_difference(seen(16, seed), seen(0, seed));
  EXPECT_NEAR(difference / seeds, 0, 0.02);
}

// Many threads ask for the same few values at once.
TEST(FinalGathering, IrradianceIsTheSameWhoeverAsksFirst) {
  const SceneContext box(load_scene("builtin:cornell-box"));
  const RoughMaterials rough_materials(box.scene, 0.25f);
  const auto structure = [] { return find_point_structure("kd-tree", {}).make(); };
  PhotonMap map;
  map.build(trace_photons(box.context, rough_materials, {.count = 20000, .key = 1, .max_scatterings = 20}), structure(),
            {.k = 50});
  const Photons points = trace_photons(box.context, rough_materials, {.count = 200, .key = 2, .max_scatterings = 20});
  const PhotonIrradiance early(map, points, structure()), late(map, points, structure());
  const auto ask = [&](const PhotonIrradiance& irradiance, std::size_t photon) {
    const vec3 at = map.photons().position[photon], normal = glm::normalize(map.photons().side[photon].normal());
    return irradiance.at(box.context, at, normal, at + 1e-3f * normal);
  };
  for (std::size_t i = map.photons().size(); i-- > 0;) ask(early, i);
  std::atomic<int> different{0}, found{0};
  parallel_for(map.photons().size(), 16, [&](std::size_t i) {
    const auto a = ask(early, i), b = ask(late, i);
    found += a ? 1 : 0;
    different +=
        a.has_value() != b.has_value() ||
        (a && (a->irradiance != b->irradiance || a->resolution != b->resolution || a->photon_footprint != b->photon_footprint));
  });
  EXPECT_GT(found, 1000);
  EXPECT_EQ(different, 0);
}

TEST(FinalGathering, PrecomputedIrradianceIsUnbiasedInEvenLight) {
  const Scene scene = load_scene("builtin:lambert-sphere");
  double sum = 0, squares = 0;
  constexpr int seeds = 12;
  for (int seed = 1; seed <= seeds; ++seed) {
    RenderOptions options = gathering({{"precompute", std::int64_t{4}}, {"k", std::int64_t{20}}});
    options.seed = static_cast<std::uint64_t>(seed);
    options.iterations = 1;
    const double difference = relative_difference(render(scene, "photon-map", options).image, exact_image(scene, {16, 16}));
    sum += difference;
    squares += difference * difference;
  }
  const double mean = sum / seeds;
  EXPECT_LT(std::abs(mean), 0.002 + 4.5 * std::sqrt((squares / seeds - mean * mean) / (seeds - 1)));
}

}  // namespace
}  // namespace etendue
