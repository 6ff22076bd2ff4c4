// Trees that are no plain recursive halving: optimised by reinsertion, or cut through primitives.
#include "accel/bvh/build/binned_sah.h"
#include "accel/bvh/build/median.h"
#include "accel/bvh/build/reinsertion.h"
#include "accel/bvh/build/sbvh.h"
#include "accel/bvh/build/split_primitive.h"
#include "accel/registry.h"
#include "framework/core/parallel.h"
#include "framework/scene/builder.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

#include <cstring>

namespace etendue::testing {
namespace {

bool contains(const Bounds& outer, const Bounds& inner) { return outer.contains(inner.lower) && outer.contains(inner.upper); }

bool same(const BinaryTree& a, const BinaryTree& b) {
  return a.primitives == b.primitives && a.depth == b.depth && a.nodes.size() == b.nodes.size() &&
         std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.size() * sizeof(TreeNode)) == 0;
}

// Children follow their parent and lie in its box, depth is told, and the leaves hold all of the tree's primitives.
void expect_connected(const BinaryTree& tree) {
  std::vector<std::uint32_t> depth(tree.nodes.size(), no_id);
  std::vector<bool> held(tree.primitives.size());
  std::uint32_t deepest = 0;
  if (!depth.empty()) depth[0] = 0;
  for (std::uint32_t n = 0; n < tree.nodes.size(); ++n) {
    const TreeNode& node = tree.nodes[n];
    ASSERT_NE(depth[n], no_id) << "node " << n << " is not reached before it";
    deepest = std::max(deepest, depth[n]);
    if (node.is_leaf()) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        ASSERT_FALSE(held.at(i)) << "two leaves hold the same place";
        held[i] = true;
      }
      continue;
    }
    for (const std::uint32_t child : {node.first, node.first + 1}) {
      ASSERT_GT(child, n);
      ASSERT_LT(child, tree.nodes.size());
      ASSERT_EQ(depth[child], no_id) << "node " << child << " has two parents";
      EXPECT_TRUE(contains(node.bounds, tree.nodes[child].bounds));
      depth[child] = depth[n] + 1;
    }
  }
  EXPECT_EQ(deepest, tree.depth);
  EXPECT_EQ(std::count(held.begin(), held.end(), false), 0);
}

std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> ids) {
  std::sort(ids.begin(), ids.end());
  return ids;
}

// Small triangles crossed by a few long slivers, whose boxes overlap everything: what no cut between primitives can part.
Geometry crossed_clutter(int count, std::uint64_t seed) {
  Random random(seed);
  Geometry g;
  for (int i = 0; i < count; ++i) {
    const vec3 from = random.in_cube(1);
    if (i % 20 == 0)
      add_triangle(g, from, random.in_cube(1), from + random.in_cube(0.01f));
    else
      add_triangle(g, from, from + random.in_cube(0.03f), from + random.in_cube(0.03f));
  }
  return g;
}

TEST(Reinsertion, KeepsEveryLeafAndLowersTheCost) {
  for (const RayCase& c : ray_cases()) {
    SCOPED_TRACE(c.name);
    const auto items = build_items(c.scene.objects[0].geometry);
    const BinaryTree before = build_median(items, {});
    BinaryTree after = before;
    reinsert_subtrees(after, 20);
    expect_connected(after);
    EXPECT_EQ(after.nodes.size(), before.nodes.size());
    EXPECT_EQ(sorted(after.primitives), sorted(before.primitives));
    EXPECT_LE(after.sah_cost(), before.sah_cost() * (1 + 1e-6));
  }
}

TEST(Reinsertion, MendsATreeOfMediansByATenthAtLeast) {
  const auto items = build_items(crossed_clutter(3000, 1));
  BinaryTree tree = build_median(items, {});
  const double before = tree.sah_cost();
  reinsert_subtrees(tree, 20);
  EXPECT_LT(tree.sah_cost(), 0.9 * before);
}

TEST(Reinsertion, TreeDoesNotDependOnThreads) {
  const auto items = build_items(crossed_clutter(5000, 2));
  BinaryTree expected;
  for (const int threads : {1, 2, 3}) {
    BinaryTree tree = build_binned_sah(items, {});
    with_threads(threads, [&] { reinsert_subtrees(tree, 5); });
    if (threads == 1) expected = tree;
    EXPECT_TRUE(same(tree, expected)) << threads << " threads";
  }
}

TEST(SpatialSplits, PartsOfATriangleCoverIt) {
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    Geometry g;
    const float scale = std::exp2(random.between(-20, 20));
    const vec3 offset = random.in_cube(100 * scale);
    add_triangle(g, offset + random.in_cube(scale), offset + random.in_cube(scale), offset + random.in_cube(scale));
    const BuildItem item{g.primitive_bounds(0), 0};
    const int axis = static_cast<int>(random.below(3));
    const float plane = item.bounds.lower[axis] + random.unit() * item.bounds.diagonal()[axis];
    if (!(plane > item.bounds.lower[axis] && plane < item.bounds.upper[axis])) continue;
    const SplitParts parts = split_primitive(&g, item, axis, plane);
    EXPECT_LE(parts.left.upper[axis], plane);
    EXPECT_GE(parts.right.lower[axis], plane);
    EXPECT_TRUE(contains(item.bounds, parts.left) && contains(item.bounds, parts.right));
    for (int sample = 0; sample < 20; ++sample) {
      const float a = random.unit(), b = random.unit() * (1 - a);
      const vec3 p = g.positions[0] + a * (g.positions[1] - g.positions[0]) + b * (g.positions[2] - g.positions[0]);
      EXPECT_TRUE(parts.left.contains(p) || parts.right.contains(p) || !item.bounds.contains(p));
    }
  }
}

TEST(SpatialSplits, HoldEveryPrimitiveWithinTheirBudget) {
  for (const RayCase& c : ray_cases())
    for (const float duplication : {0.0f, 0.1f, 1.0f}) {
      SCOPED_TRACE(c.name);
      const Geometry& geometry = c.scene.objects[0].geometry;
      const auto items = build_items(geometry);
      SbvhParams params;
      params.leaf_size = 1;
      params.alpha = 0;
      params.duplication = duplication;
      const BinaryTree tree = build_sbvh(items, params, &geometry);
      expect_connected(tree);
      std::vector<std::uint32_t> ids = sorted(tree.primitives);
      EXPECT_LE(ids.size(), static_cast<std::size_t>(static_cast<float>(items.size()) * (1 + duplication)));
      ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
      EXPECT_EQ(ids, geometry.valid_primitives());
    }
}

TEST(SpatialSplits, LowerTheCostOfCrossedClutter) {
  const Geometry geometry = crossed_clutter(3000, 4);
  SbvhParams params;
  params.alpha = 1;
  const double whole = build_sbvh(build_items(geometry), params, &geometry).sah_cost();
  params.alpha = 0;
  EXPECT_LT(build_sbvh(build_items(geometry), params, &geometry).sah_cost(), 0.8 * whole);
}

// Their boxes are all alike, whole or cut; only the parts of the triangles themselves tell that a cut pays.
TEST(SpatialSplits, LowerTheCostOfParallelDiagonalSlivers) {
  Random random(6);
  Geometry geometry;
  for (int i = 0; i < 1000; ++i) {
    const vec3 from = random.in_cube(0.1f);
    add_triangle(geometry, from, from + vec3(1), from + vec3(0.5f) + random.in_cube(0.01f));
  }
  SbvhParams params;
  params.duplication = 0;
  const double whole = build_sbvh(build_items(geometry), params, &geometry).sah_cost();
  params.duplication = 8;
  EXPECT_LT(build_sbvh(build_items(geometry), params, &geometry).sah_cost(), 0.7 * whole);
}

TEST(SpatialSplits, TreeDoesNotDependOnThreads) {
  const Geometry geometry = crossed_clutter(20000, 5);
  BinaryTree expected;
  for (const int threads : {1, 2, 3}) {
    BinaryTree tree;
    with_threads(threads, [&] { tree = build_sbvh(build_items(geometry), {}, &geometry); });
    if (threads == 1) expected = tree;
    EXPECT_TRUE(same(tree, expected)) << threads << " threads";
  }
}

// Quadrics are tested one by one: where most primitives are such, the collapse weighs each, and those far apart share no leaf.
TEST(WideTree, GoesDownToSingleQuadrics) {
  SceneBuilder builder("spheres");
  const auto grey = builder.material(Diffuse{Rgb(0.5f)});
  for (int i = 0; i < 5; ++i) builder.quadric(Sphere{vec3(3 * i, 0, 0), 0.5f}, grey);
  const Scene scene = builder.finish();
  const ParamMap params{{"layout", {std::string("bvh16"), {}}}};
  EXPECT_LT(find_ray_structure("binned-sah", {}).make(scene, params)->stats().sah_cost, 2) << "a leaf of all five costs 5";
}

}  // namespace
}  // namespace etendue::testing
