// Trees that change over time: after any change, however it was dealt with, the hits are those of a tree built anew.
#include "accel/bvh/dynamic/dynamic_bvh.h"
#include "accel/registry.h"
#include "accel/spatial/brute_force.h"
#include "framework/core/parallel.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

#include <cstring>
#include <numeric>

namespace etendue::testing {
namespace {

using Kind = ChangePolicy::Kind;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

TreeBuilder builder(const std::string& name) { return find_ray_structure(name, {}).builder({}); }

std::vector<TreeBuilder> all_builders() {
  std::vector<TreeBuilder> builders;
  for (const RayEntry& entry : ray_structures())
    if (entry.builder) builders.push_back(entry.builder({}));
  return builders;
}

std::vector<std::uint32_t> all_primitives(const Geometry& geometry) {
  std::vector<std::uint32_t> ids(geometry.primitive_count());
  std::iota(ids.begin(), ids.end(), 0u);
  return ids;
}

// The primitives whose vertices, or whose quadric, differ.
std::vector<std::uint32_t> changed_primitives(const Geometry& before, const Geometry& now) {
  const auto same = [](const vec3& a, const vec3& b) { return std::memcmp(&a, &b, sizeof(vec3)) == 0; };
  std::vector<std::uint32_t> changed;
  for (std::uint32_t id = 0; id < now.primitive_count(); ++id) {
    bool differs = false;
    if (now.is_triangle(id))
      for (int i = 0; i < 3; ++i) differs |= !same(before.positions[now.triangles[id][i]], now.positions[now.triangles[id][i]]);
    else
      differs = std::memcmp(&before.quadric(id), &now.quadric(id), sizeof(Quadric)) != 0;
    if (differs) changed.push_back(id);
  }
  return changed;
}

// One way or another of changing a few or all vertices; some become NaN, infinite or coincident, and come back.
void deform(Geometry& geometry, const Geometry& rest, Random& random) {
  auto& p = geometry.positions;
  const auto some = [&] { return random.below(static_cast<std::uint32_t>(p.size())); };
  switch (random.below(8)) {
    case 0:  // all by a little
      for (vec3& v : p) v += random.in_cube(0.05f);
      break;
    case 1:  // a twist about the vertical axis
    {
      const float turns = random.between(-4, 4);
      for (vec3& v : p) {
        const float s = std::sin(turns * v.y), c = std::cos(turns * v.y);
        v = {c * v.x + s * v.z, v.y, c * v.z - s * v.x};
      }
      break;
    }
    case 2:  // a few anywhere
      for (int i = 0; i < 5; ++i) p[some()] = random.in_cube(2);
      break;
    case 3:  // a few vanish
      for (int i = 0; i < 3; ++i) p[some()] = vec3(nan, 0, 1);
      p[some()].y = infinity;
      break;
    case 4:  // all that vanished appear again
      for (std::size_t i = 0; i < p.size(); ++i)
        if (!is_finite(p[i])) p[i] = rest.positions[i];
      break;
    case 5:  // triangles without area
      for (int i = 0; i < 3; ++i) p[some()] = p[some()];
      break;
    case 6:  // places swapped: the worst that can happen to a refitted tree
      for (int i = 0; i < 10; ++i) std::swap(p[some()], p[some()]);
      break;
    case 7:  // back to where all began
      p = rest.positions;
      break;
  }
  for (Quadric& quadric : geometry.quadrics)
    if (auto* sphere = std::get_if<Sphere>(&quadric)) sphere->centre += random.in_cube(0.2f);
}

Geometry small_mesh(std::uint32_t kind) {
  Geometry geometry;
  if (kind % 3 == 0) return closed_sphere(8, 10);
  Random random(kind);
  for (int i = 0; i < 90; ++i) {
    const vec3 at = random.in_cube(1);
    add_triangle(geometry, at, at + random.in_cube(0.2f), at + random.in_cube(0.2f));
  }
  if (kind % 3 == 2)
    for (int i = 0; i < 7; ++i) geometry.quadrics.push_back(Sphere{random.in_cube(1), 0.1f});
  return geometry;
}

std::vector<Ray> rays_of(const Geometry& geometry, std::size_t count, std::uint64_t seed) {
  Geometry finite = geometry;
  for (vec3& v : finite.positions)
    if (!is_finite(v)) v = vec3(0);
  const Scene scene = scene_of(std::move(finite));
  std::vector<Ray> rays = general_rays(scene, count, seed), aimed = testing::aimed_rays(scene, count, seed + 1);
  rays.insert(rays.end(), aimed.begin(), aimed.end());
  return rays;
}

template <class Expected, class Given>
void expect_same_hits(const Expected& expected, const Given& given, const std::vector<Ray>& rays) {
  for (const Ray& ray : rays) {
    const Hit a = expected.closest(ray), b = given.closest(ray);
    ASSERT_EQ(a.t, b.t);
    ASSERT_EQ(a.primitive, b.primitive);
    ASSERT_EQ(a.uv, b.uv);
    ASSERT_EQ(static_cast<bool>(a), given.occluded(ray));
  }
}

// 50 meshes, 20 deformations of each, all builders in turn.
TEST(DynamicBvh, ThousandRandomDeformationsGiveTheHitsOfARebuild) {
  const std::vector<TreeBuilder> builders = all_builders();
  ASSERT_GE(builders.size(), 3u);
  std::uint64_t rebuilt_in_part = 0;
  for (std::uint32_t mesh = 0; mesh < 50; ++mesh) {
    const Geometry rest = small_mesh(mesh);
    Geometry moving = rest;
    const TreeBuilder& build = builders[mesh % builders.size()];
    DynamicBvh refitted(moving, build, {Kind::refit, {}});
    DynamicBvh hybrid(moving, build, {Kind::hybrid, {0.05f, 1.2f, 0.01f}});
    DynamicBvh eager(moving, build, {Kind::hybrid, {0, 1, 0}});
    Random random(100 + mesh);
    for (int step = 0; step < 20; ++step) {
      const Geometry before = moving;
      deform(moving, rest, random);
      const std::vector<std::uint32_t> changed = changed_primitives(before, moving);
      refitted.update(changed);
      const TreeUpdate done = hybrid.update(changed);
      rebuilt_in_part += done.subtrees > 0 && done.rebuilt < moving.primitive_count();
      eager.update(changed);
      SCOPED_TRACE("mesh " + std::to_string(mesh) + ", step " + std::to_string(step));
      const DynamicBvh rebuilt(moving, build, {Kind::rebuild, {}});
      const std::vector<Ray> rays = rays_of(moving, 40, 1000 * mesh + step);
      ASSERT_NO_FATAL_FAILURE(expect_same_hits(BruteForce(moving), rebuilt, rays));
      ASSERT_NO_FATAL_FAILURE(expect_same_hits(rebuilt, refitted, rays));
      ASSERT_NO_FATAL_FAILURE(expect_same_hits(rebuilt, hybrid, rays));
      ASSERT_NO_FATAL_FAILURE(expect_same_hits(rebuilt, eager, rays));
    }
  }
  EXPECT_GT(rebuilt_in_part, 50u) << "subtrees must have been rebuilt within trees that stayed";
}

TEST(DynamicBvh, PrimitivesThatWereInvalidFromTheStartAppear) {
  Geometry moving = closed_sphere(6, 8);
  const Geometry whole = moving;
  for (vec3& v : moving.positions) v.x = nan;
  for (const Kind kind : {Kind::refit, Kind::rebuild, Kind::hybrid}) {
    Geometry geometry = moving;
    DynamicBvh bvh(geometry, builder("sah"), {kind, {}});
    const std::vector<Ray> rays = rays_of(whole, 100, 5);
    ASSERT_NO_FATAL_FAILURE(expect_same_hits(BruteForce(Geometry{}), bvh, rays)) << "nothing is there yet";
    geometry.positions = whole.positions;
    bvh.update(all_primitives(geometry));
    ASSERT_NO_FATAL_FAILURE(expect_same_hits(BruteForce(geometry), bvh, rays));
    geometry.positions[3].y = infinity;
    bvh.update(all_primitives(geometry));
    ASSERT_NO_FATAL_FAILURE(expect_same_hits(BruteForce(geometry), bvh, rays));
  }
}

TEST(DynamicBvh, EmptyAndTinyGeometriesStandEveryPolicy) {
  for (const Kind kind : {Kind::refit, Kind::rebuild, Kind::hybrid})
    for (int triangles = 0; triangles < 10; ++triangles) {
      Geometry geometry;
      Random random(triangles);
      for (int i = 0; i < triangles; ++i) add_triangle(geometry, random.in_cube(1), random.in_cube(1), random.in_cube(1));
      DynamicBvh bvh(geometry, builder("binned-sah"), {kind, {0, 1, 0}});
      for (int step = 0; step < 5; ++step) {
        for (vec3& v : geometry.positions) v = random.in_cube(1);
        bvh.update(all_primitives(geometry));
        const std::vector<Ray> rays = triangles > 0 ? rays_of(geometry, 20, step) : std::vector<Ray>{{vec3(0), 0, vec3(1)}};
        ASSERT_NO_FATAL_FAILURE(expect_same_hits(BruteForce(geometry), bvh, rays));
      }
      EXPECT_EQ(bvh.update({}).refitted, 0u);
    }
}

// A twist shears what lay side by side: refitted boxes overlap ever more, a rebuilt tree's do not, and the hybrid keeps within
// its threshold.
TEST(DynamicBvh, TwistDegradesARefitButNotTheHybrid) {
  Random random(7);
  Geometry rest;
  for (int i = 0; i < 4000; ++i) {
    const vec3 at = random.in_cube(1);
    add_triangle(rest, at, at + random.in_cube(0.03f), at + random.in_cube(0.03f));
  }
  Geometry moving = rest;
  DynamicBvh refitted(moving, builder("sah"), {Kind::refit, {}});
  DynamicBvh hybrid(moving, builder("sah"), {Kind::hybrid, {0.1f, 1.2f, 0.05f}});
  for (int step = 1; step <= 30; ++step) {
    for (std::size_t i = 0; i < rest.positions.size(); ++i) {
      const vec3 v = rest.positions[i];
      const float angle = 0.4f * static_cast<float>(step) * v.y, s = std::sin(angle), c = std::cos(angle);
      moving.positions[i] = {c * v.x + s * v.z, v.y, c * v.z - s * v.x};
    }
    refitted.update(all_primitives(moving));
    hybrid.update(all_primitives(moving));
  }
  const DynamicBvh rebuilt(moving, builder("sah"), {Kind::rebuild, {}});
  const double best = rebuilt.stats().sah_cost;
  EXPECT_GT(refitted.stats().sah_cost, 3 * best);
  EXPECT_LT(hybrid.stats().sah_cost, 1.3 * best);
  const std::vector<Ray> rays = rays_of(moving, 1000, 3);
  ASSERT_NO_FATAL_FAILURE(expect_same_hits(rebuilt, refitted, rays));
  ASSERT_NO_FATAL_FAILURE(expect_same_hits(rebuilt, hybrid, rays));
}

// Clusters that trade places: their own subtrees are as good as ever, so only what is above them goes to the builder.
TEST(DynamicBvh, HybridKeepsSubtreesThatMovedAsAWhole) {
  Random random(9);
  Geometry moving;
  constexpr int clusters = 64, each = 200;
  for (int k = 0; k < clusters; ++k) {
    const vec3 centre = vec3(k % 4, k / 4 % 4, k / 16);
    for (int i = 0; i < each; ++i) {
      const vec3 at = centre + random.in_cube(0.2f);
      add_triangle(moving, at, at + random.in_cube(0.02f), at + random.in_cube(0.02f));
    }
  }
  DynamicBvh refitted(moving, builder("sah"), {Kind::refit, {}});
  DynamicBvh hybrid(moving, builder("sah"), {Kind::hybrid, {0.1f, 1.3f, 0.05f}});
  const auto first = moving.positions.begin();
  std::uint64_t rebuilt_items = 0;
  int small_rebuilds = 0;
  for (int step = 0; step < 60; ++step) {
    std::vector<std::uint32_t> changed;
    for (int k = 0; k < 8; ++k) {
      const std::uint32_t cluster = random.below(clusters);
      const vec3 by = random.in_cube(2);
      std::for_each(first + cluster * each * 3, first + (cluster + 1) * each * 3, [&](vec3& v) { v += by; });
      for (std::uint32_t i = 0; i < each; ++i) changed.push_back(cluster * each + i);
    }
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    refitted.update(changed);
    const TreeUpdate done = hybrid.update(changed);
    rebuilt_items += done.rebuilt;
    small_rebuilds += done.rebuilt > 0 && done.rebuilt < clusters * each / 8u;
  }
  EXPECT_LT(rebuilt_items, 60u * clusters * each / 4u);
  EXPECT_GT(small_rebuilds, 10);
  const DynamicBvh rebuilt(moving, builder("sah"), {Kind::rebuild, {}});
  EXPECT_LT(hybrid.stats().sah_cost, 1.3 * rebuilt.stats().sah_cost);
  EXPECT_GT(refitted.stats().sah_cost, 1.5 * rebuilt.stats().sah_cost);
  ASSERT_NO_FATAL_FAILURE(expect_same_hits(rebuilt, hybrid, rays_of(moving, 1000, 3)));
}

TEST(DynamicBvh, ChangedFractionHoldsRebuildsBack) {
  Geometry moving = closed_sphere(40, 50);
  DynamicBvh bvh(moving, builder("sah"), {Kind::hybrid, {0.5f, 1.05f, 0}});
  Random random(3);
  std::vector<std::uint32_t> few(moving.triangles.size() / 4);
  std::iota(few.begin(), few.end(), 0u);
  const auto scatter = [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t i = begin; i < end; ++i)
      for (int k = 0; k < 3; ++k) moving.positions[moving.triangles[i][k]] = random.in_cube(1);
  };
  const auto count = static_cast<std::uint32_t>(few.size());
  scatter(0, count);
  EXPECT_EQ(bvh.update(few).subtrees, 0u) << "a quarter has changed";
  scatter(0, count);
  EXPECT_EQ(bvh.update(few).subtrees, 0u) << "the same quarter, again";
  std::iota(few.begin(), few.end(), 2 * count);
  scatter(2 * count, 3 * count);
  EXPECT_GT(bvh.update(few).subtrees, 0u) << "now it is half";
}

TEST(DynamicBvh, TreeIsTheSameAtAnyThreadCount) {
  const Geometry rest = closed_sphere(120, 160);
  std::vector<double> costs;
  std::vector<std::uint64_t> work, steps;
  for (const int threads : {1, 2, 3})
    with_threads(threads, [&] {
      Geometry moving = rest;
      DynamicBvh bvh(moving, builder("binned-sah"), {Kind::hybrid, {0.02f, 1.1f, 0.01f}});
      Random random(21);
      TraversalCounters counters;
      for (int step = 0; step < 12; ++step) {
        const Geometry before = moving;
        deform(moving, rest, random);
        const TreeUpdate done = bvh.update(changed_primitives(before, moving));
        steps.push_back(done.rebuilt);
        costs.push_back(bvh.stats().sah_cost);
        for (const Ray& ray : rays_of(rest, 50, step)) bvh.closest_counted(ray, counters);
        work.push_back(counters.nodes);
        work.push_back(counters.primitives);
      }
    });
  const auto third = [](const auto& values, std::size_t i) {
    const std::size_t n = values.size() / 3;
    return std::vector(values.begin() + i * n, values.begin() + (i + 1) * n);
  };
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_EQ(third(costs, i), third(costs, 0));
    EXPECT_EQ(third(work, i), third(work, 0));
    EXPECT_EQ(third(steps, i), third(steps, 0));
  }
}

}  // namespace
}  // namespace etendue::testing
