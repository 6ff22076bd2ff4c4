// Images of what the camera sees first: closed forms, misses, and numbers of instances and materials.
#include "experiments/report/aov.h"
#include "framework/io/pbrt/pbrt.h"
#include "framework/scene/builder.h"
#include "tests/scene_context.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::SceneContext;

constexpr ivec2 plate_size{8, 8};

// A plate of 4 x 4 m, tilted about x, before the camera at z = 5; the rows above and below see past it.
Scene tilted_plate(const Material& material) {
  SceneBuilder builder("plate");
  builder.camera({0, 0, 5}, {0, 0, 0}, 90, plate_size);
  builder.light(PointLight{});
  builder.mesh(quad({-9, -2, -1}, {9, -2, -1}, {9, 2, 1}, {-9, 2, 1}), builder.material(material));
  return builder.finish();
}

TEST(SurfaceImages, OfAPlaneAreItsClosedForm) {
  const SceneContext scope(tilted_plate(Diffuse{Rgb(0.25f, 0.5f, 0.75f)}), plate_size);
  const Image depth = draw_surface_image("depth", scope.context), position = draw_surface_image("position", scope.context),
              normal = draw_surface_image("normal", scope.context), albedo = draw_surface_image("albedo", scope.context);
  const dvec3 facing = glm::normalize(dvec3(0, -1, 2));
  for (int y = 0; y < plate_size.y; ++y)
    for (int x = 0; x < plate_size.x; ++x) {
      const Ray ray = scope.scene.camera.ray(plate_size, vec2(x, y) + 0.5f, vec2(0.5f));
      const double t = glm::dot(-dvec3(ray.origin), facing) / glm::dot(dvec3(ray.direction), facing);
      const dvec3 at = dvec3(ray.origin) + t * dvec3(ray.direction);
      if (std::abs(at.y) > 2) {
        EXPECT_EQ(depth.at(x, y), dvec3(infinity));
        EXPECT_EQ(position.at(x, y), dvec3(0));
        continue;
      }
      EXPECT_NEAR(depth.at(x, y).x, t, 1e-5);
      EXPECT_LT(glm::length(position.at(x, y) - at), 1e-5);
    }
  EXPECT_LT(glm::length(normal.at(4, 4) - facing), 1e-6);
  EXPECT_EQ(normal.at(4, 0), dvec3(0));
  EXPECT_LT(glm::length(albedo.at(4, 4) - dvec3(0.25, 0.5, 0.75)), 1e-6);
  EXPECT_EQ(albedo.at(4, 0), dvec3(0));
}

// A coat over white loses nothing, nor does glass; a mirror reflects its tint.
TEST(SurfaceImages, AlbedosAreThoseOfLightStraightOn) {
  const auto albedo = [](const Material& material) {
    const SceneContext scope(tilted_plate(material), plate_size);
    return draw_surface_image("albedo", scope.context).at(4, 4);
  };
  EXPECT_LT(glm::length(albedo(Plastic{.reflectance = Rgb(1)}) - dvec3(1)), 1e-5);
  EXPECT_NEAR(albedo(Plastic{.reflectance = Rgb(0)}).x, 0.04, 1e-5);
  EXPECT_LT(glm::length(albedo(Dielectric{}) - dvec3(1)), 1e-5);
  EXPECT_LT(glm::length(albedo(Conductor{.tint = Rgb(0.3f), .ideal = true}) - dvec3(0.3f)), 1e-5);
}

TEST(SurfaceImages, NumbersTellInstancesPrimitivesAndMaterials) {
  const SceneContext scope(parse_pbrt(R"(
    LookAt 0 0 9  0 0 0  0 1 0
    Camera "perspective" "float fov" 40
    WorldBegin
    LightSource "infinite"
    Material "diffuse"
    ObjectBegin "square"
      Shape "trianglemesh" "point3 P" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] "integer indices" [0 1 2 0 2 3]
    ObjectEnd
    Translate 2 0 0
    ObjectInstance "square"
    Translate -4 0 0
    ObjectInstance "square"
    Material "mirror"
    Translate 2 0 0
    Shape "sphere" "float radius" 0.5)",
                                      "s.pbrt"),
                           {18, 18});
  const Image primitive = draw_surface_image("primitive", scope.context),
              material = draw_surface_image("material", scope.context);
  EXPECT_EQ(primitive.at(9, 9), dvec3(0, 0, 0));
  EXPECT_EQ(primitive.at(9, 0), dvec3(-1));
  EXPECT_EQ(material.at(9, 0), dvec3(-1));
  // pbrt's LookAt is left-handed: x runs to the left.
  EXPECT_EQ(primitive.at(3, 9).y, 1);
  EXPECT_EQ(primitive.at(14, 9).y, 2);
  EXPECT_EQ(primitive.at(3, 9).z, 1);
  EXPECT_EQ(material.at(14, 9), material.at(3, 9));
  EXPECT_NE(material.at(14, 9), material.at(9, 9));
  EXPECT_LT(primitive.at(14, 9).x, 2);
}

}  // namespace
}  // namespace etendue
