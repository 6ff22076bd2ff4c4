// The effort that `auto` counts in rays, and the structure it chooses by it.
#include "accel/scene/auto_structure.h"
#include "framework/io/load_scene.h"
#include "integrators/choice/choose.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

TEST(AutoEffort, IsCountedInRays) {
  PilotFindings findings;
  findings.rays_per_path = 5;
  findings.path_error = 2;
  Scene scene;
  EXPECT_EQ(rays_a_pixel(scene, {}, {10, 10}, findings), 5 * 64);
  EXPECT_EQ(rays_a_pixel(scene, {0, 8}, {10, 10}, findings), 5 * 8);
  EXPECT_EQ(rays_a_pixel(scene, {2}, {100, 100}, findings), 2 * rays_per_second / 1e4);
  EXPECT_EQ(rays_a_pixel(scene, {2, 8}, {100, 100}, findings), 5 * 8);
  EXPECT_DOUBLE_EQ(rays_a_pixel(scene, {0, 0, 0.01}, {10, 10}, findings), 0.1 * 5 * 2 / 0.01);
  // Large scenes take time to build, and their rays take longer.
  scene.objects.resize(1);
  scene.objects[0].geometry.triangles.resize(1'000'000);
  EXPECT_NEAR(rays_a_pixel(scene, {2}, {100, 100}, findings), 1.6 * rays_per_second / 1e4 / 3.49, 1);
  EXPECT_GT(rays_a_pixel(scene, {0.2}, {100, 100}, findings), 0);
}

TEST(AutoEffort, CountsFewRaysWhereSurfacesAreSparse) {
  EXPECT_EQ(usual_rays_per_path(load_scene("builtin:cornell-box")), 6);
  EXPECT_EQ(usual_rays_per_path(load_scene("builtin:mesh")), 6);
  EXPECT_LT(usual_rays_per_path(load_scene("builtin:slivers")), 1.1);
  EXPECT_GE(usual_rays_per_path(load_scene("builtin:slivers?aspect=1000")), 1.1);
}

TEST(AutoStructure, WeighsBuildingAgainstTracing) {
  const Scene mesh = load_scene("builtin:mesh"), box = load_scene("builtin:cornell-box");
  EXPECT_EQ(choose_structure(mesh, 1e5).name, "lbvh");
  EXPECT_EQ(choose_structure(mesh, 1e7).name, "binned-sah");
  EXPECT_EQ(choose_structure(mesh, 1e9).name, "sah");
  EXPECT_TRUE(choose_structure(mesh, 1e9).params.contains("reinsertion"));
  for (const double rays : {1.0, 1e12}) EXPECT_EQ(choose_structure(box, rays).name, "binned-sah");
}

}  // namespace
}  // namespace etendue
