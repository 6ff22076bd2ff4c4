// Motions: the same seed moves alike, and what is not said to have moved has not.
#include "framework/scene/motion.h"
#include "framework/core/error.h"
#include "framework/io/load_scene.h"

#include <gtest/gtest.h>

#include <cstring>
#include <set>

namespace etendue {
namespace {

// The box with spheres: triangles and quadrics.
Geometry mixed_geometry() { return load_scene("builtin:cornell-spheres", {}).objects[0].geometry; }

ParamMap params(const std::string& key, double value) { return {{key, {value, {}}}}; }

bool same_primitive(const Geometry& a, const Geometry& b, std::uint32_t id) {
  if (!a.is_triangle(id)) return anchor(a.quadric(id)) == anchor(b.quadric(id));
  for (int k = 0; k < 3; ++k)
    if (a.positions[a.triangles[id][k]] != b.positions[b.triangles[id][k]]) return false;
  return true;
}

TEST(Motion, OnlyWhatIsNamedMoves) {
  const Geometry geometry = mixed_geometry();
  ASSERT_FALSE(geometry.quadrics.empty());
  for (const MotionEntry& entry : motions()) {
    const bool in_part = entry.name == "wave" || entry.name == "scatter";
    const auto motion = entry.make({geometry, 10, 3}, in_part ? params("moving", 0.3) : ParamMap{});
    Geometry moving = motion->rest();
    ASSERT_EQ(moving.triangles.size(), geometry.triangles.size());
    for (std::uint32_t id = 0; id < geometry.primitive_count(); ++id)
      EXPECT_TRUE(same_primitive(geometry, moving, id)) << entry.name;
    for (int frame = 1; frame <= 10; ++frame) {
      const Geometry before = moving;
      const std::vector<std::uint32_t> changed = motion->pose(frame, moving);
      EXPECT_TRUE(std::is_sorted(changed.begin(), changed.end()));
      const std::set<std::uint32_t> named(changed.begin(), changed.end());
      EXPECT_EQ(named.size(), changed.size());
      EXPECT_FALSE(named.empty()) << entry.name;
      EXPECT_TRUE(!in_part || named.size() < geometry.primitive_count()) << entry.name;
      for (std::uint32_t id = 0; id < moving.primitive_count(); ++id)
        EXPECT_TRUE(named.contains(id) || same_primitive(before, moving, id)) << entry.name << " " << id;
    }
    EXPECT_NE(moving.positions, motion->rest().positions) << entry.name;
  }
}

TEST(Motion, SeedDecidesWhereObjectsGo) {
  const Geometry geometry = mixed_geometry();
  const auto end_of = [&](const char* name, std::uint64_t seed) {
    const auto motion = find_motion(name, {}).make({geometry, 5, seed}, {});
    Geometry moving = motion->rest();
    for (int frame = 1; frame <= 5; ++frame) motion->pose(frame, moving);
    return moving.positions;
  };
  for (const char* name : {"explode", "scatter"}) {
    EXPECT_EQ(end_of(name, 1), end_of(name, 1));
    EXPECT_NE(end_of(name, 1), end_of(name, 2));
  }
}

TEST(Motion, ObjectsKeepTheirShape) {
  const Geometry geometry = mixed_geometry();
  for (const char* name : {"explode", "scatter"}) {
    const auto motion = find_motion(name, {}).make({geometry, 4, 1}, {});
    Geometry moving = motion->rest();
    for (int frame = 1; frame <= 4; ++frame) motion->pose(frame, moving);
    for (const uvec3& t : moving.triangles)
      for (int k = 0; k < 3; ++k) {
        const auto edge = [&](const Geometry& g) { return glm::length(g.positions[t[k]] - g.positions[t[(k + 1) % 3]]); };
        EXPECT_NEAR(edge(moving), edge(motion->rest()), 1e-4f * (1 + edge(moving)));
      }
  }
}

TEST(Motion, InvalidPrimitivesStayBehind) {
  Geometry geometry;
  geometry.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {std::nanf(""), 0, 0}};
  geometry.triangles = {{0, 1, 2}, {0, 1, 3}};
  for (const MotionEntry& entry : motions()) {
    const auto motion = entry.make({geometry, 3, 1}, {});
    Geometry moving = motion->rest();
    for (int frame = 1; frame <= 3; ++frame) motion->pose(frame, moving);
    EXPECT_TRUE(moving.is_valid(0)) << entry.name;
    EXPECT_FALSE(moving.is_valid(1)) << entry.name;
  }
}

TEST(Motion, UnknownNamesAndParametersAreErrors) {
  EXPECT_THROW(find_motion("wafe", {}), Error);
  EXPECT_THROW(find_motion("wave", {}).make({Geometry{}, 1, 1}, params("objects", 3)), Error);
  EXPECT_THROW(find_motion("scatter", {}).make({Geometry{}, 1, 1}, params("moving", 2)), Error);
}

}  // namespace
}  // namespace etendue
