// The memory budget of every ray structure: what exceeds it gives way, says so, and answers as brute force does; estimates
// hold.
#include "accel/registry.h"
#include "accel/scene/memory_need.h"
#include "framework/io/load_scene.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

#include <cmath>

namespace etendue::testing {
namespace {

ParamValue text(const std::string& value) { return {value, {"memory.toml", 3, 7}}; }

ParamMap budget(const std::string& memory, const std::string& over = "leaner") {
  return {{"memory", text(memory)}, {"over_memory", text(over)}};
}

std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

// Embree and CGAL may give up rays at edges and choose among ties; with a tiny budget they are not what answers.
std::vector<const RayEntry*> structures() {
  std::vector<const RayEntry*> all;
  for (const RayEntry& entry : ray_structures())
    if (entry.available) all.push_back(&entry);
  return all;
}

void expect_hits_of_brute(const RayQuery& structure, const Scene& scene, const std::string& name) {
  const auto brute = find_ray_structure("brute", {}).make(scene, {});
  for (const auto& rays : {general_rays(scene, 100, 1), aimed_rays(scene, 100, 2)})
    for (const Ray& ray : rays) {
      const Hit given = structure.closest(ray), expected = brute->closest(ray);
      ASSERT_EQ(given.primitive, expected.primitive) << name;
      ASSERT_EQ(given.instance, expected.instance) << name;
      ASSERT_EQ(given.t, expected.t) << name;
      ASSERT_EQ(given.uv, expected.uv) << name;
      ASSERT_EQ(structure.occluded(ray), static_cast<bool>(expected)) << name;
    }
}

TEST(MemoryBudget, TinyOnesFallBackAndStillGiveTheHitsOfBruteForce) {
  for (const RayCase& c : ray_cases()) {
    const auto has_primitives = [](const Object& o) { return o.geometry.primitive_count() > 0; };
    if (std::none_of(c.scene.objects.begin(), c.scene.objects.end(), has_primitives)) continue;
    for (const RayEntry* entry : structures())
      for (const char* over : {"leaner", "brute"}) {
        const auto structure = entry->make(c.scene, budget("1B", over));
        const std::string name = entry->name + " on " + c.name;
        const std::string fallback = structure->stats().fallback;
        EXPECT_NE(fallback.find("beyond its memory of 1 B: " + entry->name), std::string::npos) << name << ": " << fallback;
        EXPECT_NE(fallback.find("brute in_place=true in its place"), std::string::npos) << name << ": " << fallback;
        ASSERT_NO_FATAL_FAILURE(expect_hits_of_brute(*structure, c.scene, name));
      }
  }
}

TEST(MemoryBudget, GenerousOnesChangeNothing) {
  const Scene scene = scene_of(closed_sphere(40, 80));
  for (const RayEntry* entry : structures()) {
    const auto free = entry->make(scene, {}), bounded = entry->make(scene, budget("1GiB", "error"));
    const RayStructureStats a = free->stats(), b = bounded->stats();
    EXPECT_EQ(b.fallback, "") << entry->name;
    if (entry->name != "embree") {  // whose threads share out its arenas
      EXPECT_EQ(a.bytes, b.bytes) << entry->name;
    }
    EXPECT_EQ(a.nodes, b.nodes) << entry->name;
    EXPECT_EQ(a.layout, b.layout) << entry->name;
    for (const Ray& ray : general_rays(scene, 200, 3)) EXPECT_EQ(free->closest(ray).t, bounded->closest(ray).t) << entry->name;
  }
}

// A tree in bvh16 stands in where its own layout does not fit, brute force where no tree does.
TEST(MemoryBudget, LeanerLayoutsStandInWhereTheyFit) {
  const Scene scene = scene_of(closed_sphere(100, 200));
  const RayEntry& sah = find_ray_structure("sah", {});
  const std::uint64_t wide = sah.need(scene, {{"layout", text("bvh16")}}).peak, binary = sah.need(scene, {}).peak;
  ASSERT_LT(wide, binary);
  const auto leaner = sah.make(scene, budget(std::to_string((wide + binary) / 2) + "B"));
  EXPECT_EQ(leaner->stats().layout, "bvh16");
  EXPECT_NE(leaner->stats().fallback.find("sah layout=bvh16 in its place"), std::string::npos) << leaner->stats().fallback;
  EXPECT_LE(leaner->stats().bytes, wide);
  const auto brute = sah.make(scene, budget(std::to_string((wide + binary) / 2) + "B", "brute"));
  EXPECT_NE(brute->stats().fallback.find("brute in_place=true"), std::string::npos) << brute->stats().fallback;
  EXPECT_EQ(brute->stats().bytes, 0u);
  // A structure that is no tree itself is replaced by a tree that fits.
  const std::uint64_t octree = find_ray_structure("octree", {}).need(scene, {}).peak;
  const std::uint64_t median = find_ray_structure("median", {}).need(scene, {{"layout", text("bvh16")}}).peak;
  if (median < octree) {
    const auto tree = find_ray_structure("octree", {}).make(scene, budget(std::to_string(octree - 1) + "B"));
    EXPECT_EQ(tree->stats().layout, "bvh16") << tree->stats().fallback;
  }
}

TEST(MemoryBudget, ErrorsGiveTheSizesAndThePlace) {
  Scene scene = scene_of(closed_sphere(20, 40));
  scene.name = "ball";
  for (const RayEntry* entry : structures()) {
    const std::string what = error_of([&] { entry->make(scene, budget("1KiB", "error")); });
    EXPECT_TRUE(what.starts_with("memory.toml:3:7: ball: beyond its memory of 1 KiB: " + entry->name + " would take about "))
        << what;
    EXPECT_NE(what.find("KiB, of which it would keep"), std::string::npos) << what;
  }
}

TEST(MemoryBudget, TextsThatAreNoSizesAreErrorsThatSayWhatIsExpected) {
  const Scene scene = scene_of(closed_sphere(4, 8));
  const RayEntry& sah = find_ray_structure("sah", {});
  EXPECT_EQ(error_of([&] { sah.make(scene, budget("512Mib")); }),
            "memory.toml:3:7: sah: memory: unknown unit in '512Mib': expected a size such as \"512MiB\" (units: B, kB, KB, MB, GB, "
            "KiB, MiB, GiB)");
  EXPECT_EQ(error_of([&] {
              sah.make(scene, {{"memory", {std::int64_t{512}, {"memory.toml", 3, 7}}}});
            }),
            "memory.toml:3:7: sah: memory = 512 is an integer; expected a size with its unit, such as \"512MiB\", or \"none\"");
  for (const char* bad : {"", "MiB", "-1MiB", "0B", "512", "much", "1.5B"})
    EXPECT_TRUE(error_of([&] { sah.make(scene, budget(bad)); }).starts_with("memory.toml:3:7: sah: memory")) << bad;
  EXPECT_NE(error_of([&] { sah.make(scene, budget("1GiB", "leanr")); }).find("'leaner'"), std::string::npos);
  EXPECT_NE(error_of([&] { sah.make(scene, {{"memroy", text("1GiB")}}); }).find("did you mean 'memory'"), std::string::npos);
  for (const char* good : {"none", "1GiB", "64MB", "1.5 MiB"}) EXPECT_NO_THROW(sah.make(scene, budget(good))) << good;
}

// Long thin triangles across all of space: each is in hundreds of cells, which no count of triangles tells.
Scene needles(int count) {
  Geometry geometry;
  Random random(7);
  for (int i = 0; i < count; ++i) {
    const vec3 a = 10.0f * random.direction(), b = 10.0f * random.direction();
    add_triangle(geometry, a, b, b + random.in_cube(0.05f));
  }
  return scene_of(std::move(geometry));
}

TEST(MemoryBudget, WhatGrowsIsStoppedWhileItGrows) {
  const Scene scene = needles(3000);
  const std::pair<std::string, ParamMap> growing[] = {{"grid", {{"density", {100.0, {}}}}},
                                                      {"kd-tree", {{"max_depth", {std::int64_t{40}, {}}}}},
                                                      {"octree", {{"leaf_size", {std::int64_t{1}, {}}}}},
                                                      {"sbvh", {{"duplication", {16.0, {}}}, {"alpha", {0.0, {}}}}}};
  for (const auto& [name, params] : growing) {
    const RayEntry& entry = find_ray_structure(name, {});
    const std::uint64_t estimate = entry.need(scene, params).peak;
    // Without an estimate, the watch alone stops it.
    const std::uint64_t kept = entry.build(scene, params, nullptr)->stats().bytes;
    MemoryWatch tight(kept / 2), wide(std::uint64_t{1} << 40);
    EXPECT_THROW(entry.build(scene, params, &tight), OverMemory) << name;
    EXPECT_EQ(entry.build(scene, params, &wide)->stats().bytes, kept) << name;
    // Within a budget that the estimate accepts, it either fits or a fallback says why not.
    ParamMap bounded = budget(std::to_string(estimate) + "B");
    bounded.insert(params.begin(), params.end());
    const auto structure = entry.make(scene, bounded);
    if (structure->stats().fallback.empty()) {
      EXPECT_LE(structure->stats().bytes, estimate) << name;
    } else {
      EXPECT_NE(structure->stats().fallback.find("grew beyond it while it was built"), std::string::npos)
          << structure->stats().fallback;
    }
    ASSERT_NO_FATAL_FAILURE(expect_hits_of_brute(*structure, scene, name));
  }
  for (const RayEntry& entry : ray_structures())
    if (entry.name == "embree" && entry.available) {
      MemoryWatch tight(entry.build(scene, {}, nullptr)->stats().bytes / 2);
      EXPECT_THROW(entry.build(scene, {}, &tight), OverMemory);
    }
}

// Bytes kept on each built-in scene: no more than estimated, no less than a sixth of that where there is enough to speak of.
TEST(MemoryBudget, EstimatesHoldOnTheBuiltInScenes) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    const Scene scene = builtin.make();
    if (scene.triangle_count() > 50'000) continue;
    for (const RayEntry* entry : structures()) {
      std::vector<ParamMap> variants{{}};
      if (entry->tree)
        for (const char* layout : {"bvh4", "bvh8", "bvh16"}) variants.push_back({{"layout", text(layout)}});
      for (const ParamMap& params : variants) {
        const MemoryNeed need = entry->need(scene, params);
        const std::uint64_t bytes = entry->build(scene, params, nullptr)->stats().bytes;
        const std::string name = entry->name + (params.empty() ? "" : " " + to_text(params.at("layout"))) + " on " + scene.name;
        EXPECT_GE(need.kept, bytes) << name;
        EXPECT_GE(need.peak, need.kept) << name;
        if (bytes > 100'000) {
          EXPECT_LE(need.kept, 6 * bytes) << name;
        }
      }
    }
  }
}

// The arrays between which builders move items lie on whole pages of 2 MiB as soon as they fill one: 32 bytes an item.
TEST(MemoryBudget, EstimatesCountWholePagesOfItems) {
  const auto peak = [](std::uint32_t triangles) {
    Geometry geometry;
    geometry.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    geometry.triangles.assign(triangles, {0, 1, 2});
    const MemoryNeed need = bvh_need(geometry, "bvh16", 0, false, {32});
    return static_cast<double>(need.peak - need.kept);
  };
  constexpr std::uint32_t page = 1 << 16;
  EXPECT_GT(peak(page) - peak(page - 1), 4 << 20);  // the items, and a copy
}

TEST(MemoryBudget, TreesThatChangeRefuseOne) {
  const auto what = error_of([] { find_ray_structure("sah", {}).builder(budget("1GiB")); });
  EXPECT_TRUE(what.starts_with("memory.toml:3:7: sah: ")) << what;
}

}  // namespace
}  // namespace etendue::testing
