// Wide layouts on each instruction set that the machine has: the same bits as the binary layout.
#include "accel/bvh/build/binned_sah.h"
#include "accel/bvh/build/lbvh.h"
#include "accel/bvh/build/pack_test.h"
#include "accel/bvh/build/ploc.h"
#include "accel/bvh/bvh.h"
#include "accel/bvh/wide/wide_bvh.h"
#include "accel/kernels/primitive_test.h"
#include "framework/core/parallel.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>

namespace etendue::testing {
namespace {

// Bundles of rays as a camera or a small light sends them: from one point or next to it, towards a triangle and its corners.
std::vector<Ray> bundles(const Scene& scene, std::size_t count, std::uint64_t seed) {
  Random random(seed);
  const std::vector<Ray> aimed = aimed_rays(scene, count, seed);
  const Geometry& geometry = scene.objects[0].geometry;
  std::vector<Ray> rays;
  for (std::size_t bundle = 0; bundle < aimed.size(); ++bundle) {
    const Ray& axis = aimed[bundle];
    const float length = glm::length(axis.direction), spread = random.between(0, 0.05f);
    for (int i = 0; i < 64; ++i) {
      Ray ray = axis;
      if (bundle % 3 == 1) ray.origin += random.in_cube(0.01f * length);
      if (bundle % 4 == 2) ray.t_max = random.between(0, 2);
      if (bundle % 5 == 3) ray.t_min = random.between(0, 1);
      ray.direction += random.in_cube(spread * length);
      if (i % 8 == 7 && !geometry.triangles.empty()) {  // at a corner nearby, if there is one
        const uvec3 triangle = geometry.triangles[random.below(static_cast<std::uint32_t>(geometry.triangles.size()))];
        const vec3 towards = geometry.positions[triangle[i / 8 % 3]] - ray.origin;
        if (glm::dot(towards, axis.direction) > 0.99f * glm::length(towards) * length) ray.direction = towards;
      }
      rays.push_back(ray);
    }
  }
  return rays;
}

const Hit no_answer{-1, vec2(-1), 1, 0};  // what places for hits hold before

template <class Wide>
void expect_same_bits(const Geometry& geometry, const BinaryTree& tree, const Bvh& binary, const std::vector<Ray>& rays) {
  for (const Isa isa : supported_isas()) {
    SCOPED_TRACE(isa_name(isa));
    const Wide wide(VertexIds(geometry), tree, {}, isa);
    for (const Ray& ray : rays) {
      const Hit given = wide.closest(ray), expected = binary.closest(ray);
      ASSERT_EQ(given.primitive, expected.primitive);
      ASSERT_EQ(given.t, expected.t);
      ASSERT_EQ(given.uv, expected.uv);
      ASSERT_EQ(wide.occluded(ray), binary.occluded(ray));
    }
    std::vector<Hit> hits(rays.size(), no_answer);
    wide.closest(rays, hits);
    const std::unique_ptr<bool[]> occluded(new bool[rays.size()]);
    for (std::size_t i = 0; i < rays.size(); ++i) occluded[i] = !binary.occluded(rays[i]);
    wide.occluded(rays, std::span(occluded.get(), rays.size()));
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Hit expected = binary.closest(rays[i]);
      ASSERT_EQ(hits[i].primitive, expected.primitive) << "ray " << i << " of many";
      ASSERT_EQ(hits[i].t, expected.t);
      ASSERT_EQ(hits[i].uv, expected.uv);
      ASSERT_EQ(hits[i].instance, expected.instance);
      ASSERT_EQ(occluded[i], binary.occluded(rays[i]));
    }
  }
}

TEST(WideLayouts, EveryInstructionSetGivesTheBitsOfTheBinaryLayout) {
  for (const RayCase& c : ray_cases()) {
    if (c.scene.has_instances()) continue;
    SCOPED_TRACE(c.name);
    const Geometry& geometry = c.scene.objects[0].geometry;
    BinnedSahParams single;
    single.leaf_size = 1;
    const BinaryTree tree = build_binned_sah(build_items(geometry), single);
    const Bvh binary(geometry, build_binned_sah(build_items(geometry), {}));
    std::vector<Ray> rays = bundles(c.scene, 24, 7);                            // first, so that they go together
    for (const Ray& ray : general_rays(c.scene, 4500, 5)) rays.push_back(ray);  // more than a stream holds
    for (const Ray& ray : aimed_rays(c.scene, 300, 6)) rays.push_back(ray);
    ASSERT_NO_FATAL_FAILURE(expect_same_bits<Bvh4>(geometry, tree, binary, rays));
    ASSERT_NO_FATAL_FAILURE(expect_same_bits<Bvh8>(geometry, tree, binary, rays));
    ASSERT_NO_FATAL_FAILURE(expect_same_bits<Bvh16>(geometry, tree, binary, rays));
  }
}

// A few triangles on a lattice, so that rays meet their edges, with equal ones, needles and such as have no area; and spheres.
Geometry few_primitives(Random& random, float scale) {
  Geometry g;
  const auto corner = [&] { return scale * (vec3(random.below(4), random.below(4), random.below(4)) / 2.0f - vec3(0.75f)); };
  const std::uint32_t triangles = 1 + random.below(64);
  while (g.triangles.size() < triangles) {
    const vec3 a = corner(), b = corner();
    add_triangle(g, a, b, random.below(10) == 0 ? b + scale * random.in_cube(1e-3f) : corner());
    if (random.below(10) == 0) add_triangle(g, b, a, corner());
    if (random.below(10) == 0) add_triangle(g, a, b, g.positions[g.triangles.back().z]);
  }
  for (std::uint32_t i = random.below(5); i > 0; --i) g.quadrics.push_back(Sphere{corner(), scale * random.between(0, 0.5f)});
  return g;
}

// Batches are asked of all of a small geometry, a ray in each lane (small_geometry.h).
TEST(WideLayouts, SmallGeometriesGiveTheBitsOfTheBinaryLayout) {
  Random random(17);
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE(i);
    const Scene scene = scene_of(few_primitives(random, std::ldexp(1.0f, 10 * (i % 7 - 3))));
    const Geometry& geometry = scene.objects[0].geometry;
    const BinaryTree tree = build_binned_sah(build_items(geometry), {});
    const Bvh binary(geometry, build_binned_sah(build_items(geometry), {}));
    std::vector<Ray> rays = general_rays(scene, 301, i);
    for (const Ray& ray : aimed_rays(scene, 301, i)) rays.push_back(ray);
    ASSERT_NO_FATAL_FAILURE(expect_same_bits<Bvh8>(geometry, tree, binary, rays));
    ASSERT_NO_FATAL_FAILURE(expect_same_bits<Bvh16>(geometry, tree, binary, rays));
  }
}

// More shadow rays that meet something than two streams hold; between them are rays that meet nothing and invalid ones.
std::vector<Ray> rays_of_all_kinds(const Scene& scene) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<Ray> rays;
  for (const Ray& ray : aimed_rays(scene, 12000, 11)) {
    rays.push_back(ray);
    Ray other = ray;
    const std::size_t pair = rays.size() / 2;
    const int axis = static_cast<int>(pair % 3);
    switch (pair % 11) {
      case 0:
        other.origin += 1e6f * ray.direction;
        break;
      case 1:
        other.direction[axis] = nan;
        break;
      case 2:
        other.origin[axis] = -infinity;
        break;
      case 3:
        other.direction = vec3(0, -0.0f, 0);
        break;
      case 4:
        other.t_min = 2;
        other.t_max = 1;
        break;
      case 5:
        other.direction = vec3(1e-41f, 0, -1e-42f);
        break;
      case 6:
        other.direction[axis] = pair % 2 == 0 ? infinity : -infinity;
        break;
      case 7:
        other.t_min = nan;
        break;
      case 8:
        other.t_max = nan;
        break;
      case 9:
        other.direction[axis] = pair % 2 == 0 ? 1e-41f : -1e-41f;
        break;
      default:
        other.direction = -ray.direction;
    }
    rays.push_back(other);
  }
  return rays;
}

// Rays start together inside, so that streams take them for nearest hits too. Some end early, some are nearly in an axis plane,
// and some are so short that a subnormal component takes them aside though its reciprocal overflows. Every eighth ray, and all
// of the first ones, are invalid.
std::vector<Ray> rays_from_one_point() {
  Random random(12);
  std::vector<Ray> rays;
  for (int i = 0; i < 6000; ++i) {
    Ray ray{vec3(0.2f, 0.1f, -0.3f), 0, random.direction(), i % 5 == 0 ? random.between(0, 2) : infinity};
    if (i % 8 == 2) ray.direction[i / 8 % 3] = i % 16 == 2 ? 1e-41f : -1e-41f;
    if (i % 8 == 4) {
      ray.direction[i / 8 % 3] = random.between(-0.028f, 0.028f);
      ray.direction *= 1e-37f;
      ray.t_max = infinity;
    }
    if (i % 8 == 3 || i < 64) ray.direction.x = std::numeric_limits<float>::quiet_NaN();
    rays.push_back(ray);
  }
  return rays;
}

// Rays from around a box, from its faces, edges and corners, and from within, along the axes, nearly so and across: most pass
// it.
std::vector<Ray> rays_about(const Bounds& box) {
  const vec3 places[] = {box.lower - 1.0f, box.lower, box.centre(), box.upper};
  constexpr float steps[] = {-1, -1e-41f, 0, 0.5f};
  std::vector<Ray> rays;
  for (int i = 0; i < 64; ++i)
    for (int j = 0; j < 64; ++j)
      rays.push_back(
          {{places[i % 4].x, places[i / 4 % 4].y, places[i / 16].z}, 0, {steps[j % 4], steps[j / 4 % 4], steps[j / 16]}});
  return rays;
}

// The binary layout judges, and every place to answer in holds another answer before.
template <class Wide>
void expect_batches_as_binary(const Geometry& geometry, const std::vector<Ray>& rays, std::size_t least_occluded) {
  const BinaryTree tree = build_binned_sah(build_items(geometry), {});
  const Bvh binary(geometry, tree);
  std::vector<Hit> expected;
  for (const Ray& ray : rays) expected.push_back(binary.closest(ray));
  const auto met = std::count_if(expected.begin(), expected.end(), [](const Hit& hit) { return static_cast<bool>(hit); });
  EXPECT_GT(static_cast<std::size_t>(met), least_occluded);
  for (const Isa isa : supported_isas()) {
    SCOPED_TRACE(isa_name(isa));
    const Wide wide(VertexIds(geometry), tree, {}, isa);
    const std::unique_ptr<bool[]> occluded(new bool[rays.size()]);
    for (std::size_t i = 0; i < rays.size(); ++i) occluded[i] = !expected[i];
    wide.occluded(rays, std::span(occluded.get(), rays.size()));
    std::vector<Hit> hits(rays.size(), no_answer);
    wide.closest(rays, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(occluded[i], binary.occluded(rays[i])) << "ray " << i;
      ASSERT_EQ(wide.occluded(rays[i]), binary.occluded(rays[i])) << "ray " << i << " alone";
      for (const Hit& hit : {hits[i], wide.closest(rays[i])}) {
        ASSERT_EQ(hit.primitive, expected[i].primitive) << "ray " << i;
        ASSERT_EQ(hit.instance, expected[i].instance) << "ray " << i;
        ASSERT_EQ(hit.t, expected[i].t) << "ray " << i;
        ASSERT_EQ(hit.uv, expected[i].uv) << "ray " << i;
      }
      ASSERT_TRUE(is_traceable(rays[i]) || !occluded[i]) << "ray " << i;
    }
  }
}

void expect_batches_as_binary(const Geometry& geometry, const std::vector<Ray>& rays, std::size_t least_occluded) {
  ASSERT_NO_FATAL_FAILURE(expect_batches_as_binary<Bvh4>(geometry, rays, least_occluded));
  ASSERT_NO_FATAL_FAILURE(expect_batches_as_binary<Bvh8>(geometry, rays, least_occluded));
  ASSERT_NO_FATAL_FAILURE(expect_batches_as_binary<Bvh16>(geometry, rays, least_occluded));
}

// Streams hold 4096 shadow rays or 2048 others.
TEST(WideLayouts, StreamsAnswerRaysThatTheyDoNotKeep) {
  const Scene scene = scene_of(closed_sphere(40, 50));
  const Geometry& geometry = scene.objects[0].geometry;
  expect_batches_as_binary(geometry, rays_of_all_kinds(scene), 2 * 4096);
  expect_batches_as_binary(geometry, rays_from_one_point(), 2 * 2048);
}

TEST(WideLayouts, BatchesTellRaysThatPassTheScene) {
  const Scene scene = scene_of(closed_sphere(40, 50));
  expect_batches_as_binary(scene.objects[0].geometry, rays_about(scene.bounds()), 300);
}

// Leaves that are lists, and packs between them, for rays that visit nodes enough to go in streams.
TEST(WideLayouts, StreamsTestLists) {
  Random random(13);
  Geometry geometry = closed_sphere(20, 30);
  for (int i = 0; i < 3000; ++i) geometry.quadrics.push_back(Sphere{1.1f * random.direction(), random.between(0, 0.04f)});
  for (int i = 0; i < 500; ++i) geometry.quadrics.push_back(Sphere{random.in_cube(0.8f), 0.02f});
  expect_batches_as_binary(geometry, rays_from_one_point(), 2 * 2048);
}

TEST(WideLayouts, CollapseKeepsEveryPrimitiveOnce) {
  for (const RayCase& c : ray_cases()) {
    const Geometry& geometry = c.scene.objects[0].geometry;
    BinnedSahParams single;
    single.leaf_size = 1;
    const auto tree = collapse<16, SharedPack>(VertexIds(geometry), build_binned_sah(build_items(geometry), single), {});
    std::vector<std::uint32_t> found = tree.list_ids;
    for (const auto& pack : tree.packs)
      for (const std::uint32_t id : pack.ids)
        if (id != no_id) found.push_back(id);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, geometry.valid_primitives()) << c.name;
  }
}

// Builds to packs, with every leaf tested.
template <class Params>
BinaryTree expect_packs(const Geometry& geometry, BinaryTree (*build)(BuildItems, const Params&)) {
  const VertexIds vertices(geometry);
  const PackTest packs = PackTest::of<SharedPack>(vertices);
  Params params;
  params.leaf_size = Bvh16::tree_leaf_size;
  params.packs = &packs;
  if constexpr (requires { params.primitive_cost; }) params.primitive_cost = 0;
  BinaryTree tree = build(build_items(geometry), params);
  EXPECT_LT(tree.depth, static_cast<std::uint32_t>(params.max_depth));
  EXPECT_TRUE(std::any_of(tree.nodes.begin(), tree.nodes.end(), [&](const TreeNode& node) {
    return node.is_leaf() && node.count > static_cast<std::uint32_t>(params.leaf_size);
  })) << "packs were not asked for";
  for (const TreeNode& node : tree.nodes)
    EXPECT_TRUE(!node.is_leaf() || packs.takes(node.count, [&](std::uint32_t i) { return tree.primitives[node.first + i]; }));
  return tree;
}

TEST(WideLayouts, BuildersToPacksMakeLeavesThatPacksTake) {
  const Geometry geometry = closed_sphere(40, 80);
  expect_packs(geometry, build_binned_sah);
  expect_packs(geometry, build_lbvh);
  expect_packs(geometry, build_ploc);
}

TEST(WideLayouts, NodesAndPacksAreTheSameAtAnyThreadCount) {
  const Geometry geometry = closed_sphere(120, 240);  // more than one piece
  std::vector<WideTree<16, SharedPack>> trees;
  for (const int threads : {1, 2, 3})
    with_threads(threads, [&] {
      trees.push_back(collapse<16, SharedPack>(VertexIds(geometry), expect_packs(geometry, build_binned_sah),
                                               {.leaves_are_packs = true, .each_is_a_pack = true}));
    });
  for (const auto& tree : trees) {
    EXPECT_EQ(tree.sah_cost, trees[0].sah_cost);
    EXPECT_EQ(tree.depth, trees[0].depth);
    ASSERT_EQ(tree.nodes.size(), trees[0].nodes.size());
    ASSERT_EQ(tree.packs.size(), trees[0].packs.size());
    EXPECT_EQ(std::memcmp(tree.nodes.data(), trees[0].nodes.data(), tree.nodes.size() * sizeof(tree.nodes[0])), 0);
    for (std::size_t i = 0; i < tree.packs.size(); ++i)
      ASSERT_TRUE(std::ranges::equal(tree.packs[i].ids, trees[0].packs[i].ids)) << "pack " << i;
  }
}

}  // namespace
}  // namespace etendue::testing
