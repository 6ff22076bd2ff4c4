// Edge collapse: what is left of a mesh, and that it is the same each time.
#include "accel/thirdparty/collapse.h"

#include "accel/registry.h"
#include "framework/scenes/meshes.h"

#include <gtest/gtest.h>

#include <array>
#include <map>

namespace etendue {
namespace {

class Collapse : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const RayEntry& entry : ray_structures())
      if (entry.name == "cgal" && !entry.available) GTEST_SKIP() << "this build is without CGAL";
  }

  static std::vector<CoarseMesh> collapse(const MeshData& mesh, std::vector<double> shares) {
    return collapse_edges(mesh.positions, mesh.triangles, shares);
  }
};

// Counts edges that do not lie between two triangles, which a closed mesh has none of.
int open_edges(const CoarseMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance;
  for (const uvec3& t : mesh.triangles)
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i], b = t[(i + 1) % 3];
      balance[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  int open = 0;
  for (const auto& [edge, count] : balance) open += count != 0;
  return open;
}

TEST_F(Collapse, ClosedMeshStaysClosedAndNearWithFewTriangles) {
  const MeshData ball = rough_ball({0, 0, 0}, 1, 4000);
  const double all = static_cast<double>(ball.triangles.size());
  const std::vector<CoarseMesh> levels = collapse(ball, {0.25, 1.0 / 16});
  ASSERT_EQ(levels.size(), 2u);
  EXPECT_NEAR(static_cast<double>(levels[0].triangles.size()), all / 4, 4);
  EXPECT_NEAR(static_cast<double>(levels[1].triangles.size()), all / 16, 4);
  for (const CoarseMesh& level : levels) EXPECT_EQ(open_edges(level), 0);
  EXPECT_GT(levels[0].distance, 0);
  EXPECT_GT(levels[1].distance, levels[0].distance);
  EXPECT_LT(levels[1].distance, 0.1f);
}

TEST_F(Collapse, GivesTheSameMeshEachTime) {
  const MeshData ball = rough_ball({1, 2, 3}, 0.5f, 2000);
  const CoarseMesh first = collapse(ball, {0.1}).front(), second = collapse(ball, {0.1}).front();
  EXPECT_EQ(first.positions, second.positions);
  EXPECT_EQ(first.triangles, second.triangles);
  EXPECT_EQ(first.distance, second.distance);
}

TEST_F(Collapse, VerticesAtOnePlaceAreJoined) {
  const MeshData ball = rough_ball({0, 0, 0}, 1, 1000);
  MeshData apart;
  for (const uvec3& t : ball.triangles) {
    const auto v = static_cast<std::uint32_t>(apart.positions.size());
    for (int i = 0; i < 3; ++i) apart.positions.push_back(ball.positions[t[i]]);
    apart.triangles.emplace_back(v, v + 1, v + 2);
  }
  const CoarseMesh coarse = collapse(apart, {0.2}).front();
  EXPECT_EQ(open_edges(coarse), 0);
  EXPECT_NEAR(static_cast<double>(coarse.triangles.size()), 0.2 * static_cast<double>(ball.triangles.size()), 4);
}

TEST_F(Collapse, KeepsWhatIsNoManifoldAndDropsWhatIsNoTriangle) {
  MeshData mesh;
  mesh.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {std::nanf(""), 0, 0}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {0, 1, 5}, {2, 2, 3}};
  const CoarseMesh coarse = collapse(mesh, {1}).front();
  EXPECT_EQ(coarse.triangles.size(), 3u);
  for (const vec3& p : coarse.positions) EXPECT_TRUE(std::isfinite(p.x + p.y + p.z));
  EXPECT_TRUE(collapse({}, {0.5}).front().triangles.empty());
}

}  // namespace
}  // namespace etendue
