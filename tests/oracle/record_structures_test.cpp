// Every record structure of the registry against brute force: the same sets, the same bits.
#include "accel/registry.h"
#include "framework/core/parallel.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

namespace etendue::testing {
namespace {

void expect_same_records(const Neighbours& given, const Neighbours& expected) {
  ASSERT_EQ(given.size(), expected.size());
  for (std::size_t i = 0; i < given.size(); ++i) {
    ASSERT_EQ(given[i].id, expected[i].id) << i;
    ASSERT_EQ(given[i].distance_squared, expected[i].distance_squared) << i;
  }
}

struct RecordCase {
  std::string name;
  Bounds bounds;
  std::function<vec3(Random&)> centre;
  std::function<float(Random&)> radius;
};

std::vector<RecordCase> record_cases() {
  const auto in_cube = [](Random& r) { return r.in_cube(1); };
  const Bounds unit{vec3(-1), vec3(1)};
  return {
      {"even", unit, in_cube, [](Random& r) { return r.between(0, 0.2f); }},
      {"all sizes", unit, in_cube, [](Random& r) { return std::exp2(r.between(-40, 6)); }},
      {"points", unit, in_cube, [](Random&) { return 0.0f; }},
      {"coincident", unit, [](Random&) { return vec3(0.3f); }, [](Random&) { return 0.1f; }},
      {"in a line", unit, [](Random& r) { return vec3(std::ldexp(1.0f, -static_cast<int>(r.below(90))), 0, 0); },
       [](Random& r) { return std::exp2(r.between(-60, -3)); }},
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

TEST(RecordStructures, CoveringFindsWhatBruteForceFinds) {
  for (const RecordCase& c : record_cases())
    for (const RecordEntry& entry : record_structures()) {
      if (entry.name == "brute") continue;
      SCOPED_TRACE(c.name + ", " + entry.name);
      Random random(41);
      const auto structure = entry.make(c.bounds), brute = find_record_structure("brute", {}).make(c.bounds);
      std::vector<vec3> centres;
      std::vector<float> radii;
      Neighbours given, expected;
      for (std::uint32_t id = 0; id < 1500; ++id) {
        centres.push_back(c.centre(random));
        radii.push_back(c.radius(random));
        structure->insert(centres.back(), radii.back(), id);
        brute->insert(centres.back(), radii.back(), id);
        // Queries between insertions, about the rim of a sphere.
        const std::size_t near = random.below(id + 1);
        const float reach = std::isfinite(radii[near]) ? radii[near] : 1;
        const vec3 p =
            id % 3 == 0 ? c.centre(random) : centres[near] + random.direction() * (reach * (id % 3 == 1 ? 1.0f : 0.9f));
        structure->covering(p, given);
        brute->covering(p, expected);
        ASSERT_NO_FATAL_FAILURE(expect_same_records(given, expected)) << "after " << id;
      }
    }
}

// Many readers at once while nobody inserts, insertions between them: each answer is the one that a lone reader gets.
TEST(RecordStructures, AnyNumberOfThreadsMayAskBetweenInsertions) {
  for (const RecordEntry& entry : record_structures()) {
    SCOPED_TRACE(entry.name);
    Random random(42);
    const auto structure = entry.make({vec3(-1), vec3(1)}), brute = find_record_structure("brute", {}).make({});
    std::uint32_t id = 0;
    for (int round = 0; round < 6; ++round) {
      for (int i = 0; i < 400; ++i, ++id) {
        const vec3 centre = random.in_cube(1);
        const float radius = std::exp2(random.between(-8, -1));
        structure->insert(centre, radius, id);
        brute->insert(centre, radius, id);
      }
      std::vector<vec3> where;
      for (int i = 0; i < 300; ++i) where.push_back(random.in_cube(1.2f));
      std::vector<Neighbours> together(where.size());
      with_threads(4,
                   [&] { parallel_for(where.size(), 1, [&](std::size_t i) { structure->covering(where[i], together[i]); }); });
      Neighbours expected;
      for (std::size_t i = 0; i < where.size(); ++i) {
        brute->covering(where[i], expected);
        ASSERT_NO_FATAL_FAILURE(expect_same_records(together[i], expected));
      }
    }
  }
}

TEST(RecordStructures, OrderOfInsertionDoesNotMatter) {
  for (const RecordEntry& entry : record_structures()) {
    SCOPED_TRACE(entry.name);
    Random random(43);
    std::vector<std::pair<vec3, float>> spheres;
    for (int i = 0; i < 3000; ++i) spheres.emplace_back(random.in_cube(1), std::exp2(random.between(-8, -2)));
    const auto forwards = entry.make({vec3(-1), vec3(1)}), backwards = entry.make({});
    for (std::uint32_t id = 0; id < spheres.size(); ++id) forwards->insert(spheres[id].first, spheres[id].second, id);
    for (std::size_t id = spheres.size(); id-- > 0;)
      backwards->insert(spheres[id].first, spheres[id].second, static_cast<std::uint32_t>(id));
    Neighbours one, other;
    for (int i = 0; i < 500; ++i) {
      const vec3 p = random.in_cube(1);
      forwards->covering(p, one);
      backwards->covering(p, other);
      ASSERT_NO_FATAL_FAILURE(expect_same_records(one, other));
    }
  }
}

TEST(LongRecordStructures, AHundredThousandBallsGiveTheSameSets) {
  for (const RecordCase& c : record_cases()) {
    SCOPED_TRACE(c.name);
    Random random(44);
    std::vector<std::unique_ptr<RecordQuery>> structures;
    for (const RecordEntry& entry : record_structures()) structures.push_back(entry.make(c.bounds));
    Neighbours given, expected;
    for (std::uint32_t id = 0; id < 100000; ++id) {
      const vec3 centre = c.centre(random);
      const float radius = c.radius(random) * 0.1f;
      for (const auto& structure : structures) structure->insert(centre, radius, id);
      if (id % 1000 != 0) continue;
      const vec3 p = c.centre(random);
      structures[0]->covering(p, expected);
      for (std::size_t i = 1; i < structures.size(); ++i) {
        SCOPED_TRACE(record_structures()[i].name);
        structures[i]->covering(p, given);
        ASSERT_NO_FATAL_FAILURE(expect_same_records(given, expected)) << "after " << id;
      }
    }
  }
}

TEST(RecordStructures, WhatIsNotFiniteCoversAndFindsNothing) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  for (const RecordEntry& entry : record_structures()) {
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
