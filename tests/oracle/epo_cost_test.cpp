// End-point overlap against cases worked out by hand, and the sample against the whole.
#include "accel/bvh/build/epo_cost.h"

#include "accel/bvh/build/binned_sah.h"
#include "accel/bvh/build/median.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

namespace etendue::testing {
namespace {

// Right triangles with legs of 2 along x and y in the plane z = 0, from (x, 0).
Geometry triangles_at(std::initializer_list<float> xs) {
  Geometry g;
  for (const float x : xs) add_triangle(g, {x, 0, 0}, {x + 2, 0, 0}, {x, 2, 0});
  return g;
}

Bounds box_of(const Geometry& g, std::initializer_list<std::uint32_t> ids) {
  Bounds b;
  for (const std::uint32_t id : ids) b.extend(g.primitive_bounds(id));
  return b;
}

TEST(EpoCost, TwoOverlappingTrianglesCountTheirPartsInEachOthersBox) {
  const Geometry g = triangles_at({0, 1});
  const BinaryTree tree{{{box_of(g, {0, 1}), 1, 0}, {box_of(g, {0}), 0, 1}, {box_of(g, {1}), 1, 1}}, {0, 1}, 1};
  // Beyond x = 1 the first triangle has legs of 1, area 1/2. Up to x = 2 lies all of the second's area of 2 but legs of 1. The
  // whole area is 4.
  const EpoCost cost = epo_cost(tree, g, 1000);
  EXPECT_DOUBLE_EQ(cost.value, (0.5 + 1.5) / 4);
  EXPECT_EQ(cost.triangles, 2u);
  EXPECT_FALSE(cost.sampled);
}

TEST(EpoCost, LeavesWeighByTheirPrimitivesAndInnerNodesByOne) {
  const Geometry g = triangles_at({0, 1, 10, 11});
  // Badly built: 0 and 10 in one leaf, 1 and 11 below an inner node. Boxes: [0, 12] for the leaf, [1, 13] for the node.
  const BinaryTree tree{{{box_of(g, {0, 1, 2, 3}), 1, 0},
                         {box_of(g, {0, 2}), 0, 2},
                         {box_of(g, {1, 3}), 3, 0},
                         {box_of(g, {1}), 2, 1},
                         {box_of(g, {3}), 3, 1}},
                        {0, 2, 1, 3},
                        2};
  const double in_leaf = 2 * (2 + 1.5);  // 1 whole, 11 up to x = 12; two primitives
  const double in_inner = 0.5 + 2;       // 0 from x = 1 on, 10 whole
  const double in_1 = 0.5, in_11 = 0.5;  // 0 within [1, 3], 10 within [11, 13]
  EXPECT_DOUBLE_EQ(epo_cost(tree, g, 1000).value, (in_leaf + in_inner + in_1 + in_11) / 8);
}

TEST(EpoCost, PrimitiveListedOnBothSidesIsForeignToNeither) {
  const Geometry g = triangles_at({0});
  const BinaryTree tree{
      {{{{0, 0, 0}, {2, 2, 0}}, 1, 0}, {{{0, 0, 0}, {1, 2, 0}}, 0, 1}, {{{1, 0, 0}, {2, 2, 0}}, 1, 1}}, {0, 0}, 1};
  EXPECT_EQ(epo_cost(tree, g, 1000).value, 0);
}

TEST(EpoCost, NothingCostsNothing) {
  EXPECT_EQ(epo_cost({}, {}, 10).value, 0);
  Geometry spheres;
  spheres.quadrics.push_back(Sphere{{0, 0, 0}, 1});
  EXPECT_EQ(epo_cost(build_median(build_items(spheres), {}), spheres, 10).value, 0);
}

TEST(EpoCost, SampleComesNearTheWholeAndIsRepeatable) {
  const Geometry g = closed_sphere(60, 120);
  const BinaryTree tree = build_binned_sah(build_items(g), {});
  const EpoCost whole = epo_cost(tree, g, 1u << 30), sample = epo_cost(tree, g, 2000);
  EXPECT_FALSE(whole.sampled);
  EXPECT_TRUE(sample.sampled);
  EXPECT_EQ(sample.triangles, 2000u);
  EXPECT_GT(whole.value, 0);
  EXPECT_NEAR(sample.value, whole.value, 0.05 * whole.value);
  EXPECT_EQ(epo_cost(tree, g, 2000).value, sample.value);
}

}  // namespace
}  // namespace etendue::testing
