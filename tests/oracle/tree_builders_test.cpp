// Every builder's tree against what it must be, whatever it is built over; and the SIMD leaf against the scalar test.
#include "accel/bvh/build/binned_sah.h"
#include "accel/bvh/build/lbvh.h"
#include "accel/bvh/build/median.h"
#include "accel/bvh/build/median_round_robin.h"
#include "accel/bvh/build/midpoint.h"
#include "accel/bvh/build/ploc.h"
#include "accel/bvh/build/sah.h"
#include "accel/kernels/pack_query.h"
#include "framework/core/isa.h"
#include "framework/core/parallel.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

#include <set>

#include <pthread.h>

#include <chrono>
#include <cstring>
#include <functional>

namespace etendue::testing {
namespace {

using Build = std::function<BinaryTree(BuildItems, const TreeLimits&)>;

struct Builder {
  std::string name;
  Build build;
};

// A builder with its own parameters, under any limits.
template <class Params>
Builder builder(const char* name, BinaryTree (*build)(BuildItems, const Params&), Params params = {}) {
  return {name, [=](BuildItems items, const TreeLimits& limits) {
            Params limited = params;
            static_cast<TreeLimits&>(limited) = limits;
            return build(std::move(items), limited);
          }};
}

BinnedSahParams with_bins(int bins) {
  BinnedSahParams params;
  params.bins = bins;
  return params;
}

PlocParams with_radius(int radius) {
  PlocParams params;
  params.search_radius = radius;
  return params;
}

std::vector<Builder> builders() {
  return {builder("median", build_median),
          builder("median-round-robin", build_median_round_robin),
          builder("midpoint", build_midpoint),
          builder("sah", build_sah),
          builder("binned-sah 16", build_binned_sah, with_bins(16)),
          builder("binned-sah 2", build_binned_sah, with_bins(2)),
          builder("binned-sah 256", build_binned_sah, with_bins(256)),
          builder("lbvh", build_lbvh),
          builder("ploc 16", build_ploc),
          builder("ploc 1", build_ploc, with_radius(1)),
          builder("ploc 100", build_ploc, with_radius(100))};
}

bool contains(const Bounds& outer, const Bounds& inner) { return outer.contains(inner.lower) && outer.contains(inner.upper); }

// Every item in one leaf, boxes around what they hold, and no leaf or path beyond the limits.
void expect_sound(const BinaryTree& tree, const BuildItems& items, const TreeLimits& limits) {
  ASSERT_EQ(tree.nodes.empty(), items.empty());
  ASSERT_EQ(tree.primitives.size(), items.size());
  if (items.empty()) return;
  std::vector<const BuildItem*> by_id;
  for (const BuildItem& item : items) {
    by_id.resize(std::max<std::size_t>(by_id.size(), item.id + 1));
    by_id[item.id] = &item;
  }
  std::vector<int> seen(by_id.size());
  struct Visit {
    std::uint32_t node;
    int depth;
  };
  std::vector<Visit> visits{{0, 0}};
  std::size_t visited = 0;
  int deepest = 0;
  while (!visits.empty()) {
    const auto [index, depth] = visits.back();
    visits.pop_back();
    ++visited;
    const TreeNode& node = tree.nodes[index];
    deepest = std::max(deepest, depth);
    if (!node.is_leaf()) {
      for (std::uint32_t child = node.first; child < node.first + 2; ++child) {
        ASSERT_GT(child, index);
        ASSERT_TRUE(contains(node.bounds, tree.nodes[child].bounds));
        visits.push_back({child, depth + 1});
      }
      continue;
    }
    ASSERT_TRUE(static_cast<int>(node.count) <= limits.leaf_size || depth == limits.max_depth) << node.count << " at " << depth;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      ++seen[tree.primitives[i]];
      ASSERT_TRUE(contains(node.bounds, by_id[tree.primitives[i]]->bounds));
    }
  }
  EXPECT_EQ(visited, tree.nodes.size());
  EXPECT_EQ(deepest, static_cast<int>(tree.depth));
  EXPECT_LE(deepest, limits.max_depth);
  for (const BuildItem& item : items) EXPECT_EQ(seen[item.id], 1);
}

BuildItems items_at(const std::function<vec3(int)>& centre, int count, float half) {
  BuildItems items;
  for (int i = 0; i < count; ++i) items.push_back({{centre(i) - half, centre(i) + half}, static_cast<std::uint32_t>(i)});
  return items;
}

struct ItemCase {
  std::string name;
  BuildItems items;
};

std::vector<ItemCase> item_cases() {
  std::vector<ItemCase> cases;
  for (const RayCase& c : ray_cases()) cases.push_back({c.name, build_items(c.scene.objects[0].geometry)});
  cases.push_back({"one place", items_at([](int) { return vec3(1, 2, 3); }, 3000, 0.5f)});
  cases.push_back({"no extent", items_at([](int) { return vec3(1, 2, 3); }, 3000, 0)});
  cases.push_back({"on a line", items_at([](int i) { return vec3(i, 0, 0); }, 1000, 0)});
  cases.push_back({"two places", items_at([](int i) { return vec3(i % 2); }, 1000, 0)});
  cases.push_back({"series", items_at([](int i) { return vec3(std::ldexp(1.0f, -(i % 140))); }, 1400, 0)});
  cases.push_back({"huge", items_at([](int i) { return vec3(i % 2 ? 3e38f : -3e38f, i, 0); }, 100, 0)});
  cases.push_back({"tiny", items_at([](int i) { return vec3(i * 1e-44f, 0, 0); }, 100, 0)});
  return cases;
}

// There are three chunks, each of which leaves some out, so that items move up behind those of the chunks before.
TEST(BuildItems, AreTheValidPrimitivesInOrderWithTheirBoxes) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  Pcg32 random(7, 1);
  Geometry geometry;
  for (int i = 0; i < 20000; ++i) {
    const float size = std::exp2(static_cast<float>(i % 60 - 30));
    vec3 corners[3];
    for (vec3& p : corners)
      p = size * vec3(random.next_float(), random.next_float(), random.next_float()) -
          (i % 7 == 0 ? size * vec3(0.5f) : vec3(0));
    if (i % 11 == 0) corners[2] = corners[1];                             // empty
    if (i % 13 == 0) corners[2] = 0.5f * corners[0] + 0.5f * corners[1];  // or nearly so
    if (i % 17 == 0) corners[i % 3][i % 2] = i % 5 == 0 ? nan : i % 5 == 1 ? infinity : -0.0f;
    for (const vec3& p : corners) geometry.positions.push_back(p);
    geometry.triangles.push_back(uvec3(3 * i, 3 * i + 1, 3 * i + 2));
  }
  geometry.quadrics = {Sphere{vec3(0.5f, -0.0f, 2), 0.5f}, Sphere{vec3(1), 0}};
  ASSERT_TRUE(geometry.is_valid(20000));
  ASSERT_FALSE(geometry.is_valid(20001));
  std::size_t next = 0, left_out[3] = {};
  const BuildItems items = build_items(geometry);
  for (std::uint32_t id = 0; id < geometry.primitive_count(); ++id) {
    if (!geometry.is_valid(id)) {
      ++left_out[id >> 13];
      continue;
    }
    ASSERT_LT(next, items.size());
    const BuildItem& item = items[next++];
    ASSERT_EQ(item.id, id);
    const Bounds bounds = geometry.primitive_bounds(id);
    EXPECT_EQ(item.bounds.lower, bounds.lower);
    EXPECT_EQ(item.bounds.upper, bounds.upper);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_FALSE(item.bounds.lower[axis] == 0 && std::signbit(item.bounds.lower[axis]));
      EXPECT_FALSE(item.bounds.upper[axis] == 0 && std::signbit(item.bounds.upper[axis]));
    }
  }
  EXPECT_EQ(next, items.size());
  for (const std::size_t count : left_out) EXPECT_GT(count, 100u);
}

TEST(TreeBuilders, TreesAreSoundWithinTheirLimits) {
  for (const ItemCase& c : item_cases())
    for (const Builder& builder : builders())
      for (const TreeLimits& limits :
           {TreeLimits{}, TreeLimits{1, 1024}, TreeLimits{1, 12}, TreeLimits{64, 2}, TreeLimits{4, 1}}) {
        SCOPED_TRACE(c.name + ", " + builder.name + " leaf_size " + std::to_string(limits.leaf_size) + " max_depth " +
                     std::to_string(limits.max_depth));
        ASSERT_NO_FATAL_FAILURE(expect_sound(builder.build(c.items, limits), c.items, limits));
      }
}

// Items that are hard on every builder: nothing to tell apart, sizes and places that grow geometrically, areas that overflow.
std::vector<ItemCase> hostile_cases() {
  std::vector<ItemCase> cases;
  Random random(17);
  const auto boxes = [&](const char* name, int count, const std::function<vec3(int)>& centre,
                         const std::function<float(int)>& half) {
    ItemCase c{name, {}};
    for (int i = 0; i < count; ++i) {
      const vec3 middle = centre(i);
      c.items.push_back({{middle - half(i) + 0.0f, middle + half(i) + 0.0f}, static_cast<std::uint32_t>(i)});
    }
    cases.push_back(std::move(c));
  };
  const int many = 10000;
  const auto no_extent = [](int) { return 0.0f; };
  const auto power = [](int i) { return std::ldexp(1.0f, i % 241 - 120); };
  boxes(
      "coincident", many, [](int) { return vec3(-7, 0, 3); }, [](int) { return 2.0f; });
  boxes(
      "coincident centres", many, [](int) { return vec3(0); }, power);
  boxes(
      "collinear", many, [](int i) { return vec3(i * 0.001f, i * 0.002f, i * -0.003f); }, no_extent);
  boxes(
      "geometric series", many, [&](int i) { return vec3(power(i), 0, 0); }, [&](int i) { return 0.4f * power(i); });
  boxes(
      "series on three axes", many, [&](int i) { return vec3(power(i), power(i / 2), -power(i / 3)); }, no_extent);
  boxes(
      "each inside the next", many, [](int i) { return vec3(std::ldexp(1.0f, i / 80), 0, 0); },
      [](int i) { return std::ldexp(1.0f, i / 80); });
  boxes(
      "up to 1e30", many, [&](int) { return random.in_cube(1e30f); }, [&](int) { return random.unit() * 1e30f; });
  boxes(
      "up to 3e38", many, [&](int) { return 2.0f * random.in_cube(1.5e38f); }, no_extent);
  boxes(
      "one far away", many, [&](int i) { return i == 5000 ? vec3(1e30f) : random.in_cube(1); }, no_extent);
  boxes(
      "smallest numbers", many, [](int i) { return vec3(i * 1e-45f, 0, i * 2e-45f); }, no_extent);
  boxes(
      "pairs", many, [](int i) { return vec3(i / 2, 0, 0); }, [](int) { return 0.5f; });
  for (int count = 0; count <= 9; ++count)
    boxes(
        "a few", count, [&](int) { return random.in_cube(1e3f); }, [&](int) { return random.unit(); });
  for (int count = 1; count <= 9; ++count)
    boxes(
        "a few in one place", count, [](int) { return vec3(1e30f); }, no_extent);
  return cases;
}

// Runs on a stack of 256 KB, that of `ulimit -s 256`.
template <class Body>
void on_a_short_stack(const Body& body) {
  pthread_attr_t attributes;
  ASSERT_EQ(pthread_attr_init(&attributes), 0);
  ASSERT_EQ(pthread_attr_setstacksize(&attributes, 256 << 10), 0);
  pthread_t thread;
  const auto call = [](void* b) -> void* {
    (*static_cast<const Body*>(b))();
    return nullptr;
  };
  ASSERT_EQ(pthread_create(&thread, &attributes, call, const_cast<Body*>(&body)), 0);
  pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
}

TEST(TreeBuilders, HostileItemsAreBuiltInTimeOnAShortStack) {
  for (const ItemCase& c : hostile_cases())
    for (const Builder& builder : builders())
      for (const TreeLimits& limits : {TreeLimits{1, 64}, TreeLimits{4, 1024}}) {
        SCOPED_TRACE(c.name + " of " + std::to_string(c.items.size()) + ", " + builder.name);
        BinaryTree tree;
        const auto start = std::chrono::steady_clock::now();
        on_a_short_stack([&] { with_threads(1, [&] { tree = builder.build(c.items, limits); }); });
        const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
        EXPECT_LT(time.count(), 5);
        ASSERT_NO_FATAL_FAILURE(expect_sound(tree, c.items, limits));
      }
}

// Near max_depth cuts turn into halves, so that no large leaf is left where a balanced tree still fits.
TEST(TreeBuilders, DepthLimitHalvesBeforeItLeavesLargeLeaves) {
  const auto items = items_at([](int i) { return vec3(std::ldexp(1.0f, -(i % 140)), i * 1e-30f, 0); }, 1000, 0);
  for (const Builder& builder : builders()) {
    const BinaryTree tree = builder.build(items, {1, 10});  // 2^10 leaves hold 1000 items
    for (const TreeNode& node : tree.nodes) EXPECT_LE(node.count, 1u) << builder.name;
  }
}

BuildItems many_boxes() {
  Random random(3);
  BuildItems items;
  for (std::uint32_t i = 0; i < 150000; ++i) {
    const vec3 centre = random.in_cube(1) * random.unit();
    items.push_back({{centre - random.unit() * 0.01f, centre + random.unit() * 0.01f}, i});
  }
  return items;
}

void expect_same_bits(const BinaryTree& a, const BinaryTree& b) {
  EXPECT_EQ(a.primitives, b.primitives);
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  EXPECT_EQ(std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.size() * sizeof(TreeNode)), 0);
}

TEST(TreeBuilders, TreeIsTheSameAtAnyThreadCount) {
  const BuildItems items = many_boxes();
  for (const Builder& builder : builders()) {
    SCOPED_TRACE(builder.name);
    BinaryTree trees[3];
    for (int threads = 1; threads <= 3; ++threads)
      with_threads(threads, [&] { trees[threads - 1] = builder.build(items, {}); });
    for (int i = 1; i < 3; ++i) expect_same_bits(trees[i], trees[0]);
  }
}

TEST(TreeBuilders, BinnedTreeIsTheSameWithEachInstructionSet) {
  const Isa chosen = chosen_isa();
  for (const BuildItems& items : {many_boxes(), items_at([](int i) { return vec3(-i % 7, i % 40, 0); }, 999, 2)}) {
    std::vector<BinaryTree> trees;
    for (const Isa isa : supported_isas()) {
      choose_isa(isa);
      trees.push_back(build_binned_sah(items, {}));
      expect_same_bits(trees.back(), trees.front());
    }
  }
  choose_isa(chosen);
}

TEST(TreeBuilders, FullSweepIsNoDearerThanMedianOnUnevenMeshes) {
  for (const RayCase& c : ray_cases()) {
    if (c.name != "teapot in a stadium" && c.name != "soup") continue;
    const auto items = build_items(c.scene.objects[0].geometry);
    const double median = build_median(items, {}).sah_cost(), sah = build_sah(items, {}).sah_cost();
    EXPECT_LT(sah, median) << c.name;
    EXPECT_LT(sah, 1.1 * build_binned_sah(items, {}).sah_cost()) << c.name;
  }
}

TEST(TreeBuilders, SahCostIsTheExpectedWork) {
  BinaryTree tree;  // a unit cube cut in two halves of 2 and 3 primitives
  tree.nodes = {{{vec3(0), vec3(1)}, 1, 0}, {{vec3(0), vec3(0.5f, 1, 1)}, 0, 2}, {{vec3(0.5f, 0, 0), vec3(1)}, 2, 3}};
  EXPECT_DOUBLE_EQ(tree.sah_cost(), 1 + (2.0 / 3) * (2 + 3));
  EXPECT_EQ(BinaryTree().sah_cost(), 0);
}

// The nearest hit among the triangles of a pack, and whether there is any.
template <class Lanes, class Pack>
void expect_scalar_hits(const Geometry& g, const Pack& pack, const Ray& ray, std::size_t& hits_seen) {
  const TriangleRay shear(ray.direction);
  Hit expected, hit, any;
  expected.t = hit.t = any.t = farthest_hit(ray);
  for (const std::uint32_t id : pack.ids)
    if (id != no_id) intersect_primitive(g, id, ray, shear, expected);
  const PackQuery<Lanes, Pack, false> nearest(ray.origin, shear);
  if (nearest.test_common(pack, ray.t_min, hit) == decltype(nearest)::Outcome::rare) nearest.test_rare(g, pack, ray, hit);
  ASSERT_EQ(hit.primitive, expected.primitive);
  ASSERT_EQ(hit.t, expected.t);
  ASSERT_EQ(hit.uv, expected.uv);
  const PackQuery<Lanes, Pack, true> occluded(ray.origin, shear);
  bool rare;
  const bool found = occluded.occluded(pack, ray.t_min, farthest_hit(ray), rare);
  ASSERT_EQ(rare ? occluded.test_rare(g, pack, ray, any) : found, static_cast<bool>(expected));
  hits_seen += static_cast<bool>(hit);
}

TEST(PackQuery, LanesGiveTheBitsOfTheScalarTest) {
  std::size_t hits_seen = 0;
  for (const RayCase& c : ray_cases()) {
    const Geometry& g = c.scene.objects[0].geometry;
    if (g.triangles.size() < 4) continue;
    std::vector<Ray> rays = general_rays(c.scene, 300, 11);
    const std::vector<Ray> aimed = aimed_rays(c.scene, 300, 12);
    rays.insert(rays.end(), aimed.begin(), aimed.end());
    Random random(13);
    for (const Ray& ray : rays) {
      std::set<std::uint32_t> ids;  // ascending
      for (std::uint32_t i = 1 + random.below(4); i > 0; --i)
        ids.insert(random.below(static_cast<std::uint32_t>(g.triangles.size())));
      TrianglePack<4> four;
      TrianglePack<8> eight;
      const auto fill = [&](auto& pack, std::size_t lane) {
        for (const std::uint32_t id : ids) {
          const uvec3 v = g.triangles[id];
          pack.ids[lane] = id;
          pack.set(lane++, g.positions[v.x], g.positions[v.y], g.positions[v.z]);
        }
      };
      fill(four, 0);
      fill(eight, random.below(5));
      SCOPED_TRACE(c.name);
      ASSERT_NO_FATAL_FAILURE((expect_scalar_hits<Floats<4, 1>>(g, four, ray, hits_seen)));
      ASSERT_NO_FATAL_FAILURE((expect_scalar_hits<Floats<4, native_width>>(g, four, ray, hits_seen)));
      ASSERT_NO_FATAL_FAILURE((expect_scalar_hits<Floats<8, native_width>>(g, eight, ray, hits_seen)));
    }
  }
  EXPECT_GT(hits_seen, 1000u);
}

}  // namespace
}  // namespace etendue::testing
