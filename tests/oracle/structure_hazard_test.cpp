// Scenes that break structures cost them time and memory, and never an answer.
#include "experiments/kinds/stress/structure_hazard.h"
#include "framework/io/load_scene.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

StructureHazard measure(const std::string& scene, const std::string& structure, std::uint64_t seed = 1) {
  return measure_structure_hazard(load_scene(scene), Method{structure, {}, {}}, seed);
}

TEST(StructureHazard, AnswersStayRight) {
  for (const char* scene : {"builtin:coincident?copies=5", "builtin:slivers?aspect=10000,triangles=300",
                            "builtin:overlap?spread=0.3,triangles=100", "builtin:stadium?triangles=500,size=20"})
    for (const char* structure : {"binned-sah", "sbvh", "grid", "octree"})
      EXPECT_EQ(measure(scene, structure).wrong_answers, 0u) << scene << " " << structure;
}

TEST(StructureHazard, CoincidentTrianglesAreAllTested) {
  for (const char* structure : {"binned-sah", "grid", "kd-tree"}) {
    const StructureHazard few = measure("builtin:coincident?copies=4", structure),
                          many = measure("builtin:coincident?copies=16", structure);
    // A grid's cells shrink as triangles grow in number, and one that reaches into several cells is tested in each.
    EXPECT_NEAR(many.tests_per_ray / few.tests_per_ray, 4, structure == std::string("grid") ? 0.8 : 0.4) << structure;
    EXPECT_GT(many.work_per_ray(), few.work_per_ray()) << structure;
    EXPECT_LT(many.bytes_per_primitive, 2 * few.bytes_per_primitive) << structure;
  }
}

TEST(StructureHazard, CountsRepeat) {
  const StructureHazard once = measure("builtin:slivers", "ploc", 3), again = measure("builtin:slivers", "ploc", 3),
                        other = measure("builtin:slivers", "ploc", 4);
  EXPECT_EQ(once.work_per_ray(), again.work_per_ray());
  EXPECT_EQ(once.bytes, again.bytes);
  EXPECT_NE(once.work_per_ray(), other.work_per_ray());
}

TEST(StructureHazard, OfAnUnknownStructureIsAnError) { EXPECT_THROW(measure("builtin:slivers", "octre"), Error); }

}  // namespace
}  // namespace etendue
