// Every point structure of the registry against brute force: the same sets, the same bits.
#include "accel/registry.h"
#include "framework/core/parallel.h"
#include "framework/structure_names.h"
#include "tests/oracle/ray_cases.h"

#include <fmt/format.h>
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
  all.push_back({"two", {vec3(1, 2, 3), vec3(-1, 2, 3)}});
  all.push_back({"not finite", points(600, [&](int i) {
                   constexpr float nan = std::numeric_limits<float>::quiet_NaN();
                   return i % 3 == 0 ? random.in_cube(1) : vec3(i % 3 == 1 ? infinity : 0.5f, i % 6 == 2 ? nan : -infinity, 0);
                 })});
  all.push_back({"none of them finite", points(20, [](int) { return vec3(infinity, 0, 0); })});
  all.push_back({"coincident", points(300, [](int) { return vec3(0.1f, 0.2f, 0.3f); })});
  all.push_back({"few places", points(1000, [&](int) { return vec3(random.below(3), 0, 0); })});
  all.push_back(
      {"axis-aligned floor", points(5000, [&](int) { return vec3(random.between(-1, 1), 0.7f, random.between(-1, 1)); })});
  all.push_back({"cube", points(5000, [&](int) { return random.in_cube(1); })});
  all.push_back({"lattice", points(4096, [](int i) { return vec3(i % 16, i / 16 % 16, i / 256); })});
  all.push_back({"line", points(2000, [&](int) { return vec3(random.unit(), 0, 0); })});
  all.push_back({"caustic", points(5000, [&](int i) { return random.in_cube(i % 2 ? 1e-4f : 1.0f); })});
  all.push_back({"cluster seen from afar", points(20000, [&](int i) {
                   return i % 100 == 0 ? random.in_cube(1) : vec3(50, 0, 0) + random.in_cube(1e-3f);
                 })});
  all.push_back({"far", points(2000, [&](int) { return vec3(1e6f) + random.in_cube(1); })});
  all.push_back({"series", points(2000, [](int i) { return vec3(std::ldexp(1.0f, -(i % 120)), 0, 0); })});
  all.push_back({"large", points(100000, [&](int) { return vec3(random.in_cube(1).x, random.unit(), 0); })});
  return all;
}

// In, on the boundary of, one ulp outside and far from the cloud.
std::vector<vec3> query_points(const Cloud& cloud, int count, Random& random) {
  Bounds b;
  for (const vec3& p : cloud.points)
    if (is_finite(p)) b.extend(p);
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

// Every structure built over the same points.
class Built {
 public:
  explicit Built(std::span<const vec3> cloud) {
    for (const PointEntry& entry : point_structures()) {
      structures_.push_back(entry.make());
      structures_.back()->build(cloud);
    }
  }

  void expect_within(const vec3& p, float r) {
    SCOPED_TRACE(fmt::format("radius {}", r));
    structures_[0]->within(p, r, expected_);
    for (std::size_t i = 1; i < structures_.size(); ++i) {
      SCOPED_TRACE(point_structures()[i].name);
      structures_[i]->within(p, r, given_);
      ASSERT_NO_FATAL_FAILURE(expect_equal(sorted_by_id(given_), expected_));
    }
  }
  void expect_nearest(const vec3& p, std::size_t k, float r) {
    SCOPED_TRACE(fmt::format("k {} radius {}", k, r));
    structures_[0]->nearest(p, k, r, expected_);
    for (std::size_t i = 1; i < structures_.size(); ++i) {
      SCOPED_TRACE(point_structures()[i].name);
      structures_[i]->nearest(p, k, r, given_);
      ASSERT_NO_FATAL_FAILURE(expect_equal(given_, expected_));
    }
  }
  const PointQuery& operator[](std::size_t i) const { return *structures_[i]; }
  std::size_t size() const { return structures_.size(); }

 private:
  std::vector<std::unique_ptr<PointQuery>> structures_;  // brute force first
  Neighbours given_, expected_;
};

template <class Check>
void for_each_cloud(const Check& check) {
  for (const Cloud& cloud : clouds()) {
    SCOPED_TRACE(cloud.name);
    Built built(cloud.points);
    ASSERT_NO_FATAL_FAILURE(check(cloud, built));
  }
}

int fewer_if_large(const Cloud& cloud, int count) { return cloud.points.size() > 50000 ? count / 20 : count; }

TEST(PointStructures, WithinFindsWhatBruteForceFinds) {
  ASSERT_EQ(point_structures()[0].name, "brute");
  for_each_cloud([](const Cloud& cloud, Built& built) {
    Random random(31);
    for (const vec3& p : query_points(cloud, fewer_if_large(cloud, 120), random))
      for (const float r : {0.0f, 1e-30f, 1e-3f, 0.05f, 1.0f, std::sqrt(2.0f), 30.0f, 1e10f, infinity, -1.0f})
        ASSERT_NO_FATAL_FAILURE(built.expect_within(p, r));
  });
}

TEST(PointStructures, RadiusThatEqualsADistanceFindsThatPoint) {
  for_each_cloud([](const Cloud& cloud, Built& built) {
    Random random(32);
    if (cloud.points.empty()) return;
    for (const vec3& p : query_points(cloud, fewer_if_large(cloud, 60), random)) {
      const vec3& target = cloud.points[random.below(static_cast<std::uint32_t>(cloud.points.size()))];
      ASSERT_NO_FATAL_FAILURE(built.expect_within(p, glm::length(target - p)));
    }
  });
}

TEST(PointStructures, NearestFindsWhatBruteForceFindsInItsOrder) {
  for_each_cloud([](const Cloud& cloud, Built& built) {
    Random random(33);
    for (const vec3& p : query_points(cloud, fewer_if_large(cloud, 40), random))
      for (const std::size_t k : {std::size_t{0}, std::size_t{1}, std::size_t{7}, std::size_t{50}, cloud.points.size() + 5})
        for (const float r : {0.0f, 0.1f, 2.0f, infinity})
          if (k < 1000 || r < 1 || random.below(4) == 0) {
            ASSERT_NO_FATAL_FAILURE(built.expect_nearest(p, k, r));
          }
  });
}

TEST(PointStructures, QueriesThatAreNotFiniteFindNothing) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  for_each_cloud([](const Cloud&, const Built& built) {
    for (std::size_t i = 0; i < built.size(); ++i) {
      SCOPED_TRACE(point_structures()[i].name);
      Neighbours found;
      for (const vec3& p : {vec3(nan, 0, 0), vec3(0, nan, 0), vec3(0, 0, nan), vec3(0, infinity, 0)})
        for (const float r : {0.0f, 1.0f, infinity}) {
          built[i].within(p, r, found);
          EXPECT_TRUE(found.empty());
          built[i].nearest(p, 3, r, found);
          EXPECT_TRUE(found.empty());
        }
      built[i].within(vec3(0), nan, found);
      EXPECT_TRUE(found.empty());
      built[i].nearest(vec3(0), 5, nan, found);
      EXPECT_TRUE(found.empty());
    }
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

// The order is the same as well as the set, at any number of threads that build.
TEST(PointStructures, ThreadsThatBuildDoNotMatter) {
  Random random(34);
  const std::vector<vec3> cloud = points(70000, [&](int i) { return random.in_cube(i % 2 ? 0.1f : 1.0f); });
  for (const PointEntry& entry : point_structures()) {
    std::vector<Neighbours> answers;
    for (const int threads : {1, 2, 3}) {
      const auto structure = entry.make();
      with_threads(threads, [&] { structure->build(cloud); });
      Neighbours all;
      for (const vec3& p : {vec3(0), vec3(0.1f, 0.2f, -0.3f), vec3(1)}) {
        Neighbours found;
        structure->within(p, 0.2f, found);
        all.insert(all.end(), found.begin(), found.end());
      }
      answers.push_back(std::move(all));
      SCOPED_TRACE(entry.name);
      ASSERT_NO_FATAL_FAILURE(expect_equal(answers.back(), answers.front()));
    }
  }
}

// Many readers at once: each answer is the one that a lone reader gets.
TEST(PointStructures, AnyNumberOfThreadsMayAsk) {
  Random random(35);
  const std::vector<vec3> cloud = points(20000, [&](int) { return random.in_cube(1); });
  for (const PointEntry& entry : point_structures()) {
    const auto structure = entry.make();
    structure->build(cloud);
    std::vector<Neighbours> alone(400), together(400);
    const auto ask = [&](std::size_t i, Neighbours& out) {
      if (i % 2 == 0)
        structure->within(cloud[i], 0.05f * static_cast<float>(i % 9), out);
      else
        structure->nearest(cloud[i], i % 60, 1, out);
    };
    for (std::size_t i = 0; i < alone.size(); ++i) ask(i, alone[i]);
    with_threads(4, [&] { parallel_for(together.size(), 1, [&](std::size_t i) { ask(i, together[i]); }); });
    SCOPED_TRACE(entry.name);
    for (std::size_t i = 0; i < alone.size(); ++i) ASSERT_NO_FATAL_FAILURE(expect_equal(together[i], alone[i]));
  }
}

// Sizes about the powers at which trees and tables change their shape, and up to a million.
void expect_alike(std::size_t count, Random& random, int queries) {
  SCOPED_TRACE(count);
  // A floor, a wall, a caustic on the floor, and twins of some of them.
  Cloud cloud{"photons", points(static_cast<int>(count), [&](int i) {
                const float u = random.unit(), v = random.unit();
                if (i % 4 == 3) return vec3(0.3f + 1e-3f * u, 0, 0.3f + 1e-3f * v);
                return i % 4 == 2 ? vec3(0, u, v) : vec3(u, 0, v);
              })};
  for (std::size_t i = 7; i < count; i += 8) cloud.points[i] = cloud.points[i / 2];
  Built built(cloud.points);
  const float spacing = 1 / std::sqrt(static_cast<float>(count + 1));
  for (const vec3& p : query_points(cloud, queries, random)) {
    for (const float r : {0.0f, 1e-4f, spacing, 4 * spacing, 0.2f, infinity})
      if (r < 0.1f || random.below(8) == 0) {
        ASSERT_NO_FATAL_FAILURE(built.expect_within(p, r));
      }
    ASSERT_NO_FATAL_FAILURE(built.expect_nearest(p, 1 + random.below(80), infinity));
  }
}

TEST(PointStructures, AnyNumberOfPointsGivesTheSameSets) {
  Random random(36);
  for (std::size_t count = 0; count < 70; ++count) ASSERT_NO_FATAL_FAILURE(expect_alike(count, random, 6));
  for (const std::size_t count : {511u, 512u, 513u, 4095u, 4096u, 4097u, 30000u})
    ASSERT_NO_FATAL_FAILURE(expect_alike(count, random, 12));
}

TEST(LongPointStructures, AMillionPointsGiveTheSameSets) {
  Random random(37);
  for (const std::size_t count : {99999u, 262144u, 1000000u}) ASSERT_NO_FATAL_FAILURE(expect_alike(count, random, 60));
}

template <class Entries>
std::vector<std::string> names_of(const Entries& entries) {
  std::vector<std::string> names;
  for (const auto& entry : entries) names.push_back(entry.name);
  return names;
}

TEST(Registry, MethodsMayNameEveryStructure) {
  EXPECT_EQ(names_of(point_structures()), std::vector<std::string>(point_structure_names.begin(), point_structure_names.end()));
  EXPECT_EQ(names_of(record_structures()),
            std::vector<std::string>(record_structure_names.begin(), record_structure_names.end()));
}

TEST(Registry, UnknownNamesAreErrorsThatNameTheNearest) {
  for (const std::function<void()>& lookup : {std::function<void()>([] { find_ray_structure("binned-sha", {"here"}); }),
                                              std::function<void()>([] { find_point_structure("kdtree", {"here"}); }),
                                              std::function<void()>([] { find_record_structure("octre", {"here"}); })}) {
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
