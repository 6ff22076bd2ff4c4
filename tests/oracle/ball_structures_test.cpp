// Every ball structure of the registry against brute force: the same sets, the same bits.
#include "accel/registry.h"
#include "framework/core/parallel.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

namespace etendue::testing {
namespace {

void expect_equal(const Neighbours& given, const Neighbours& expected) {
  ASSERT_EQ(given.size(), expected.size());
  for (std::size_t i = 0; i < given.size(); ++i) {
    ASSERT_EQ(given[i].id, expected[i].id) << i;
    ASSERT_EQ(given[i].distance_squared, expected[i].distance_squared) << i;
  }
}

struct BallCase {
  std::string name;
  Bounds bounds;
  std::function<vec3(Random&)> centre;
  std::function<float(Random&)> radius;
};

std::vector<BallCase> ball_cases() {
  const auto in_cube = [](Random& r) { return r.in_cube(1); };
  const Bounds unit{vec3(-1), vec3(1)};
  return {
      {"even", unit, in_cube, [](Random& r) { return r.between(0, 0.2f); }},
      {"all sizes", unit, in_cube, [](Random& r) { return std::exp2(r.between(-40, 6)); }},
      {"points", unit, in_cube, [](Random&) { return 0.0f; }},
      {"at the origin", unit, [](Random&) { return vec3(0); }, [](Random& r) { return r.below(2) * 1e-6f; }},
      {"everything and nothing", unit, in_cube, [](Random& r) { return r.below(2) ? infinity : -1.0f; }},
      {"outside the bounds", unit, [](Random& r) { return 100.0f * r.in_cube(1); }, [](Random& r) { return r.between(0, 5); }},
      {"far outside", unit, [](Random& r) { return r.in_cube(1) * std::exp2(r.between(0, 90)); },
       [](Random& r) { return std::exp2(r.between(-10, 40)); }},
      {"no bounds", Bounds{}, in_cube, [](Random& r) { return r.unit(); }},
      {"a point for bounds", Bounds{vec3(3), vec3(3)}, in_cube, [](Random& r) { return r.unit(); }},
      {"far from the origin", Bounds{vec3(1e6f), vec3(1e6f + 1)}, [](Random& r) { return vec3(1e6f) + r.in_cube(1); },
       [](Random& r) { return r.between(0, 0.3f); }},
  };
}

TEST(BallStructures, CoveringFindsWhatBruteForceFinds) {
  for (const BallCase& c : ball_cases())
    for (const BallEntry& entry : ball_structures()) {
      if (entry.name == "brute") continue;
      SCOPED_TRACE(c.name + ", " + entry.name);
      Random random(41);
      const auto structure = entry.make(c.bounds), brute = find_ball_structure("brute", {}).make(c.bounds);
      std::vector<vec3> centres;
      std::vector<float> radii;
      Neighbours given, expected;
      for (std::uint32_t id = 0; id < 1500; ++id) {
        centres.push_back(c.centre(random));
        radii.push_back(c.radius(random));
        structure->insert(centres.back(), radii.back(), id);
        brute->insert(centres.back(), radii.back(), id);
        // Queries between insertions, about the rim of a ball.
        const std::size_t near = random.below(id + 1);
        const float reach = std::isfinite(radii[near]) ? radii[near] : 1;
        const vec3 p =
            id % 3 == 0 ? c.centre(random) : centres[near] + random.direction() * (reach * (id % 3 == 1 ? 1.0f : 0.9f));
        structure->covering(p, given);
        brute->covering(p, expected);
        ASSERT_NO_FATAL_FAILURE(expect_equal(given, expected)) << "after " << id;
      }
    }
}

TEST(BallStructures, WhatIsNotFiniteCoversAndFindsNothing) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  for (const BallEntry& entry : ball_structures()) {
    const auto structure = entry.make({vec3(-1), vec3(1)});
    structure->insert(vec3(nan, 0, 0), 1, 0);
    structure->insert(vec3(infinity, 0, 0), 1, 1);
    structure->insert(vec3(0), nan, 2);
    Neighbours found;
    structure->covering(vec3(0), found);
    EXPECT_TRUE(found.empty()) << entry.name;
    structure->insert(vec3(0), 1, 3);
    structure->covering(vec3(nan, 0, 0), found);
    EXPECT_TRUE(found.empty()) << entry.name;
  }
}

}  // namespace
}  // namespace etendue::testing
