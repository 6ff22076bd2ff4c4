// Instances at the limits: a million of them, and objects within objects.
#include "accel/registry.h"
#include "framework/core/error.h"
#include "framework/io/pbrt/pbrt.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

#include <chrono>

namespace etendue::testing {
namespace {

constexpr int per_axis = 100;
constexpr std::uint32_t instance_count = per_axis * per_axis * per_axis;
constexpr float spacing = 3;  // of spheres whose radius is at most 1

vec3 place(std::uint32_t i) { return spacing * vec3(i % per_axis, i / per_axis % per_axis, i / (per_axis * per_axis)); }

// A lattice of spheres, turned, scaled and mirrored.
Scene million_instances() {
  Random random(11);
  Scene scene;
  scene.objects.resize(2);
  scene.objects[1].geometry = closed_sphere(8, 16);
  scene.instances.clear();
  for (std::uint32_t i = 0; i < instance_count; ++i) {
    const vec3 scale(random.between(0.5f, 1), random.between(0.5f, 1), i % 2 == 0 ? 1.0f : -1.0f);
    scene.instances.push_back({1, Transform::translate(place(i)) * Transform::rotate(random.between(0, 6), random.direction()) *
                                      Transform::scale(scale)});
  }
  return scene;
}

// Rays go from between the spheres to the centre of one, which is met first.
void expect_instances_found(const RayQuery& structure, int rays) {
  Random random(12);
  for (int k = 0; k < rays; ++k) {
    const std::uint32_t i = random.below(instance_count);
    const vec3 direction = random.direction();
    const Hit hit = structure.closest({place(i) - 1.4f * direction, 0, direction, infinity});
    ASSERT_TRUE(hit) << "instance " << i;
    ASSERT_EQ(hit.instance, i);
    ASSERT_TRUE(hit.t > 0.35f && hit.t < 1);
    ASSERT_TRUE(structure.occluded({place(i) - 1.4f * direction, 0, direction, 1}));
  }
}

void try_million(const Scene& scene, const RayEntry& entry, const ParamMap& params, double most_seconds) {
  SCOPED_TRACE(entry.name);
  const auto start = std::chrono::steady_clock::now();
  const auto structure = entry.make(scene, params);
  ASSERT_NO_FATAL_FAILURE(expect_instances_found(*structure, 20000));
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
  EXPECT_LT(time.count(), most_seconds);
  EXPECT_LT(structure->stats().bytes, std::uint64_t{256} * instance_count);
  ::testing::Test::RecordProperty(entry.name,
                                  std::to_string(time.count()) + " s, " + std::to_string(structure->stats().bytes) + " bytes");
}

TEST(Instances, AMillionBuildAndTrace) {
  const ParamMap wide{{"layout", {std::string("bvh8"), {}}}};
  try_million(million_instances(), find_ray_structure("binned-sah", {}), wide, 30);
}

TEST(LongInstances, AMillionBuildAndTraceInEveryStructure) {
  const Scene scene = million_instances();
  for (const RayEntry& entry : ray_structures())
    if (entry.available && entry.name != "brute" && entry.name != "bounds")  // which look at every instance
      try_million(scene, entry, {}, 120);
}

// As in pbrt itself, an object holds shapes and no instances. At two levels or five, the error names the place in the file.
TEST(Instances, ObjectsWithinObjectsAreAnErrorWithItsPlace) {
  const std::string shape = "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0]\n";
  std::string text = "Camera \"perspective\"\nWorldBegin\nObjectBegin \"level 0\"\n" + shape + "ObjectEnd\n";
  for (int level = 1; level < 5; ++level)
    text += "ObjectBegin \"level " + std::to_string(level) + "\"\n  Translate 1 0 0\n  ObjectInstance \"level " +
            std::to_string(level - 1) + "\"\nObjectEnd\n";
  text += "ObjectInstance \"level 4\"\n";
  try {
    parse_pbrt(text, "nested.pbrt");
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "nested.pbrt:8:18: ObjectInstance inside an object: instances do not nest");
  }
}

}  // namespace
}  // namespace etendue::testing
