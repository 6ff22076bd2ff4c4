// The variants that claims are measured on find what the product finds.
#include "experiments/config/config.h"
#include "experiments/kinds/claims/cache_model.h"
#include "experiments/kinds/claims/claim_scenes.h"
#include "experiments/kinds/claims/claims.h"
#include "experiments/kinds/claims/measurement.h"
#include "experiments/kinds/claims/naive_loop.h"
#include "experiments/kinds/claims/task_shapes.h"
#include "experiments/kinds/claims/traversal_variants.h"
#include "framework/core/parallel.h"
#include "tests/oracle/ray_cases.h"
#include "tests/places.h"

#include "accel/registry.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

namespace etendue::testing {
namespace {

void expect_same(const Hit& expected, const Hit& found, const std::string& what) {
  ASSERT_EQ(expected.t, found.t) << what;
  ASSERT_EQ(expected.primitive, found.primitive) << what;
  ASSERT_EQ(expected.instance, found.instance) << what;
}

template <TraversalOptions options, class Slab>
void expect_traversals_agree(const VariantTree& tree, const PackedNodes& packed, const LinkedNodes& linked,
                             const RayQuery& brute, const std::vector<Ray>& rays, const std::string& what) {
  for (const Ray& ray : rays) {
    const Hit expected = brute.closest(ray);
    expect_same(expected, closest_by<options, Slab>(tree, packed, ray), what + ", packed");
    expect_same(expected, closest_by<options, Slab>(tree, linked, ray), what + ", linked");
  }
}

template <class Slab>
void expect_slab_agrees(const VariantTree& tree, const PackedNodes& packed, const LinkedNodes& linked, const RayQuery& brute,
                        const std::vector<Ray>& rays, const std::string& what) {
  expect_traversals_agree<TraversalOptions{}, Slab>(tree, packed, linked, brute, rays, what);
  expect_traversals_agree<TraversalOptions{TraversalForm::recursive, true, true}, Slab>(tree, packed, linked, brute, rays,
                                                                                        what + ", recursive");
  expect_traversals_agree<TraversalOptions{TraversalForm::iterative, false, true}, Slab>(tree, packed, linked, brute, rays,
                                                                                         what + ", unordered");
  expect_traversals_agree<TraversalOptions{TraversalForm::iterative, false, false}, Slab>(tree, packed, linked, brute, rays,
                                                                                          what + ", unpruned");
}

bool cgal_is_available() {
  return std::ranges::any_of(ray_structures(), [](const RayEntry& entry) { return entry.name == "cgal" && entry.available; });
}

TEST(ClaimVariants, TraversalsFindWhatBruteForceFinds) {
  for (const RayCase& ray_case : ray_cases()) {
    const Scene& scene = ray_case.scene;
    if (scene.has_instances() || !scene.planes.empty()) continue;
    const Geometry& geometry = scene.objects[0].geometry;
    const BinaryTree tree = find_ray_structure("binned-sah", {}).tree(geometry, {});
    if (tree.nodes.empty()) continue;
    const VariantTree variants(geometry, tree);
    const PackedNodes packed(variants.tree);
    const LinkedNodes linked(variants.tree);
    const auto brute = find_ray_structure("brute", {}).make(scene, {});
    std::vector<Ray> rays = general_rays(scene, 300, 1);
    for (const Ray& ray : testing::aimed_rays(scene, 300, 2)) rays.push_back(ray);
    expect_slab_agrees<ScalarSlab>(variants, packed, linked, *brute, rays, ray_case.name + ", scalar");
    expect_slab_agrees<LoopSlab>(variants, packed, linked, *brute, rays, ray_case.name + ", loop");
    expect_slab_agrees<DividingSlab>(variants, packed, linked, *brute, rays, ray_case.name + ", dividing");
    expect_slab_agrees<SimdSlab>(variants, packed, linked, *brute, rays, ray_case.name + ", SIMD");
  }
}

TEST(ClaimVariants, NaiveLoopsAndTreeFindWhatBruteForceFinds) {
  const Scene scene = load_claim_scene("claim:objects?count=60");
  const auto brute = find_ray_structure("brute", {}).make(scene, {});
  const NaiveLoop loop(scene, false), boxes(scene, true);
  const Geometry& geometry = scene.objects[0].geometry;
  const NaiveTree tree(geometry, find_ray_structure("binned-sah", {}).tree(geometry, {}));
  for (const Ray& ray : general_rays(scene, 2000, 3)) {
    expect_same(brute->closest(ray), loop.closest(ray), "loop");
    expect_same(brute->closest(ray), boxes.closest(ray), "boxes");
    expect_same(brute->closest(ray), tree.closest(ray), "tree");
    ASSERT_EQ(brute->occluded(ray), loop.occluded(ray));
    ASSERT_EQ(brute->occluded(ray), boxes.occluded(ray));
  }
}

// Cylinders, rotated bars, cells, policies and the rest check themselves: each counts the answers that are not the product's.
TEST(ClaimVariants, MeasurementsAgreeAndGiveEveryQuantityOnce) {
  const ExperimentConfig config = load_config(std::string(project_folder) + "experiments/claims.toml",
                                              {true, {"timing={ resolution = 8, repetitions = 1 }"}});
  std::set<std::string> seen;
  for (const Claim& claim : choice_of<ClaimsChoice>(config).rows)
    for (const ClaimMeasure& measure : claim.measures) {
      const Measurement& measurement = *measure.measurement;
      std::string scene = measure.scenes.front();
      // The same on a small scene; a reference would take longer than all the rest.
      if (scene.starts_with("builtin:mesh") || scene.starts_with("builtin:stadium")) scene = "builtin:cornell-spheres";
      if (measurement.name == "irradiance-cache" || !seen.insert(measurement.name).second) continue;
      MeasureResult result;
      with_threads(measurement.parallel ? 2 : 1, [&] { result = measurement.run({scene, 8, 1, 2, 1}); });
      EXPECT_EQ(result.disagreements, 0u) << measurement.name;
      std::set<std::string> names;
      for (const auto& [name, value] : result.figures) {
        EXPECT_NE(measurement.quantity(name), nullptr) << measurement.name << ": " << name << " is not declared";
        EXPECT_TRUE(names.insert(name).second) << measurement.name << ": " << name << " twice";
        EXPECT_TRUE(std::isfinite(value.median) && value.low <= value.median && value.median <= value.high) << name;
      }
      EXPECT_EQ(names.size(), measurement.quantities.size()) << measurement.name;
    }
}

// Contacts apart, a mesh of which little is left gives nearly the same image; no figure is missing.
TEST(ClaimVariants, CoarserMeshesAddLittleError) {
  if (!cgal_is_available()) GTEST_SKIP() << "this build is without CGAL";
  const Measurement& measurement = find_measurement("coarse-indirect", {});
  MeasureResult result;
  with_threads(1, [&] { result = measurement.run({"builtin:mesh?triangles=4k", 8, 1}); });
  std::set<std::string> names;
  for (const auto& [name, value] : result.figures) {
    EXPECT_TRUE(std::isfinite(value.median)) << name;
    names.insert(name);
    if (name.starts_with("error_near")) {
      EXPECT_LT(value.median, 0.01) << name;
    }
  }
  for (const Quantity& quantity : measurement.quantities)  // without a gain nothing is earned
    EXPECT_TRUE(names.contains(quantity.name) || quantity.name.starts_with("earned")) << quantity.name;
  EXPECT_THROW(measurement.run({"builtin:cornell-spheres", 8, 1}), Error);
}

// A scene is not spared what it has already; an addition changes no ray's answer.
TEST(ClaimVariants, ContentsAreAddedWhereTheSceneLacksThem) {
  const auto names = [](const char* measurement, const char* scene) {
    const MeasureResult result = find_measurement(measurement, {}).run({scene, 16, 1});
    EXPECT_EQ(result.disagreements, 0u) << measurement << " on " << scene;
    std::set<std::string> found;
    for (const auto& [name, factor] : result.figures) {
      EXPECT_GT(factor.median, 0) << name;
      found.insert(name);
    }
    return found;
  };
  EXPECT_EQ(names("contents-in-rays", "builtin:cornell-box"), (std::set<std::string>{"quadrics", "planes", "instances"}));
  EXPECT_EQ(names("contents-in-rays", "builtin:cornell-spheres"), (std::set<std::string>{"planes", "instances"}));
  EXPECT_EQ(names("contents-in-images", "builtin:cornell-spheres"),
            (std::set<std::string>{"environment", "textures", "normals", "lens"}));
}

// In a scene of instances alone it is an object's leaves that rays meet: what is added stands there.
TEST(ClaimVariants, ContentsAreAddedToInstances) {
  const auto path = std::filesystem::temp_directory_path() / ("etendue-instances-" + std::to_string(getpid()) + ".pbrt");
  std::ofstream(path) << R"(LookAt 0 0 5  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
ObjectBegin "pair"
Shape "trianglemesh" "point3 P" [-1 -1 0  1 -1 0  0 1 0  -1 -1 -1  1 -1 -1  0 1 -1] "integer indices" [0 1 2 3 4 5]
ObjectEnd
ObjectInstance "pair"
Translate 1.5 0 -2
ObjectInstance "pair"
)";
  const MeasureResult result = find_measurement("contents-in-rays", {}).run({path.string(), 16, 1});
  std::filesystem::remove(path);
  EXPECT_EQ(result.disagreements, 0u);
  std::set<std::string> names;
  for (const auto& [name, factor] : result.figures) names.insert(name);
  EXPECT_EQ(names, (std::set<std::string>{"quadrics", "planes"}));
}

TEST(CacheModel, CountsTheMissesOfTheLeastRecentlyUsed) {
  alignas(64) static char memory[64 * 5];
  CacheModel cache(4 * 64, 4);  // one set
  for (int line = 0; line < 4; ++line) cache.touch(memory + 64 * line, 4);
  EXPECT_EQ(cache.misses(), 4u);
  cache.touch(memory, 64);
  EXPECT_EQ(cache.misses(), 4u) << "it is there";
  cache.touch(memory + 64 * 4, 1);  // takes the place of line 1
  cache.touch(memory, 1);
  EXPECT_EQ(cache.misses(), 5u);
  cache.touch(memory + 64, 1);
  EXPECT_EQ(cache.misses(), 6u);
  cache.touch(memory + 60, 8);
  EXPECT_EQ(cache.accesses(), 10u) << "two lines";
}

TEST(TaskShapes, EveryCutCoversEverySampleOnce) {
  const Scene scene = load_claim_scene("builtin:cornell-box");
  const auto structure = find_ray_structure("binned-sah", {}).make(scene, {});
  const TaskRenderer renderer(scene, *structure, {19, 11}, 3, 1, 1);
  const std::vector<std::uint64_t> ones(19 * 11 * 3, 1);
  for (const TaskShape shape : task_shapes) {
    EXPECT_EQ(renderer.makespan(renderer.cut(shape), ones, 1), 19 * 11 * 3) << task_shape_name(shape);
    EXPECT_GE(renderer.makespan(renderer.cut(shape), ones, 4), renderer.ideal(ones, 4)) << task_shape_name(shape);
  }
  EXPECT_EQ(renderer.cut(TaskShape::rows).size(), 11u);
  EXPECT_EQ(renderer.cut(TaskShape::tiles).size(), 6u);
}

}  // namespace
}  // namespace etendue::testing
