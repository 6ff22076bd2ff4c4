// The comparison of structures, and the arbiter it trusts: both must be able to say no.
#include "experiments/harness/accel_comparison.h"

#include "accel/ray/exact.h"
#include "framework/io/load_scene.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

namespace etendue::testing {
namespace {

Scene two_squares() {
  Geometry g;
  for (const float z : {1.0f, 2.0f}) {
    add_triangle(g, {-1, -1, z}, {1, -1, z}, {1, 1, z});
    add_triangle(g, {-1, -1, z}, {1, 1, z}, {-1, 1, z});
  }
  return scene_of(g);
}

TEST(Exact, RightAnswersAreRightAndWrongOnesAreNot) {
  const Scene scene = two_squares();
  const Ray ray{{0.5f, 0, 0}, 0, {0, 0, 1}, infinity};  // through triangle 0, then triangle 2
  const auto exact = exact_closest(scene, ray);
  ASSERT_TRUE(exact);
  EXPECT_EQ(exact->t, 1);
  EXPECT_EQ(exact->primitive, 0u);
  EXPECT_TRUE(is_right(scene, ray, {1, vec2(0), 0, 0}, exact));
  EXPECT_TRUE(is_right(scene, ray, {1 + 1e-6f, vec2(0), 0, 0}, exact));   // rounding
  EXPECT_FALSE(is_right(scene, ray, {1 + 1e-3f, vec2(0), 0, 0}, exact));  // beside the surface
  EXPECT_FALSE(is_right(scene, ray, {2, vec2(0), 0, 2}, exact));          // a surface behind another
  EXPECT_FALSE(is_right(scene, ray, {1, vec2(0), 0, 1}, exact));          // a triangle that the ray passes by
  EXPECT_FALSE(is_right(scene, ray, Hit{}, exact));
  const Ray beside{{5, 0, 0}, 0, {0, 0, 1}, infinity};
  EXPECT_FALSE(exact_closest(scene, beside));
  EXPECT_TRUE(is_right(scene, beside, Hit{}, std::nullopt));
  EXPECT_FALSE(is_right(scene, beside, {1, vec2(0), 0, 0}, std::nullopt));
}

TEST(Exact, RayThroughASharedEdgeHitsAndEitherTriangleIsRight) {
  const Scene scene = two_squares();
  const Ray ray{{0.25f, 0.25f, 0}, 0, {0, 0, 1}, infinity};
  const auto exact = exact_closest(scene, ray);
  ASSERT_TRUE(exact);
  EXPECT_TRUE(is_right(scene, ray, {1, vec2(0), 0, 0}, exact));
  EXPECT_TRUE(is_right(scene, ray, {1, vec2(0), 0, 1}, exact));
  EXPECT_FALSE(is_right(scene, ray, Hit{}, exact));
}

TEST(Exact, OcclusionIsJudgedUpToTheEndOfTheRay) {
  const Scene scene = two_squares();
  const auto until = [](float t_max) { return Ray{{0.5f, 0, 0}, 0, {0, 0, 1}, t_max}; };
  EXPECT_TRUE(is_right(scene, until(0.9f), false));
  EXPECT_FALSE(is_right(scene, until(0.9f), true));
  EXPECT_TRUE(is_right(scene, until(1.1f), true));
  EXPECT_FALSE(is_right(scene, until(1.1f), false));
  EXPECT_TRUE(is_right(scene, until(1), true));  // at the very end either will do
  EXPECT_TRUE(is_right(scene, until(1), false));
}

TEST(Exact, InstancesAreMetInWorldDistances) {
  Scene scene = two_squares();
  scene.instances.push_back({0, Transform::translate({10, 0, 0}) * Transform::scale({2, -3, 0.5f})});
  const Ray ray{{11, 0, 0}, 0, {0, 0, 0.25f}, infinity};
  const auto exact = exact_closest(scene, ray);
  ASSERT_TRUE(exact);
  EXPECT_DOUBLE_EQ(exact->t, 2);
  EXPECT_EQ(exact->instance, 1u);
  EXPECT_NEAR(exact->cos_surface, 1, 1e-12);
}

TEST(AccelComparison, StructuresAgreeOnASceneAndAreMeasured) {
  const Scene scene = load_scene("builtin:cornell-box");
  std::vector<StructureChoice> choices;
  for (const RayEntry& entry : ray_structures())
    if (entry.available) choices.push_back({entry.name, {}});
  choices.push_back({"binned-sah", {{"bins", {std::int64_t{4}, {}}}}});
  std::size_t lines = 0;
  const std::vector<StructureRecord> records =
      compare_structures(scene, choices, {.resolution = 48, .repetitions = 2, .brute_force_rays = 200},
                         [&](const std::string& line) { lines += !line.empty(); });
  ASSERT_EQ(records.size(), choices.size());
  EXPECT_GT(lines, choices.size());
  for (const StructureRecord& record : records) {
    SCOPED_TRACE(record.structure);
    EXPECT_EQ(record.disagreements, 0u);
    EXPECT_EQ(record.triangles, scene.triangle_count());
    EXPECT_GT(record.build_s, 0);
    EXPECT_GT(record.bytes, 0u);
    EXPECT_GT(record.primary_mrays_per_s, 0);
    EXPECT_GT(record.diffuse_mrays_per_s, 0);
    EXPECT_GT(record.shadow_mrays_per_s, 0);
    if (record.structure != "embree") {
      EXPECT_GT(record.primitives_per_ray, 0);
    }
  }
  EXPECT_EQ(records.back().structure, "binned-sah bins=4");
}

}  // namespace
}  // namespace etendue::testing
