// The comparison of structures, and the arbiter it trusts: both must be able to say no.
#include "experiments/kinds/structures/accel_comparison.h"

#include "accel/exact/exact.h"
#include "accel/registry.h"
#include "experiments/kinds/structures/accel_check.h"
#include "experiments/kinds/structures/accel_rays.h"
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

TEST(ExactTracer, AgreesWithBruteForceOnEveryKindOfScene) {
  for (const RayCase& c : ray_cases()) {
    if (c.name == "geometric series") continue;  // its smallest triangles drown in double's own rounding, which boxes keep out
    SCOPED_TRACE(c.name);
    const ExactTracer tracer(c.scene);
    std::vector<Ray> rays = general_rays(c.scene, 200, 1);
    const std::vector<Ray> aimed = testing::aimed_rays(c.scene, 200, 2);
    rays.insert(rays.end(), aimed.begin(), aimed.end());
    for (const Ray& ray : rays) {
      const auto brute = exact_closest(c.scene, ray), tree = tracer.closest(ray);
      ASSERT_EQ(brute.has_value(), tree.has_value());
      if (brute) {
        ASSERT_EQ(brute->t, tree->t);
      }
    }
  }
}

TEST(ExactTracer, OutlinesMayBeMissedAndSharedEdgesMayNot) {
  const Scene scene = two_squares();
  const ExactTracer tracer(scene);
  const auto missed = [&](float x, float y) {
    const Ray ray{{x, y, 0}, 0, {0, 0, 1}, infinity};
    return tracer.is_right(ray, Hit{}, tracer.closest(ray)) && tracer.is_right(ray, false, tracer.closest(ray));
  };
  EXPECT_TRUE(missed(1, 0.25f));        // on the rim of both squares
  EXPECT_TRUE(missed(1 - 1e-7f, -1));   // at their corner
  EXPECT_FALSE(missed(0.25f, 0.25f));   // on the diagonal that their triangles share
  EXPECT_FALSE(missed(0.999f, 0.25f));  // inside
  const Ray leaking{{0.25f, 0.25f, 0}, 0, {0, 0, 1}, infinity};
  EXPECT_FALSE(tracer.is_right(leaking, {2, vec2(0), 0, 2}, tracer.closest(leaking)));  // through the first, to the second
  const Ray beside{{1 + 1e-7f, 0.25f, 0}, 0, {0, 0, 1}, infinity};
  EXPECT_TRUE(tracer.is_right(beside, {1, vec2(0), 0, 0}, tracer.closest(beside)));
  EXPECT_TRUE(tracer.is_right(beside, Hit{}, tracer.closest(beside)));
}

// A mesh with a crack narrower than rounding, and a ray into it: double precision finds one of its sides, single precision
// none.
struct Crack {
  std::vector<std::array<vec3, 3>> open, closed;  // closed: the same surface, its triangles sharing the ends of their edges
  Ray ray;
};

std::vector<Crack> cracks() {
  // A wall and its moulding in a building: a vertex of the second triangle stands on an edge of the first.
  const vec3 below(0.00724000018f, 4.82331181f, 3.18148899f), left(0.00724000018f, 4.82331324f, 7.221488f),
      right(16.2180405f, 4.82331324f, 7.221488f), above(1.96038699f, 8.38044834f, 7.22148705f),
      between(1.97723997f, 4.82331324f, 7.221488f);
  const std::array<vec3, 3> moulding{left, above, between};
  // Two triangles whose common edge ends at vertices half a millionth apart.
  const vec3 first(5.05011892f, 3.44517708f, 7.221241f), second(4.92487812f, 3.48316407f, 7.22154284f),
      nearly_second(4.92487812f, 3.48316407f, 7.22154188f), far(4.91711378f, 4.59618711f, 7.221488f),
      beyond(3.7643609f, 3.44517708f, 7.221241f);
  return {{{{below, left, right}, moulding},
           {{below, left, between}, {below, between, right}, moulding},
           {{-0x1.d56332p+3f, 0x1.24affp+0f, 0x1.ee941cp+2f}, 0, {0x1.e2163p+3f, 0x1.d70a5cp+1f, -0x1.033ap-1f}, infinity}},
          {{{first, second, far}, {nearly_second, first, beyond}},
           {{first, second, far}, {second, first, beyond}},
           {{0x1.8a5e98p+3f, 0x1.75a55cp+1f, 0x1.b9fe4cp+1f}, 0, {-0x1.d7e34cp+2f, 0x1.1cc558p-1f, 0x1.e25b2cp+1f}, infinity}}};
}

TEST(ExactTracer, CracksOfRoundingMayBeMissedAndTheSameSurfaceWithoutThemMayNot) {
  const auto scene_with = [](const std::vector<std::array<vec3, 3>>& triangles) {
    Geometry g;
    for (const auto& [a, b, c] : triangles) add_triangle(g, a, b, c);
    return scene_of(g);
  };
  for (const Crack& crack : cracks()) {
    const Scene open = scene_with(crack.open), closed = scene_with(crack.closed);
    const ExactTracer of_open(open), of_closed(closed);
    const auto hit = of_open.closest(crack.ray), hit_closed = of_closed.closest(crack.ray);
    ASSERT_TRUE(hit && hit_closed);
    EXPECT_TRUE(of_open.is_right(crack.ray, Hit{}, hit));
    EXPECT_TRUE(of_open.is_right(crack.ray, false, hit));
    EXPECT_FALSE(of_closed.is_right(crack.ray, Hit{}, hit_closed));
    EXPECT_FALSE(of_closed.is_right(crack.ray, false, hit_closed));
    for (const RayEntry& entry : ray_structures()) {
      if (!entry.available || entry.name == "embree" || entry.name == "cgal") continue;
      SCOPED_TRACE(entry.name);
      const auto asked_open = entry.make(open, {}), asked_closed = entry.make(closed, {});
      EXPECT_FALSE(asked_open->closest(crack.ray));
      EXPECT_FALSE(asked_open->occluded(crack.ray));
      EXPECT_TRUE(of_closed.is_right(crack.ray, asked_closed->closest(crack.ray), hit_closed));
      EXPECT_TRUE(asked_closed->occluded(crack.ray));
    }
  }
}

// Answers as the inner structure does, but lets every ray of one direction's sign through.
class Leaking final : public RayQuery {
 public:
  explicit Leaking(std::unique_ptr<RayQuery> inner) : inner_(std::move(inner)) {}
  Hit closest(const Ray& ray) const override { return ray.direction.x > 0 ? Hit{} : inner_->closest(ray); }
  bool occluded(const Ray& ray) const override { return ray.direction.x <= 0 && inner_->occluded(ray); }
  void closest(std::span<const Ray> rays, std::span<Hit> hits) const override { inner_->closest(rays, hits); }
  void occluded(std::span<const Ray> rays, std::span<bool> occluded) const override { inner_->occluded(rays, occluded); }
  Hit passed_light(const Ray& ray) const override { return inner_->passed_light(ray); }
  Hit closest_counted(const Ray& ray, TraversalCounters&) const override { return closest(ray); }
  bool occluded_counted(const Ray& ray, TraversalCounters&) const override { return occluded(ray); }
  RayStructureStats stats() const override { return inner_->stats(); }

 private:
  std::unique_ptr<RayQuery> inner_;
};

TEST(AccelCheck, LeaksAreCountedInEveryFrame) {
  const Scene scene = scene_of(closed_sphere(24, 48));
  for (const CheckFrame& frame : check_frames(scene)) {
    SCOPED_TRACE(frame.name);
    const Scene moved = moved_scene(scene, frame);
    const ExactTracer tracer(moved);
    const std::vector<Ray> rays = etendue::aimed_rays(moved, 0, 3000);
    EXPECT_EQ(rays[100].direction, etendue::aimed_rays(moved, 100, 1)[0].direction);
    const auto exact = exact_hits(tracer, rays);
    std::uint64_t hit = 0, hit_rightwards = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      hit += exact[i].has_value();
      hit_rightwards += exact[i].has_value() && rays[i].direction.x > 0;
    }
    EXPECT_GT(hit, rays.size() / 2);
    const auto sah = find_ray_structure("sah", {}).make(moved, {});
    EXPECT_EQ(wrong_hits(tracer, *sah, rays, exact), 0u);
    EXPECT_EQ(wrong_occlusions(tracer, *sah, rays, exact), 0u);
    const Leaking leaking(find_ray_structure("sah", {}).make(moved, {}));
    // All are counted but those that touch the outline.
    EXPECT_NEAR(static_cast<double>(wrong_hits(tracer, leaking, rays, exact)), static_cast<double>(hit_rightwards),
                0.02 * static_cast<double>(hit));
    EXPECT_NEAR(static_cast<double>(wrong_occlusions(tracer, leaking, rays, exact)), static_cast<double>(hit_rightwards),
                0.02 * static_cast<double>(hit));
  }
}

// Rays through the tip of a mesh's open corner, where the nearest hit is within rounding of a triangle.
TEST(AccelCheck, WhatBlocksARayIsJudgedLikeItsNearestHit) {
  const Scene scene = load_scene("builtin:glass-caustic");
  const ExactTracer tracer(scene);
  const auto structure = find_ray_structure("binned-sah", {}).make(scene, {});
  for (const std::uint64_t at : {128271u, 188934u}) {
    const std::vector<Ray> ray = etendue::aimed_rays(scene, at, 1);
    const auto exact = exact_hits(tracer, ray);
    EXPECT_TRUE(structure->occluded(ray[0]));
    EXPECT_EQ(wrong_hits(tracer, *structure, ray, exact), 0u);
    EXPECT_EQ(wrong_occlusions(tracer, *structure, ray, exact), 0u);
  }
}

TEST(AccelRays, RecordedRaysAreThoseOfTheRenderAndTheSameEachTime) {
  const Scene scene = load_scene("builtin:cornell-spheres");
  const auto tracer = find_ray_structure("sah", {}).make(scene, {}), brute = find_ray_structure("brute", {}).make(scene, {});
  const RaysByKind rays = record_rays(scene, *tracer, 32), again = record_rays(scene, *brute, 32);
  const vec3 eye = scene.camera.to_world.point(vec3(0));
  for (const RayKind kind : ray_kinds) {
    SCOPED_TRACE(ray_kind_name(kind));
    const std::size_t k = index_of(kind);
    EXPECT_GT(rays[k].size(), 32u * 32 / 2);
    EXPECT_LE(rays[k].size(), 32u * 32);
    ASSERT_EQ(rays[k].size(), again[k].size());
    for (std::size_t i = 0; i < rays[k].size(); ++i) {
      ASSERT_EQ(rays[k][i].origin, again[k][i].origin);
      ASSERT_EQ(rays[k][i].direction, again[k][i].direction);
      ASSERT_EQ(glm::distance(rays[k][i].origin, eye) < 1e-3f, kind == RayKind::primary);
      ASSERT_EQ(std::isfinite(rays[k][i].t_max), kind == RayKind::shadow);
    }
  }
  EXPECT_EQ(rays[index_of(RayKind::primary)].size(), 32u * 32);
}

TEST(AccelRays, SceneWithoutLightsStillGivesEveryKind) {
  Scene scene = scene_of(closed_sphere(8, 16));
  scene.materials.emplace_back(Diffuse{});
  scene.objects[0].shapes.push_back({.primitive_count = scene.objects[0].geometry.primitive_count()});
  finish_scene(scene, {});
  scene.camera.to_world = *Transform::look_at({0, 0, -4}, {0, 0, 0}, {0, 1, 0});
  const auto rays = record_rays(scene, *find_ray_structure("sah", {}).make(scene, {}), 32);
  for (const RayKind kind : ray_kinds) EXPECT_GT(rays[index_of(kind)].size(), 0u) << ray_kind_name(kind);
  EXPECT_TRUE(scene.lights.empty());
}

TEST(AccelRays, RunsAreSpreadFromTheFirstRayToTheLast) {
  std::vector<Ray> rays(1000);
  for (std::size_t i = 0; i < rays.size(); ++i) rays[i].t_min = static_cast<float>(i);
  const std::vector<Ray> kept = spread_runs(rays, 256);
  ASSERT_EQ(kept.size(), 256u);
  EXPECT_EQ(kept.front().t_min, 0);
  EXPECT_EQ(kept.back().t_min, 999);
  EXPECT_EQ(kept[63].t_min, 63);
  EXPECT_EQ(spread_runs(rays, 10).size(), 10u);
  EXPECT_EQ(spread_runs(rays, 5000).size(), 1000u);
}

TEST(AccelComparison, StructuresAreRightOnASceneAndAreMeasured) {
  const Scene scene = load_scene("builtin:cornell-box");
  std::vector<Method> choices;
  for (const RayEntry& entry : ray_structures())
    if (entry.available) choices.push_back({entry.name, {}, {}});
  choices.push_back({"binned-sah", {{"bins", {std::int64_t{4}, {}}}}, {}});
  std::size_t lines = 0;
  StructureTiming options;
  options.resolution = 32;
  options.repetitions = 2;
  options.threads = 2;
  options.check_rays = 4000;
  options.budget_s = 1e4;
  const std::vector<StructureRecord> records =
      compare_structures(scene, choices, options, [&](const std::string& line) { lines += !line.empty(); });
  ASSERT_EQ(records.size(), choices.size());
  EXPECT_GT(lines, choices.size());
  for (const StructureRecord& record : records) {
    SCOPED_TRACE(record.structure);
    if (!is_third_party(record)) {
      EXPECT_EQ(record.disagreements, 0u);
      EXPECT_GT(record.primitives_per_ray, 0);
    }
    EXPECT_GT(record.checked, 4000u + 32 * 32 * 4);
    EXPECT_EQ(record.triangles, scene.triangle_count());
    EXPECT_GT(record.build_s.median, 0);
    EXPECT_LE(record.build_s.low, record.build_s.median);
    EXPECT_GE(record.build_s.high, record.build_s.median);
    EXPECT_GT(record.parallel_build_s.median, 0);
    EXPECT_GT(record.bytes, 0u);
    for (const RayKind kind : ray_kinds) EXPECT_GT(record.speed(kind).median, 0) << ray_kind_name(kind);
    EXPECT_EQ(record.note, "");
  }
  EXPECT_EQ(records.back().structure, "binned-sah bins=4");
  EXPECT_GT(records.back().epo_triangles, 0u);
}

// The log would keep one of the two, and time both at each run.
TEST(AccelComparison, TwoThatComeToOneLayoutAreRefused) {
  const Scene scene = load_scene("builtin:cornell-box");
  const auto in_layout = [](const std::string& layout) {
    return Method{"binned-sah", {{"layout", {layout, {}}}}, {"e.toml", 3, 5}};
  };
  const StructureTiming options{.resolution = 8, .repetitions = 1};
  const auto silent = [](const std::string&) {};
  const std::string chosen = compare_structures(scene, {in_layout("auto")}, options, silent).at(0).layout;
  EXPECT_EQ(compare_structures(scene, {in_layout("auto"), {"lbvh", {{"layout", {chosen, {}}}}, {}}}, options, silent).size(),
            2u);
  try {
    compare_structures(scene, {in_layout("auto"), in_layout(chosen)}, options, silent);
    ADD_FAILURE() << "not refused";
  } catch (const Error& e) {
    EXPECT_TRUE(std::string(e.what()).starts_with("e.toml:3:5: 'binned-sah layout=auto' has the layout " + chosen)) << e.what();
  }
}

// Cut or not, a kind weighs as much as it has rays: primary rays at 10 nodes each, shadow rays at 2.
TEST(AccelComparison, MeansOverKindsDoNotDependOnWhichAreCut) {
  RaysByKind rays;
  rays[index_of(RayKind::primary)].resize(1000);
  rays[index_of(RayKind::shadow)].resize(3000);
  const auto mean = [&](std::size_t primary, std::size_t shadow) {
    ByRayKind<std::uint64_t> counted{};
    ByRayKind<std::size_t> traced{};
    counted[index_of(RayKind::primary)] = 10 * (traced[index_of(RayKind::primary)] = primary);
    counted[index_of(RayKind::shadow)] = 2 * (traced[index_of(RayKind::shadow)] = shadow);
    return mean_over_kinds(counted, traced, rays);
  };
  EXPECT_DOUBLE_EQ(mean(1000, 3000), 4);
  EXPECT_DOUBLE_EQ(mean(1000, 30), 4);
  EXPECT_DOUBLE_EQ(mean(10, 3000), 4);
  EXPECT_DOUBLE_EQ(mean(10, 0), 10) << "nothing is known of the other kind";
  EXPECT_EQ(mean(0, 0), 0);
}

TEST(AccelComparison, WhatDoesNotFitTheBudgetIsSampledAndSaysSo) {
  const Scene scene = load_scene("builtin:mesh");
  StructureTiming options;
  options.resolution = 32;
  options.repetitions = 3;
  options.budget_s = 0.3;
  options.check_rays = 1'000'000;
  options.threads = 1;
  const StructureRecord record = compare_structures(scene, {{"brute", {}}}, options, [](const std::string&) {}).at(0);
  EXPECT_NE(record.note.find("a sample of rays: "), std::string::npos) << record.note;
  EXPECT_NE(record.note.find("checked on"), std::string::npos) << record.note;
  EXPECT_LT(record.checked, 100'000u);
  EXPECT_EQ(record.disagreements, 0u);
}

}  // namespace
}  // namespace etendue::testing
