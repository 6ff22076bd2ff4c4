// The linear BVH straight down to packs, and what it stands on: Morton order, and vertices told apart along it.
#include "accel/bvh/wide/lbvh_packs.h"
#include "accel/bvh/build/lbvh.h"
#include "accel/bvh/build/morton_order.h"
#include "accel/bvh/build/pack_test.h"
#include "accel/bvh/wide/corner_repeats.h"
#include "accel/kernels/primitive_test.h"
#include "accel/kernels/shared_pack.h"
#include "accel/kernels/triangle_pack.h"
#include "framework/core/parallel.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <set>

namespace etendue::testing {
namespace {

// Codes computed bit by bit, from the points' cube.
std::vector<std::uint64_t> morton_codes(const std::vector<MortonPoint>& points) {
  Bounds bounds;
  for (const MortonPoint& p : points)
    if (p.counts != 0) bounds.extend(p.position);
  const vec3 origin = 0.5f * bounds.lower;
  float scale = static_cast<float>(1 << 21) * (1 - 1e-6f) / max_component(0.5f * bounds.upper - origin);
  if (!(scale < infinity)) scale = 0;
  std::vector<std::uint64_t> codes;
  for (const MortonPoint& p : points) {
    const vec3 cell = (0.5f * p.position - origin) * scale;
    std::uint64_t code = 0;
    for (int bit = 20; p.counts != 0 && bit >= 0; --bit)
      for (int axis = 0; axis < 3; ++axis) code = code << 1 | (static_cast<std::uint32_t>(cell[axis]) >> bit & 1);
    codes.push_back(code);
  }
  return codes;
}

// Points spread evenly, in few places, in one, along a line, and with some that do not count.
std::vector<std::vector<MortonPoint>> point_sets() {
  Random random(3);
  std::vector<std::vector<MortonPoint>> sets(6);
  for (int i = 0; i < 20'000; ++i) {
    sets[0].push_back({random.in_cube(1)});
    sets[1].push_back({std::ldexp(1.0f, -static_cast<int>(random.below(40))) * random.in_cube(1)});
    sets[2].push_back({vec3(random.below(3), 0, random.below(2))});
    sets[3].push_back({vec3(7)});
    sets[4].push_back({vec3(i % 1000) * 1e-3f});
    sets[5].push_back({random.in_cube(1e30f), random.below(3) == 0 ? 0u : 1u});
  }
  sets.push_back({});
  sets.push_back({{vec3(1)}});
  sets.push_back({{vec3(infinity), 0}, {vec3(1)}, {vec3(std::nanf("")), 0}});
  return sets;
}

TEST(MortonOrder, SortsByCodeAndThenByIndexAtAnyThreadCount) {
  for (const auto& points : point_sets()) {
    const std::vector<std::uint64_t> codes = morton_codes(points);
    std::vector<std::uint32_t> expected;
    for (std::uint32_t i = 0; i < points.size(); ++i)
      if (points[i].counts != 0) expected.push_back(i);
    std::stable_sort(expected.begin(), expected.end(), [&](std::uint32_t a, std::uint32_t b) { return codes[a] < codes[b]; });
    for (const int threads : {1, 2, 3})
      with_threads(threads, [&] {
        const MortonOrder order(points.size(), [&](std::size_t i) { return points[i]; });
        ASSERT_EQ(order.size(), expected.size());
        for (std::uint32_t i = 0; i < order.size(); ++i) ASSERT_EQ(order.index(i), expected[i]);
      });
  }
}

TEST(MortonKeyWriter, BothWaysGiveTheCodesBitByBit) {
  for (const auto& points : point_sets()) {
    const std::vector<std::uint64_t> codes = morton_codes(points);
    Bounds bounds;
    for (const MortonPoint& p : points)
      if (p.counts != 0) bounds.extend(p.position);
    for (const std::uint64_t index_mask : {std::uint64_t{0x7fff}, std::uint64_t{0x7fffffff}}) {
      std::vector<std::uint64_t> expected, generic(points.size()), fast(points.size());
      for (std::uint32_t i = 0; i < points.size(); ++i)
        if (points[i].counts != 0) expected.push_back((2 * codes[i] & ~index_mask) | i);
      const MortonCode code(bounds);
      MortonKeyWriter{points.data(), 0, points.size(), code, index_mask, generic.data()}.write();
      generic.resize(expected.size());
      ASSERT_EQ(generic, expected);
      if (!MortonKeyWriter::has_pdep()) continue;
      MortonKeyWriter{points.data(), 0, points.size(), code, index_mask, fast.data()}.write_with_pdep();
      fast.resize(expected.size());
      ASSERT_EQ(fast, expected);
    }
  }
}

// Runs of one upper part of the code, whose lower parts come in falling or in no order, longer than insertion is for.
TEST(MortonOrder, SortsRunsThatTheRadixSortLeavesInAnyOrder) {
  Random random(5);
  std::vector<MortonPoint> points{{vec3(0)}, {vec3(1)}};
  for (int i = 0; i < 4000; ++i) points.push_back({vec3(0.3f) + static_cast<float>(4000 - i) * vec3(1e-7f)});
  for (int i = 0; i < 4000; ++i) points.push_back({vec3(0.6f) + 1e-4f * random.in_cube(1)});
  for (int i = 0; i < 60; ++i) points.push_back({vec3(0.9f) + static_cast<float>(i % 7) * vec3(6e-7f)});
  const std::vector<std::uint64_t> codes = morton_codes(points);
  std::vector<std::uint32_t> expected(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) expected[i] = i;
  std::stable_sort(expected.begin(), expected.end(), [&](std::uint32_t a, std::uint32_t b) { return codes[a] < codes[b]; });
  const MortonOrder order(points.size(), [&](std::size_t i) { return points[i]; });
  for (std::uint32_t i = 0; i < order.size(); ++i) ASSERT_EQ(order.index(i), expected[i]);
}

TEST(MortonOrder, CutsWhereTheHighestBitThatDiffersChanges) {
  Random random(4);
  for (const auto& points : point_sets()) {
    const std::vector<std::uint64_t> codes = morton_codes(points);
    const MortonOrder order(points.size(), [&](std::size_t i) { return points[i]; });
    for (int i = 0; i < 500 && order.size() > 1; ++i) {
      const std::uint32_t begin = random.below(order.size() - 1),
                          end = begin + 2 + random.below(std::min(order.size() - begin - 1, 1u << random.below(16)));
      const auto code = [&](std::uint32_t place) { return codes[order.index(place)]; };
      std::uint32_t expected = begin + (end - begin) / 2;
      if (const std::uint64_t differs = code(begin) ^ code(end - 1); differs != 0)
        for (expected = begin; (code(expected) & std::bit_floor(differs)) == 0;) ++expected;
      ASSERT_EQ(order.cut(begin, end), expected) << begin << " to " << end;
    }
  }
}

struct Before {
  bool operator()(const vec3& a, const vec3& b) const { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); }
};

TEST(CornerRepeats, TellTheVerticesOfEveryRunAndFillPacksWithThem) {
  const Geometry geometry = closed_sphere(20, 40);
  const auto& p = geometry.positions;
  const std::size_t count = geometry.triangles.size();
  CornerRepeats repeats(count);
  CornerRepeats::Scan scan(repeats, 0);
  for (const uvec3& v : geometry.triangles)
    for (int corner = 0; corner < 3; ++corner) scan.add(p[v[corner]]);
  std::vector<std::uint32_t> ids(count);  // as if in another order
  for (std::uint32_t i = 0; i < count; ++i) ids[i] = (i * 7919 + 11) % static_cast<std::uint32_t>(count);
  std::size_t runs = 0, slipped = 0;
  for (std::size_t begin = 0; begin < count; ++begin)
    for (std::uint32_t size = 1; size <= SharedPack::lanes && begin + size <= count; ++size, ++runs) {
      std::set<vec3, Before> different;
      for (std::size_t i = begin; i < begin + size; ++i)
        for (int corner = 0; corner < 3; ++corner) different.insert(p[geometry.triangles[i][corner]]);
      const auto first = static_cast<std::size_t>(std::popcount(repeats.first_seen(begin, size, count)));
      ASSERT_GE(first, different.size());
      ASSERT_EQ(first, std::popcount(repeats.first_seen(begin, size, begin + size)));
      slipped += first > different.size();
      if (first > SharedPack::slots) continue;
      SharedPack pack;
      const Bounds bounds =
          repeats.fill(pack, geometry, std::span(ids).subspan(begin, size), std::span(geometry.triangles).subspan(begin, size),
                       begin, repeats.first_seen(begin, size, count));
      Bounds expected;
      for (const vec3& vertex : different) expected.extend(vertex);
      ASSERT_EQ(bounds.lower, expected.lower);
      ASSERT_EQ(bounds.upper, expected.upper);
      ASSERT_EQ(pack.count, size);
      ASSERT_TRUE(std::is_sorted(pack.ids, pack.ids + size));
      for (std::uint32_t lane = 0; lane < size; ++lane) {
        const auto place = static_cast<std::size_t>(std::find(ids.begin(), ids.end(), pack.ids[lane]) - ids.begin());
        const uvec3& v = geometry.triangles[place];
        for (int corner = 0; corner < 3; ++corner) ASSERT_EQ(pack.vertex(static_cast<int>(lane), corner), p[v[corner]]);
        ASSERT_EQ(pack.needles() >> lane & 1, is_needle(p[v.x], p[v.y], p[v.z]));
      }
    }
  EXPECT_LT(slipped, runs / 100);
}

// The same nodes in the same places, and in the packs the primitives of the leaves.
template <class Pack>
bool same(const PackTree<Pack>& given, const BinaryTree& expected) {
  if (given.tree.nodes.size() != expected.nodes.size() || given.tree.depth != expected.depth) return false;
  for (std::size_t n = 0; n < expected.nodes.size(); ++n) {
    const TreeNode &a = given.tree.nodes[n], &b = expected.nodes[n];
    if (a.bounds.lower != b.bounds.lower || a.bounds.upper != b.bounds.upper || a.is_leaf() != b.is_leaf()) return false;
    if (!a.is_leaf() && a.first != b.first) return false;
    if (!a.is_leaf()) continue;
    const auto run = std::span(expected.primitives).subspan(b.first, b.count);
    std::vector<std::uint32_t> ids(run.begin(), run.end());
    std::sort(ids.begin(), ids.end());
    if (a.count != 1 || given.counts[a.first] != b.count) return false;
    if (!std::ranges::equal(ids, std::span(given.packs[a.first].ids).first(b.count))) return false;
  }
  return true;
}

template <class Pack>
void expect_tree_of_the_general_build(const Geometry& geometry, int leaf_size) {
  LbvhParams limits{{leaf_size, 64, nullptr}};
  const auto given = build_lbvh_packs<Pack>(geometry, limits);
  ASSERT_TRUE(given.has_value());
  const VertexIds vertices(geometry);
  const PackTest packs = PackTest::of<Pack>(vertices);
  limits.packs = &packs;
  const BinaryTree expected = build_lbvh(build_items(geometry), limits);
  // Where few vertices can be repeated, VertexIds does not look for them: then packs here take more triangles.
  const bool some_are_missed = std::same_as<Pack, SharedPack> && geometry.positions.size() < 0.6 * geometry.triangles.size();
  EXPECT_LE(given->tree.nodes.size(), expected.nodes.size());
  EXPECT_TRUE(some_are_missed || same(*given, expected));
}

TEST(LbvhPacks, TreeIsThatOfTheGeneralBuild) {
  for (const RayCase& c : ray_cases())
    for (const Object& object : c.scene.objects) {
      SCOPED_TRACE(c.name);
      const Geometry& geometry = object.geometry;
      if (!geometry.quadrics.empty()) {
        EXPECT_FALSE(build_lbvh_packs<SharedPack>(geometry, TreeLimits{}).has_value());
        continue;
      }
      expect_tree_of_the_general_build<TrianglePack<4>>(geometry, 1);
      expect_tree_of_the_general_build<TrianglePack<8>>(geometry, 2);
      expect_tree_of_the_general_build<SharedPack>(geometry, 5);
    }
}

TEST(LbvhPacks, TreeAndPacksAreTheSameAtAnyThreadCount) {
  const Geometry geometry = closed_sphere(150, 200);
  std::optional<PackTree<SharedPack>> expected;
  for (const int threads : {1, 2, 3})
    with_threads(threads, [&] {
      auto given = build_lbvh_packs<SharedPack>(geometry, TreeLimits{5, 64});
      ASSERT_TRUE(given.has_value());
      if (!expected) return expected.swap(given);
      const auto same_node = [](const TreeNode& a, const TreeNode& b) {
        return a.bounds.lower == b.bounds.lower && a.bounds.upper == b.bounds.upper && a.first == b.first && a.count == b.count;
      };
      ASSERT_TRUE(std::ranges::equal(given->tree.nodes, expected->tree.nodes, same_node)) << threads << " threads";
      ASSERT_EQ(given->tree.depth, expected->tree.depth);
      ASSERT_EQ(given->packs.size(), expected->packs.size());
      for (std::size_t i = 0; i < given->packs.size(); ++i) {
        const SharedPack &pack = given->packs[i], &other = expected->packs[i];
        ASSERT_EQ(std::memcmp(pack.vertices, other.vertices, sizeof pack.vertices), 0);
        ASSERT_EQ(std::memcmp(pack.corners, other.corners, sizeof pack.corners), 0);
        ASSERT_TRUE(std::ranges::equal(pack.ids, other.ids));
        ASSERT_EQ(given->counts[i], expected->counts[i]);
        ASSERT_EQ(given->areas[i], expected->areas[i]);
      }
    });
}

TEST(LbvhPacks, DepthThatEndsRunsTooLongForAPackIsLeftToTheGeneralBuild) {
  const Geometry geometry = closed_sphere(20, 40);
  EXPECT_FALSE(build_lbvh_packs<SharedPack>(geometry, TreeLimits{5, 3}).has_value());
  EXPECT_TRUE(build_lbvh_packs<SharedPack>(geometry, TreeLimits{5, 64}).has_value());
}

// Codes that differ in each bit, and many that are the same: cut by bits alone the tree would be some 60 deep.
TEST(LbvhPacks, RunsAreHalvedInTimeForPacksWhereADepthHasRoomForThem) {
  Geometry geometry;
  for (int i = 0; i < 1000; ++i) {
    vec3 at(0);
    at[i % 3] = std::ldexp(1.0f, -(i % 60) / 3);
    add_triangle(geometry, at, at + vec3(1e-8f, 0, 0), at + vec3(0, 1e-8f, 0));
  }
  const auto tight = build_lbvh_packs<SharedPack>(geometry, TreeLimits{5, 8});  // 5 * 2^8 triangles have room
  ASSERT_TRUE(tight.has_value());
  EXPECT_LE(tight->tree.depth, 8u);
  EXPECT_FALSE(build_lbvh_packs<SharedPack>(geometry, TreeLimits{5, 5}).has_value());
}

}  // namespace
}  // namespace etendue::testing
