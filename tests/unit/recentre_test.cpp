#include "framework/scene/recentre.h"

#include "framework/scene/builder.h"
#include "tests/unit/io_pbrt_helpers.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace etendue {
namespace {

// All that has a place, x and z metres from where it would lie. Every coordinate is a multiple of 1/8.
Scene placed_at(double x, double z) {
  return parse_pbrt(fmt::format("Translate {} 0 {}\n", -x, -z) + R"(Translate 0 0 8
Camera "perspective"
WorldBegin
ObjectBegin "stone"
Shape "sphere" "float radius" 0.5
ObjectEnd
)" + fmt::format("Translate {} 0 {}\n", x, z) +
                        R"(
LightSource "point" "point3 from" [0 4 0]
LightSource "spot" "point3 from" [1 4 0] "point3 to" [1 0 0]
AttributeBegin
AreaLightSource "diffuse"
Shape "disk" "float radius" 0.5 "float height" 3
AttributeEnd
Shape "sphere" "float radius" 0.25
Shape "cylinder" "float radius" 0.5
Shape "trianglemesh" "point3 P" [-1 -1 -1 1 -1 -1 1 1 1] "integer indices" [0 1 2]
Translate 0 1 0
ObjectInstance "stone"
)",
                    "s.pbrt");
}

TEST(Recentre, ScenesFarAwayAreAsNearTheOrigin) {
  const Scene near = placed_at(0, 0), far = placed_at(1048576, -524288), elsewhere = placed_at(-524288, 1048576);
  EXPECT_EQ(near.origin, vec3(0));
  EXPECT_EQ(far.hash(), elsewhere.hash());
  const vec3 moved = far.origin - vec3(1048576, 0, -524288);
  EXPECT_EQ(moved, glm::round(8.0f * near.bounds().centre()) / 8.0f * vec3(1, 0, 1));
  expect_near(far.bounds().lower + moved, near.bounds().lower);
  expect_near(far.bounds().upper + moved, near.bounds().upper);
  EXPECT_EQ(far.camera.to_world.point(vec3(0)) + moved, near.camera.to_world.point(vec3(0)));
  EXPECT_EQ(std::get<PointLight>(far.lights[0]).position + moved, std::get<PointLight>(near.lights[0]).position);
  EXPECT_EQ(std::get<SpotLight>(far.lights[1]).position + moved, std::get<SpotLight>(near.lights[1]).position);
}

TEST(Recentre, PlanesAndClosedFormsMoveAlong) {
  SceneBuilder builder("far away");
  const auto white = builder.material(Diffuse{Rgb(1)});
  builder.quadric(Sphere{{4096, 0, 0}, 1}, white);
  builder.plane({.point = {4095, 0, 0}, .normal = {1, 0, 0}, .material = white});
  builder.camera({4099, 0, 0}, {4096, 0, 0}, 60, {8, 8});
  builder.closed_form("where the ray begins", [](const Ray& ray) { return dvec3(ray.origin); });
  const Scene scene = builder.finish();
  EXPECT_EQ(scene.planes[0].point, vec3(-1, 0, 0));
  EXPECT_EQ(scene.closed_form->radiance(scene.camera.ray({8, 8}, {4, 4}, vec2(0.5f))), dvec3(4099, 0, 0));
}

}  // namespace
}  // namespace etendue
