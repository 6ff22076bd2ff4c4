// Every point and ball structure of the registry against brute force: the same sets, the same bits.
#include "accel/registry.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

namespace etendue::testing {
namespace {

struct Cloud {
  std::string name;
  std::vector<vec3> points;
};

std::vector<vec3> points(int count, const std::function<vec3(int)>& place) {
  std::vector<vec3> result;
  for (int i = 0; i < count; ++i) result.push_back(place(i));
  return result;
}

std::vector<Cloud> clouds() {
  Random random(21);
  std::vector<Cloud> all;
  all.push_back({"none", {}});
  all.push_back({"one", {vec3(1, 2, 3)}});
  all.push_back({"coincident", points(300, [](int) { return vec3(0.1f, 0.2f, 0.3f); })});
  all.push_back({"few places", points(1000, [&](int) { return vec3(random.below(3), 0, 0); })});
  all.push_back(
      {"axis-aligned floor", points(5000, [&](int) { return vec3(random.between(-1, 1), 0.7f, random.between(-1, 1)); })});
  all.push_back({"cube", points(5000, [&](int) { return random.in_cube(1); })});
  all.push_back({"lattice", points(4096, [](int i) { return vec3(i % 16, i / 16 % 16, i / 256); })});
  all.push_back({"line", points(2000, [&](int) { return vec3(random.unit(), 0, 0); })});
  all.push_back({"caustic", points(5000, [&](int i) { return random.in_cube(i % 2 ? 1e-4f : 1.0f); })});
  all.push_back({"far", points(2000, [&](int) { return vec3(1e6f) + random.in_cube(1); })});
  all.push_back({"series", points(2000, [](int i) { return vec3(std::ldexp(1.0f, -(i % 120)), 0, 0); })});
  all.push_back({"large", points(100000, [&](int) { return vec3(random.in_cube(1).x, random.unit(), 0); })});
  return all;
}

// In, on the boundary of, one ulp outside and far from the cloud.
std::vector<vec3> query_points(const Cloud& cloud, int count, Random& random) {
  Bounds b;
  for (const vec3& p : cloud.points) b.extend(p);
  if (b.empty()) b = {vec3(-1), vec3(1)};
  std::vector<vec3> result;
  for (int i = 0; i < count; ++i) {
    vec3 p = b.lower + vec3(random.unit(), random.unit(), random.unit()) * b.diagonal();
    const int axis = static_cast<int>(random.below(3));
    switch (i % 6) {
      case 0:
        p[axis] = std::nextafter(b.lower[axis], -infinity);
        break;
      case 1:
        p[axis] = std::nextafter(b.upper[axis], infinity);
        break;
      case 2:
        p = cloud.points.empty() ? p : cloud.points[random.below(static_cast<std::uint32_t>(cloud.points.size()))];
        break;
      case 3:
        p += random.in_cube(1) * (1 + max_component(b.diagonal()));
        break;
      default:
        break;
    }
    result.push_back(p);
  }
  return result;
}

Neighbours sorted_by_id(Neighbours n) {
  std::sort(n.begin(), n.end(), [](const Neighbour& a, const Neighbour& b) { return a.id < b.id; });
  return n;
}

void expect_equal(const Neighbours& given, const Neighbours& expected) {
  ASSERT_EQ(given.size(), expected.size());
  for (std::size_t i = 0; i < given.size(); ++i) {
    ASSERT_EQ(given[i].id, expected[i].id) << i;
    ASSERT_EQ(given[i].distance_squared, expected[i].distance_squared) << i;
  }
}

template <class Check>
void for_each_structure(const Check& check) {
  for (const Cloud& cloud : clouds()) {
    const auto brute = find_point_structure("brute", {}).make();
    brute->build(cloud.points);
    for (const PointEntry& entry : point_structures()) {
      if (entry.name == "brute") continue;
      SCOPED_TRACE(cloud.name + ", " + entry.name);
      const auto structure = entry.make();
      structure->build(cloud.points);
      check(cloud, *structure, *brute);
    }
  }
}

TEST(PointStructures, WithinFindsWhatBruteForceFinds) {
  for_each_structure([](const Cloud& cloud, const PointQuery& structure, const PointQuery& brute) {
    Random random(31);
    Neighbours given, expected;
    for (const vec3& p : query_points(cloud, cloud.points.size() > 50000 ? 12 : 120, random))
      for (const float r : {0.0f, 1e-30f, 1e-3f, 0.05f, 1.0f, std::sqrt(2.0f), 30.0f, 1e10f, infinity, -1.0f}) {
        structure.within(p, r, given);
        brute.within(p, r, expected);
        ASSERT_NO_FATAL_FAILURE(expect_equal(sorted_by_id(given), expected)) << "radius " << r;
      }
  });
}

TEST(PointStructures, RadiusThatEqualsADistanceFindsThatPoint) {
  for_each_structure([](const Cloud& cloud, const PointQuery& structure, const PointQuery& brute) {
    Random random(32);
    Neighbours given, expected;
    for (const vec3& p : query_points(cloud, 60, random)) {
      if (cloud.points.empty()) return;
      const vec3& target = cloud.points[random.below(static_cast<std::uint32_t>(cloud.points.size()))];
      const float r = glm::length(target - p);
      structure.within(p, r, given);
      brute.within(p, r, expected);
      ASSERT_NO_FATAL_FAILURE(expect_equal(sorted_by_id(given), expected)) << "radius " << r;
    }
  });
}

TEST(PointStructures, NearestFindsWhatBruteForceFindsInItsOrder) {
  for_each_structure([](const Cloud& cloud, const PointQuery& structure, const PointQuery& brute) {
    Random random(33);
    Neighbours given, expected;
    for (const vec3& p : query_points(cloud, cloud.points.size() > 50000 ? 6 : 60, random))
      for (const std::size_t k : {std::size_t{0}, std::size_t{1}, std::size_t{7}, std::size_t{50}, cloud.points.size() + 5})
        for (const float r : {0.0f, 0.1f, 2.0f, infinity}) {
          structure.nearest(p, k, r, given);
          brute.nearest(p, k, r, expected);
          ASSERT_NO_FATAL_FAILURE(expect_equal(given, expected)) << "k " << k << " radius " << r;
        }
  });
}

TEST(PointStructures, QueriesThatAreNotFiniteFindNothing) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  for_each_structure([](const Cloud&, const PointQuery& structure, const PointQuery&) {
    Neighbours found;
    for (const vec3& p : {vec3(nan, 0, 0), vec3(0, infinity, 0)}) {
      structure.within(p, 1, found);
      EXPECT_TRUE(found.empty());
      structure.nearest(p, 3, infinity, found);
      EXPECT_TRUE(found.empty());
    }
    structure.within(vec3(0), nan, found);
    EXPECT_TRUE(found.empty());
  });
}

TEST(PointStructures, BuildingAgainForgetsTheFormerPoints) {
  const std::vector<vec3> first{vec3(0), vec3(1)}, second{vec3(5)};
  for (const PointEntry& entry : point_structures()) {
    const auto structure = entry.make();
    structure->build(first);
    structure->build(second);
    Neighbours found;
    structure->within(vec3(0), 100, found);
    ASSERT_EQ(found.size(), 1u) << entry.name;
    EXPECT_EQ(found[0].distance_squared, 75) << entry.name;
    structure->build({});
    structure->within(vec3(0), 100, found);
    EXPECT_TRUE(found.empty()) << entry.name;
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

TEST(Registry, UnknownNamesAreErrorsThatNameTheNearest) {
  for (const std::function<void()>& lookup : {std::function<void()>([] { find_ray_structure("binned-sha", {"here"}); }),
                                              std::function<void()>([] { find_point_structure("kdtree", {"here"}); }),
                                              std::function<void()>([] { find_ball_structure("octre", {"here"}); })}) {
    try {
      lookup();
      FAIL();
    } catch (const Error& e) {
      const std::string what = e.what();
      EXPECT_TRUE(what.starts_with("here: ")) << what;
      EXPECT_TRUE(what.find("binned-sah") != what.npos || what.find("kd-tree") != what.npos || what.find("octree") != what.npos)
          << what;
    }
  }
}

TEST(Registry, EveryListedParameterIsReadAndUnknownOnesAreErrors) {
  const Scene scene = scene_of(closed_sphere(4, 8));
  for (const RayEntry& entry : ray_structures()) {
    if (!entry.available) continue;
    for (const ParamInfo& info : entry.params)
      EXPECT_NO_THROW(entry.make(scene, {{info.name, parse_param_value(info.default_value, {})}}))
          << entry.name << " " << info.name;
    EXPECT_THROW(entry.make(scene, {{"colour", parse_param_value("3", {})}}), Error) << entry.name;
  }
}

}  // namespace
}  // namespace etendue::testing
