// Wide layouts on each instruction set that the machine has: the same bits as the binary layout.
#include "accel/ray/build_binned_sah.h"
#include "accel/ray/bvh.h"
#include "accel/ray/wide_bvh.h"
#include "tests/oracle/ray_cases.h"

#include <gtest/gtest.h>

#include <memory>

namespace etendue::testing {
namespace {

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
    std::vector<Hit> hits(rays.size());
    wide.closest(rays, hits);
    const std::unique_ptr<bool[]> occluded(new bool[rays.size()]);
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
    std::vector<Ray> rays = general_rays(c.scene, 2000, 5);
    for (const Ray& ray : aimed_rays(c.scene, 300, 6)) rays.push_back(ray);
    ASSERT_NO_FATAL_FAILURE(expect_same_bits<Wide4Bvh>(geometry, tree, binary, rays));
    ASSERT_NO_FATAL_FAILURE(expect_same_bits<Wide8Bvh>(geometry, tree, binary, rays));
    ASSERT_NO_FATAL_FAILURE(expect_same_bits<Wide16Bvh>(geometry, tree, binary, rays));
  }
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

}  // namespace
}  // namespace etendue::testing
