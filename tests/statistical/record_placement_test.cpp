// Placement of an irradiance cache's records, and how far they serve, when it is filled to a number or row by row.
#include "framework/core/error.h"
#include "tests/render_scene.h"
#include "tests/scene_context.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::SceneContext;

ParamMap cheap(std::int64_t records) {
  return {{"records", {records, {}}},
          {"refine", {false, {}}},
          {"samples", {std::int64_t{64}, {}}},
          {"neighbour_clamping", {false, {}}},
          {"cache_direct", {true, {}}}};
}

std::vector<RecordShape> discs_of(const ParamMap& params, int threads = 1) {
  SceneContext scene(load_scene("builtin:glowing-room"), {48, 48});
  const auto integrator = find_integrator("irradiance-cache", {}).make(params);
  with_threads(threads, [&] { integrator->prepare(scene.context); });
  return integrator->cache()->record_shapes();
}

TEST(RecordPlacement, SpacingsHoldAtTheAccuracyThatIsFound) {
  SceneContext scene(load_scene("builtin:glowing-room"), {48, 48});
  const float diagonal = glm::length(scene.context.scene.bounds().diagonal());
  ParamMap params = cheap(400);
  params["min_spacing"] = {0.0, {}};
  const auto farthest = [&](double spacing) {
    params["max_spacing"] = {spacing, {}};
    float radius = 0;
    for (const RecordShape& disc : discs_of(params)) radius = std::max(radius, disc.radius);
    return radius / diagonal;
  };
  EXPECT_GT(farthest(1), 0.08f);
  EXPECT_NEAR(farthest(0.06), 0.06f, 1e-4f);
}

// Records that few rays show light get more rays first; where light is easy to find they lie as close as the schedule has them.
TEST(RecordPlacement, RecordsStayCoarseWhereTheirNoiseIsMostOfTheError) {
  const auto discs_in = [](const char* name, const ParamMap& params, int threads) {
    SceneContext scene(load_scene(name), {64, 64});
    const auto integrator = find_integrator("irradiance-cache", {}).make(params);
    Film film({64, 64});
    with_threads(threads, [&] {
      integrator->prepare(scene.context);
      for (std::uint32_t i = 0; i < 8; ++i) integrator->iteration(scene.context, i, film);
    });
    return integrator->cache()->record_shapes();
  };
  const ParamMap full{{"refine", {false, {}}}, {"accuracy", {0.4, {}}}};
  const std::vector<RecordShape> rare = discs_in("builtin:keyhole", {}, 1), threads = discs_in("builtin:keyhole", {}, 3);
  EXPECT_LT(rare.size(), 0.6 * static_cast<double>(discs_in("builtin:keyhole", full, 2).size()));
  EXPECT_EQ(discs_in("builtin:cornell-box", {}, 2).size(), discs_in("builtin:cornell-box", full, 2).size());
  ASSERT_EQ(threads.size(), rare.size());
  for (std::size_t i = 0; i < rare.size(); ++i) EXPECT_EQ(threads[i].position, rare[i].position);
}

TEST(RecordPlacement, RowByRowEachRecordLiesOutsideThoseBefore) {
  ParamMap params = cheap(150);
  params["overture"] = {false, {}};
  const auto outside = [](const std::vector<RecordShape>& discs) {
    std::size_t served = 0;
    for (std::size_t i = 0; i < discs.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        served += glm::dot(discs[i].normal, discs[j].normal) > 0.999f &&
                  std::abs(glm::dot(discs[i].position - discs[j].position, discs[j].normal)) < 1e-3f &&
                  glm::length(discs[i].position - discs[j].position) < 0.999f * discs[j].radius;
    return served;
  };
  const std::vector<RecordShape> rows = discs_of(params);
  EXPECT_GE(rows.size(), 147u);
  EXPECT_EQ(outside(rows), 0u);
  const std::vector<RecordShape> threads = discs_of(params, 3);
  ASSERT_EQ(threads.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(threads[i].position, rows[i].position);
  EXPECT_GT(outside(discs_of(cheap(150))), 0u) << "records of one batch do not see each other";
}

TEST(RecordPlacement, ExactValuesAreJudgedAsNoisyOnesAre) {
  ParamMap params = cheap(150);
  params["metric"] = {std::string("split-sphere"), {}};
  params["fill"] = {std::string("paths"), {}};
  const std::vector<RecordShape> noisy = discs_of(params);
  params["fill"] = {std::string("exact-values"), {}};
  const std::vector<RecordShape> exact = discs_of(params);
  ASSERT_EQ(exact.size(), noisy.size());
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_EQ(exact[i].position, noisy[i].position);
    EXPECT_EQ(exact[i].radius, noisy[i].radius);
  }

  // The light is smooth, so that pixels' edges are no error.
  testing::RenderOptions options{.params = params, .iterations = 4};
  const Scene scene = load_scene("builtin:broad-light?veil=false");
  const Image reference = testing::exact_image(scene, options.resolution);
  const double of_places = relmse(testing::render(scene, "irradiance-cache", options).image, reference);
  options.params["fill"] = {std::string("paths"), {}};
  EXPECT_GT(relmse(testing::render(scene, "irradiance-cache", options).image, reference), 2 * of_places);
  const testing::RenderOptions refused{.params = params};
  EXPECT_THROW(testing::render(load_scene("builtin:cornell-spheres"), "irradiance-cache", refused), Error);
}

}  // namespace
}  // namespace etendue
