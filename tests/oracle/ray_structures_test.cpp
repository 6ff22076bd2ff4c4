// Every ray structure of the registry against brute force, and brute force against double precision.
#include "accel/bvh/bvh.h"
#include "accel/exact/exact.h"
#include "accel/registry.h"
#include "accel/scene/two_level.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

namespace etendue::testing {
namespace {

struct Variant {
  std::string name;
  ParamMap params;
};

std::string to_text(const Variant& variant) {
  std::string text = variant.name;
  for (const auto& [key, value] : variant.params) text += " " + key + "=" + etendue::to_text(value);
  return text;
}

ParamMap with(const std::string& key, const ParamValue& value) { return {{key, value}}; }
ParamValue integer(std::int64_t i) { return {i, {}}; }

ParamMap most_robust(const RayEntry& entry) { return entry.name == "embree" ? ParamMap{{"robust", {true, {}}}} : ParamMap{}; }

// The structures that share brute force's own arithmetic, at ordinary and extreme parameters.
std::vector<Variant> variants() {
  std::vector<Variant> all;
  for (const RayEntry& entry : ray_structures()) {
    if (is_adapter(entry.name) || entry.name == "brute") continue;
    all.push_back({entry.name, {}});
    const auto has = [&](const char* key) {
      return std::any_of(entry.params.begin(), entry.params.end(), [&](const ParamInfo& info) { return info.name == key; });
    };
    const std::string leaf_size = has("triangle_threshold") ? "triangle_threshold" : "leaf_size";
    if (!has(leaf_size.c_str()) || !has("max_depth")) continue;
    all.push_back({entry.name, with(leaf_size, integer(1))});
    all.push_back({entry.name, with("max_depth", integer(1))});
    if (entry.name == "octree") continue;
    all.push_back({entry.name, {{leaf_size, integer(1)}, {"max_depth", integer(1024)}}});
    all.push_back({entry.name, {{leaf_size, integer(64)}, {"max_depth", integer(3)}}});
  }
  for (const char* layout : {"bvh4", "bvh8", "bvh16", "auto"}) {
    const ParamValue value{std::string(layout), {}};
    for (const char* builder : {"median", "sah", "binned-sah", "sbvh", "ploc"}) all.push_back({builder, with("layout", value)});
    all.push_back({"binned-sah", {{"layout", value}, {"max_depth", integer(2)}}});
    all.push_back({"median", {{"layout", value}, {"reinsertion", integer(10)}}});
    all.push_back({"binned-sah", {{"layout", value}, {"leaf_size", integer(1)}, {"max_depth", integer(1024)}}});
  }
  for (const std::int64_t cells : {1, 7, 1000}) all.push_back({"grid", with("max_cells", integer(cells))});
  for (const double density : {0.01, 1000.0}) all.push_back({"grid", with("density", {density, {}})});
  all.push_back({"kd-tree", with("max_depth", integer(1))});
  all.push_back({"kd-tree", {{"max_depth", integer(64)}, {"primitive_cost", {100.0, {}}}}});
  all.push_back({"kd-tree", {{"max_depth", integer(64)}, {"bins", integer(2)}}});
  all.push_back({"binned-sah", with("bins", integer(2))});
  all.push_back({"binned-sah", with("bins", integer(256))});
  all.push_back({"sah", with("primitive_cost", {10.0, {}})});
  all.push_back({"midpoint", with("reinsertion", integer(10))});
  all.push_back({"sbvh", {{"alpha", {0.0, {}}}, {"duplication", {4.0, {}}}}});
  return all;
}

std::unique_ptr<RayQuery> make(const Variant& variant, const Scene& scene) {
  return find_ray_structure(variant.name, {}).make(scene, variant.params);
}

std::string describe_ray(const Ray& ray) {
  char text[256];
  std::snprintf(text, sizeof text, "origin (%a, %a, %a) direction (%a, %a, %a) t (%a, %a]", ray.origin.x, ray.origin.y,
                ray.origin.z, ray.direction.x, ray.direction.y, ray.direction.z, ray.t_min, ray.t_max);
  return text;
}

// The same surface at the same distance: both work in the same arithmetic, so the bits agree. Primitives at equal distance have
// one winner, the lowest.
void expect_same(const Hit& given, const Hit& expected, const Ray& ray) {
  ASSERT_EQ(static_cast<bool>(given), static_cast<bool>(expected)) << describe_ray(ray);
  if (!expected) return;
  ASSERT_EQ(given.t, expected.t) << describe_ray(ray);
  ASSERT_EQ(given.instance, expected.instance) << describe_ray(ray);
  ASSERT_EQ(given.primitive, expected.primitive) << describe_ray(ray);
  ASSERT_EQ(given.uv, expected.uv) << describe_ray(ray);
}

void expect_agreement(const RayQuery& structure, const RayQuery& brute, const std::vector<Ray>& rays) {
  std::vector<Hit> hits(rays.size());
  structure.closest(rays, hits);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Ray& ray = rays[i];
    const Hit expected = brute.closest(ray);
    ASSERT_NO_FATAL_FAILURE(expect_same(hits[i], expected, ray));
    TraversalCounters counters;
    ASSERT_NO_FATAL_FAILURE(expect_same(structure.closest_counted(ray, counters), expected, ray));
    ASSERT_EQ(structure.occluded(ray), static_cast<bool>(expected)) << describe_ray(ray);
    ASSERT_EQ(structure.occluded_counted(ray, counters), static_cast<bool>(expected)) << describe_ray(ray);
    if (!expected) continue;
    Ray shortened = ray;  // to just behind the hit, and to just before it
    shortened.t_max = std::min(ray.t_max, expected.t * (1 + 1e-4f));
    ASSERT_TRUE(structure.occluded(shortened)) << describe_ray(shortened);
    shortened.t_max = expected.t * (1 - 1e-4f);
    ASSERT_EQ(structure.occluded(shortened), brute.occluded(shortened)) << describe_ray(shortened);
  }
}

TEST(RayStructures, RandomAndAxisParallelRaysFindWhatBruteForceFinds) {
  for (const RayCase& c : ray_cases()) {
    const auto brute = make({"brute", {}}, c.scene);
    const std::vector<Ray> rays = general_rays(c.scene, 400, 1);
    for (const Variant& variant : variants()) {
      SCOPED_TRACE(c.name + ", " + to_text(variant));
      ASSERT_NO_FATAL_FAILURE(expect_agreement(*make(variant, c.scene), *brute, rays));
    }
  }
}

TEST(RayStructures, RaysAtEdgesAndVerticesAndFromFacesFindWhatBruteForceFinds) {
  for (const RayCase& c : ray_cases()) {
    const auto brute = make({"brute", {}}, c.scene);
    const std::vector<Ray> rays = aimed_rays(c.scene, 400, 2);
    for (const Variant& variant : variants()) {
      SCOPED_TRACE(c.name + ", " + to_text(variant));
      ASSERT_NO_FATAL_FAILURE(expect_agreement(*make(variant, c.scene), *brute, rays));
    }
  }
}

// The series shrinks below what single precision can tell apart from the rays' distance.
std::vector<RayCase> cases_of_ordinary_scale() {
  std::vector<RayCase> cases = ray_cases();
  std::erase_if(cases, [](const RayCase& c) { return c.name == "geometric series"; });
  return cases;
}

TEST(RayStructures, BruteForceIsRightByDoublePrecision) {
  for (const RayCase& c : cases_of_ordinary_scale()) {
    SCOPED_TRACE(c.name);
    const auto brute = make({"brute", {}}, c.scene);
    for (const Ray& ray : general_rays(c.scene, 1000, 3)) {
      const Hit hit = brute->closest(ray);
      ASSERT_TRUE(is_right(c.scene, ray, hit, exact_closest(c.scene, ray))) << describe_ray(ray) << " t " << hit.t;
    }
  }
}

TEST(RayStructures, AdaptersAreRightByDoublePrecision) {
  for (const RayEntry& entry : ray_structures()) {
    if (!is_adapter(entry.name) || !entry.available) continue;
    for (const RayCase& c : cases_of_ordinary_scale()) {
      SCOPED_TRACE(entry.name + ", " + c.name);
      const auto structure = entry.make(c.scene, most_robust(entry));
      for (const Ray& ray : general_rays(c.scene, 1000, 4)) {
        const Hit hit = structure->closest(ray);
        ASSERT_TRUE(is_right(c.scene, ray, hit, exact_closest(c.scene, ray))) << describe_ray(ray) << " t " << hit.t;
        ASSERT_EQ(structure->occluded(ray), static_cast<bool>(hit)) << describe_ray(ray);
      }
    }
  }
}

TEST(RayStructures, AdaptersAnswerManyRaysAtOnceRightly) {
  std::vector<Variant> adapters;
  for (const RayEntry& entry : ray_structures()) {
    if (!is_adapter(entry.name) || !entry.available) continue;
    adapters.push_back({entry.name, most_robust(entry)});
    if (entry.name != "embree") continue;
    for (const char* batches : {"single", "coherent"}) {
      adapters.push_back(adapters.back());
      adapters.back().params["batches"] = {std::string(batches), {}};
    }
  }
  for (const Variant& adapter : adapters)
    for (const RayCase& c : cases_of_ordinary_scale()) {
      SCOPED_TRACE(to_text(adapter) + ", " + c.name);
      const auto structure = make(adapter, c.scene);
      const std::vector<Ray> rays = general_rays(c.scene, 1001, 4);  // the last stream is not a full one
      std::vector<Hit> hits(rays.size());
      const std::unique_ptr<bool[]> occluded(new bool[rays.size()]);
      structure->closest(rays, hits);
      structure->occluded(rays, std::span(occluded.get(), rays.size()));
      for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_TRUE(is_right(c.scene, rays[i], hits[i], exact_closest(c.scene, rays[i]))) << describe_ray(rays[i]);
        ASSERT_EQ(occluded[i], static_cast<bool>(hits[i])) << describe_ray(rays[i]);
      }
    }
}

TEST(RayStructures, NoRayLeavesAClosedMeshThroughItsEdges) {
  const Scene scene = scene_of(closed_sphere(20, 40));
  std::vector<Ray> rays = aimed_rays(scene, 3000, 5);
  Random random(6);
  for (Ray& ray : rays) {
    const vec3 target = ray.at(1);
    ray.origin = random.in_cube(0.4f);
    ray.direction = target - ray.origin;
  }
  for (const RayEntry& entry : ray_structures()) {
    if (!entry.available || entry.name == "cgal") continue;  // whose leaks are stated in cgal.h
    const auto structure = entry.make(scene, most_robust(entry));
    std::size_t leaks = 0;
    for (const Ray& ray : rays) leaks += !structure->closest(ray);
    EXPECT_EQ(leaks, 0u) << entry.name;
  }
}

TEST(RayStructures, RaysThatAreNotFiniteMiss) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  for (const RayCase& c : ray_cases()) {
    for (const RayEntry& entry : ray_structures()) {
      if (!entry.available) continue;
      const auto structure = entry.make(c.scene, {});
      for (const float bad : {nan, infinity, -infinity})
        for (int axis = 0; axis < 3; ++axis) {
          Ray origin{{0, 0, -5}, 0, {0, 0, 1}, infinity}, direction = origin, limit = origin;
          origin.origin[axis] = direction.direction[axis] = bad;
          limit.t_max = nan;
          for (const Ray& ray : {origin, direction, limit, Ray{{0, 0, 0}, 0, {0, 0, 0}, infinity}}) {
            EXPECT_FALSE(structure->closest(ray)) << entry.name << " on " << c.name;
            EXPECT_FALSE(structure->occluded(ray)) << entry.name << " on " << c.name;
          }
        }
    }
  }
}

TEST(RayStructures, EqualPrimitivesGiveTheLowest) {
  for (const RayCase& c : ray_cases()) {
    if (c.name != "pile of equals") continue;
    for (const Variant& variant : variants()) {
      const Hit hit = make(variant, c.scene)->closest({{0, -0.2f, -5}, 0, {0, 0, 1}, infinity});
      ASSERT_TRUE(hit);
      EXPECT_EQ(hit.primitive, 0u) << to_text(variant);
    }
  }
}

TEST(RayStructures, EqualInstancesGiveTheLowest) {
  Geometry g;
  add_triangle(g, {-1, -1, 0}, {1, -1, 0}, {0, 1, 0});
  Scene scene;
  scene.objects.resize(2);
  scene.objects[1].geometry = g;
  for (int i = 0; i < 20; ++i) scene.instances.push_back({1, Transform::translate({0, 0, 2})});
  for (const Variant& variant : variants())
    EXPECT_EQ(make(variant, scene)->closest({{0, 0, 0}, 0, {0, 0, 1}, infinity}).instance, 1u) << to_text(variant);
}

// A tree as deep as it can be: each inner node holds a leaf of one item and the rest.
BinaryTree chain(const BuildItems& items) {
  BinaryTree tree;
  Bounds rest;
  for (const BuildItem& item : items) rest.extend(item.bounds);
  tree.nodes.push_back({rest, 1, 0});
  for (std::uint32_t i = 0; i + 1 < items.size(); ++i) {
    tree.primitives.push_back(items[i].id);
    tree.nodes.push_back({items[i].bounds, i, 1});
    tree.nodes.push_back({rest, static_cast<std::uint32_t>(tree.nodes.size()) + 1, 0});
  }
  tree.primitives.push_back(items.back().id);
  tree.nodes.back() = {items.back().bounds, static_cast<std::uint32_t>(items.size()) - 1, 1};
  tree.depth = static_cast<std::uint32_t>(items.size()) - 1;
  return tree;
}

TEST(RayStructures, TreesDeeperThanTheFixedStackNestWithoutOverflow) {
  Random random(8);
  Scene scene;
  scene.objects.resize(2);
  for (int i = 0; i < 300; ++i) {
    const vec3 centre = random.in_cube(1);
    add_triangle(scene.objects[1].geometry, centre + random.in_cube(0.2f), centre + random.in_cube(0.2f), centre);
  }
  for (int i = 0; i < 100; ++i) scene.instances.push_back({1, Transform::translate(random.in_cube(3))});
  std::vector<Bvh> bottoms;
  bottoms.emplace_back(scene.objects[0].geometry, BinaryTree());
  bottoms.emplace_back(scene.objects[1].geometry, chain(build_items(scene.objects[1].geometry)));
  const RayAdapter structure(TwoLevel(std::move(bottoms), scene, chain(instance_items(scene))));
  EXPECT_EQ(structure.stats().depth, 299u + 99u);
  expect_agreement(structure, *make({"brute", {}}, scene), aimed_rays(scene, 100, 9));
}

// Such structures list a primitive in each cell that it touches, or in each part of it.
bool cuts_space(const std::string& name) { return name == "grid" || name == "kd-tree" || name == "octree" || name == "sbvh"; }

TEST(RayStructures, StatsTellWhatIsHeld) {
  for (const RayCase& c : ray_cases()) {
    std::uint64_t valid = 0;
    for (const Object& object : c.scene.objects) valid += object.geometry.valid_primitives().size();
    if (!c.scene.has_instances()) valid = c.scene.objects[0].geometry.valid_primitives().size();
    for (const Variant& variant : variants()) {
      SCOPED_TRACE(c.name + ", " + to_text(variant));
      const RayStructureStats stats = make(variant, c.scene)->stats();
      EXPECT_GE(stats.references, valid);
      if (!cuts_space(variant.name)) {
        EXPECT_EQ(stats.references, valid);
      }
      EXPECT_TRUE(std::isfinite(stats.sah_cost));
      EXPECT_EQ(stats.bytes > 0, valid > 0 || !c.scene.planes.empty());
    }
  }
}

}  // namespace
}  // namespace etendue::testing
