#include "framework/core/sampler.h"
#include "framework/io/load_scene.h"
#include "framework/io/pbrt/pbrt.h"
#include "framework/scene/builder.h"
#include "framework/scene/needs.h"
#include "framework/scene/precision.h"
#include "framework/scenes/meshes.h"
#include "tests/scene_context.h"

#include <gtest/gtest.h>

#include <set>

namespace etendue {
namespace {

TEST(Transform, InverseUndoes) {
  const Transform t = Transform::translate({1, -2, 3}) * Transform::rotate(0.7f, {1, 2, 3}) * Transform::scale({2, -1, 0.5f});
  const vec3 p(0.3f, 0.9f, -4);
  const vec3 back = t.inverse().point(t.point(p));
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(back[i], p[i], 1e-5f);
  EXPECT_TRUE(t.swaps_handedness());
  EXPECT_FALSE(t.similarity_scale().has_value());
}

TEST(Transform, NormalsStayPerpendicular) {
  const Transform t = Transform::rotate(0.4f, {0, 1, 1}) * Transform::scale({3, 1, 0.2f});
  const vec3 n = glm::normalize(vec3(1, 2, -1)), along = Frame::from_normal(n).tangent;
  EXPECT_NEAR(glm::dot(t.normal(n), t.vector(along)), 0, 1e-5f);
}

TEST(Transform, RigidInverseIsTheTranspose) {
  const auto t = Transform::look_at({1, 2, 3}, {0, 0, 0}, {0, 1, 0});
  ASSERT_TRUE(t);
  EXPECT_NEAR(*t->similarity_scale(), 1, 1e-6f);
  EXPECT_FALSE(Transform::look_at({1, 1, 1}, {1, 1, 1}, {0, 1, 0}));
  EXPECT_FALSE(Transform::from_matrix(mat4(0)));
}

TEST(Camera, ConnectionInvertsTheRay) {
  for (const float lens_radius : {0.0f, 0.2f}) {
    Scene scene = load_scene("builtin:cornell-box");
    Camera camera = scene.camera;
    camera.lens_radius = lens_radius;
    camera.focal_distance = 2.5f;
    for (int i = 0; i < 100; ++i) {
      Sampler s(SamplerKind::independent, 1, Stream::test, i, 2);
      const ivec2 resolution(200, 100);
      const vec2 film = s.get_2d() * vec2(resolution), lens = s.get_2d();
      const Ray ray = camera.ray(resolution, film, lens);
      const auto c = camera.connect(resolution, ray.at(1 + 3 * s.get_1d()), lens);
      ASSERT_TRUE(c);
      EXPECT_NEAR(c->film.x, film.x, 2e-3);
      EXPECT_NEAR(c->film.y, film.y, 2e-3);
    }
    if (lens_radius == 0) {
      camera.half_width = 0.7f;
      const auto c = camera.connect({200, 100}, camera.ray({200, 100}, {30, 60}, {0, 0}).at(2), {0, 0});
      ASSERT_TRUE(c);
      EXPECT_NEAR(c->film.x, 30, 2e-3);
      EXPECT_NEAR(c->film.y, 60, 2e-3);
      EXPECT_FLOAT_EQ(c->importance, square(100 / 1.4f));
    }
    EXPECT_FALSE(camera.connect({200, 100}, camera.to_world.point({0, 0, -1}), {0.5f, 0.5f}));
  }
}

// The factor that light tracing adds to a pixel is the area of film that an area across the ray covers.
TEST(Camera, ConnectionsKnowHowTheViewIsStretched) {
  Camera camera;
  camera.fov = 0.8f;
  camera.distorts = true;
  camera.to_world = Transform::scale({2, 1, 0.5f}) * Transform::rotate(0.5f, {1, 2, 3}) * Transform::scale({1, 3, 1});
  const ivec2 resolution(200, 100);
  const Ray ray = camera.ray(resolution, {150, 20}, {0, 0});
  const Frame across = Frame::from_normal(ray.direction);
  const vec3 p = ray.at(3);
  const auto film = [&](const vec3& at) { return camera.connect(resolution, at, {0, 0})->film; };
  const float step = 0.01f;
  const vec2 u = (film(p + step * across.tangent) - film(p - step * across.tangent)) / (2 * step);
  const vec2 v = (film(p + step * across.bitangent) - film(p - step * across.bitangent)) / (2 * step);
  const float pixels = std::abs(u.x * v.y - u.y * v.x);
  EXPECT_NEAR(camera.connect(resolution, p, {0, 0})->importance / pixels, 1, 0.01f);
  EXPECT_NEAR(camera.pdf(resolution, ray.direction) / (9 * pixels), 1, 0.01f);
}

TEST(Needs, CausticMapOnlyWhereLightReachesSpecular) {
  EXPECT_FALSE(scene_needs(load_scene("builtin:cornell-box")).caustic_map);
  EXPECT_TRUE(scene_needs(load_scene("builtin:cornell-spheres")).caustic_map);
  // A mirror behind a light that shines away from it.
  SceneBuilder b("test");
  b.mesh(quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}), b.material(Diffuse{}), Rgb(1));  // shines up
  b.mesh(quad({-1, -2, 1}, {1, -2, 1}, {1, -2, -1}, {-1, -2, -1}), b.material(Conductor{.ideal = true}));
  b.camera({0, 1, 4}, {0, 0, 0}, 40, {8, 8});
  EXPECT_FALSE(scene_needs(b.finish()).caustic_map);
}

TEST(Needs, OneLightNeedsNoChoice) {
  EXPECT_FALSE(scene_needs(load_scene("builtin:lambert-sphere")).light_choice);
  const SceneNeeds needs = scene_needs(load_scene("builtin:veach-mis"));
  EXPECT_TRUE(needs.light_choice);
  EXPECT_TRUE(needs.glossy);
  EXPECT_FALSE(needs.two_levels);
}

TEST(SceneHash, ChangesWithWhatChangesAnImage) {
  const Scene scene = load_scene("builtin:cornell-spheres");
  EXPECT_EQ(scene.hash(), load_scene("builtin:cornell-spheres").hash());
  Scene changed = scene;
  changed.camera.fov *= 1.001f;
  EXPECT_NE(scene.hash(), changed.hash());
  changed = scene;
  changed.materials[0] = Diffuse{Rgb(0.1f)};
  EXPECT_NE(scene.hash(), changed.hash());
  changed = scene;
  changed.name = "another name";
  EXPECT_EQ(scene.hash(), changed.hash());
}

TEST(SceneHash, ChangesWithEachPropertyOfALight) {
  const auto hash = [](const Light& light) {
    Scene scene;
    scene.lights = {light};
    return scene.content_hash();
  };
  std::vector<Light> lights{AreaLight{},
                            AreaLight{.primitive = 1},
                            AreaLight{.radiance = Rgb(2)},
                            AreaLight{.two_sided = true},
                            PointLight{},
                            PointLight{.position = {1, 0, 0}},
                            PointLight{.intensity = Rgb(2)},
                            SpotLight{},
                            SpotLight{.position = {1, 0, 0}},
                            SpotLight{.direction = {1, 0, 0}},
                            SpotLight{.intensity = Rgb(2)},
                            SpotLight{.cos_outer = 0.7f},
                            SpotLight{.cos_inner = 0.95f},
                            DirectionalLight{},
                            DirectionalLight{.direction = {1, 0, 0}},
                            DirectionalLight{.irradiance = Rgb(2)}};
  const auto environment = [](Rgb scale, ivec2 size, std::vector<Rgb> texels, float turned) {
    return EnvironmentLight{scale, size, std::move(texels), Transform::rotate(turned, {0, 1, 0})};
  };
  lights.push_back(environment(Rgb(1), {0, 0}, {}, 0));
  lights.push_back(environment(Rgb(2), {0, 0}, {}, 0));
  lights.push_back(environment(Rgb(1), {2, 1}, {Rgb(1), Rgb(1)}, 0));
  lights.push_back(environment(Rgb(1), {1, 2}, {Rgb(1), Rgb(1)}, 0));
  lights.push_back(environment(Rgb(1), {2, 1}, {Rgb(1), Rgb(2)}, 0));
  lights.push_back(environment(Rgb(1), {0, 0}, {}, 0.1f));
  std::set<std::uint64_t> hashes;
  for (const Light& light : lights) hashes.insert(hash(light));
  EXPECT_EQ(hashes.size(), lights.size());
}

TEST(BuiltinScenes, HaveLightsGeometryAndACameraInside) {
  for (const BuiltinScene& entry : builtin_scenes()) {
    if (entry.name == "mesh-large") continue;  // slow to make, and like mesh
    const Scene scene = entry.make();
    EXPECT_EQ(scene.name, "builtin:" + entry.name);
    EXPECT_FALSE(scene.lights.empty()) << entry.name;
    EXPECT_GT(scene.objects[0].geometry.primitive_count(), 0u) << entry.name;
    for (std::uint32_t i = 0; i < scene.objects[0].geometry.primitive_count(); ++i)
      ASSERT_TRUE(scene.objects[0].geometry.is_valid(i)) << entry.name << " primitive " << i;
  }
}

// A box of 2 m at a distance, with a flake of 0.1 m before it.
std::vector<std::string> warnings_at(const std::string& distance) {
  return precision_warnings(parse_pbrt("WorldBegin\nTranslate " + distance + R"( 0 0
Shape "trianglemesh" "point3 P" [-1 -1 -1 1 -1 -1 1 1 1] "integer indices" [0 1 2]
Shape "trianglemesh" "point3 P" [0 0 0 0.1 0 0 0 0.1 0] "integer indices" [0 1 2]
)",
                                       "s.pbrt"));
}

TEST(Precision, WhatFloatsHoldIsNotWarnedOf) {
  EXPECT_TRUE(warnings_at("0").empty());
  EXPECT_TRUE(warnings_at("1000").empty());
}

TEST(Precision, ScenesFarFromTheOriginAreTold) {
  const std::vector<std::string> warnings = warnings_at("1e5");
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_EQ(
      warnings[0],
      "the scene spans 2 m at 1e+05 m from the origin, where floats lie 0.0078 m apart: corners, contacts and shadows are as "
      "coarse; move it to the origin");
  EXPECT_EQ(warnings[1],
            "1 of 2 primitives are small for where they are, the smallest 0.102 m at 1e+05 m from the origin, where floats lie "
            "0.0078 m apart: rays may start beyond them");
}

// A box of 4 m by 4 m by `length`.
std::vector<std::string> warnings_of_corridor(float length, float scale = 1) {
  const MeshData walls = box(scale * vec3(-2, -2, -length / 2), scale * vec3(2, 2, length / 2));
  SceneBuilder builder("corridor");
  builder.mesh(walls, builder.material(Diffuse{Rgb(0.5f)}));
  builder.camera(vec3(0), vec3(0, 0, 1), 90, {4, 4});
  return precision_warnings(builder.finish());
}

TEST(Precision, ThinPrimitivesAndLargeNeighboursAreTold) {
  EXPECT_TRUE(warnings_of_corridor(1e4f).empty());
  const std::vector<std::string> long_one = warnings_of_corridor(1e6f), too_long = warnings_of_corridor(4e6f);
  ASSERT_EQ(long_one.size(), 1u);
  EXPECT_EQ(long_one[0],
            "rays start 0.72 m off the largest primitive, which spans 1e+06 m; what touches it is as coarse, and the scene has "
            "what measures 4 m. Divide the primitive, or shrink it");
  ASSERT_EQ(too_long.size(), 2u);
  EXPECT_EQ(too_long[0],
            "8 of 12 primitives are too thin for their length, the thinnest 4 m by 4e+06 m: rays may start beyond them");
}

TEST(Precision, LargePrimitivesOfInstancesAreTold) {
  const auto warnings_by = [](const std::string& transform) {
    return precision_warnings(parse_pbrt(R"(WorldBegin
Shape "trianglemesh" "point3 P" [-1 -1 0 1 -1 1 1 1 1] "integer indices" [0 1 2]
ObjectBegin "floor"
Shape "trianglemesh" "point3 P" [-1 -1 0 1 -1 0 1 1 0] "integer indices" [0 1 2]
ObjectEnd
)" + transform + "\nObjectInstance \"floor\"\n",
                                         "s.pbrt"));
  };
  EXPECT_TRUE(warnings_by("Scale 100 100 1").empty());
  const std::vector<std::string> warnings = warnings_by("Scale 1e6 1e6 1");
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0],
            "rays start 1.4 m off the largest primitive, which spans 2e+06 m; what touches it is as coarse, and the scene has "
            "what measures 1 m. Divide the primitive, or shrink it");
}

TEST(Precision, FlatInstancesOfSpheresAreTold) {
  const auto warnings_by = [](const std::string& transform, const std::string& shape) {
    return precision_warnings(parse_pbrt(R"(WorldBegin
Shape "trianglemesh" "point3 P" [-1 -1 0 1 -1 1 1 1 1] "integer indices" [0 1 2]
ObjectBegin "ball"
Shape ")" + shape + "\"\nObjectEnd\n" + transform +
                                             "\nObjectInstance \"ball\"\n",
                                         "s.pbrt"));
  };
  EXPECT_TRUE(warnings_by("Scale 1 1e-4 1", "sphere").empty());
  EXPECT_TRUE(warnings_by("Scale 1 1 1e-6", "disk").empty());
  const std::vector<std::string> warnings = warnings_by("Rotate 40 1 2 3 Scale 1 1e-6 1", "sphere");
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0],
            "an instance makes a sphere or cylinder 1e-06 times as thick as wide, which is less than rays tell: its light is "
            "wrong. Use a mesh, or a disk");
}

TEST(Precision, ScenesBelowTheRangeOfFloatsAreTold) {
  EXPECT_TRUE(warnings_of_corridor(4, 0x1p-20f * 0x1p-18f).empty());
  const std::vector<std::string> warnings = warnings_of_corridor(4, 1e-13f);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0],
            "the scene spans 4e-13 m: products of its coordinates leave the range of floats; scale it to 1e-12 m or more");
}

// Anisotropic metal is brushed along dp/du, which runs around discs, tubes and spheres.
TEST(Surface, TangentsOfQuadricsRunAround) {
  const vec3 n = glm::normalize(vec3(1, 2, -1));
  const std::vector<Quadric> quadrics{Disk{{1, 2, 3}, 2, n}, Sphere{{1, 2, 3}, 2}, Cylinder{{1, 2, 3}, 1, n, 2, true}};
  for (const Quadric& quadric : quadrics) {
    SceneBuilder b("quadric");
    b.quadric(quadric, b.material(Diffuse{Rgb(0.5f)}));
    b.camera({5, 5, 5}, {0, 0, 0}, 40, {8, 8});
    const testing::SceneContext stage(b.finish());
    const vec3 axis = std::holds_alternative<Sphere>(quadric) ? vec3(0, 0, 1) : n;
    const Frame across = Frame::from_normal(axis);
    for (const float angle : {0.3f, 2.0f, 4.5f}) {
      const vec3 radial = std::cos(angle) * across.tangent + std::sin(angle) * across.bitangent;
      const vec3 at = vec3(1, 2, 3) + (std::holds_alternative<Cylinder>(quadric) ? 0.5f * n : vec3(0)) + radial;
      const Ray ray{.origin = at + 10.0f * (std::holds_alternative<Disk>(quadric) ? n : radial),
                    .direction = std::holds_alternative<Disk>(quadric) ? -n : -radial};
      const Hit hit = stage.context.rays.closest(ray);
      ASSERT_TRUE(hit);
      const vec3 tangent = glm::normalize(stage.scene.surface_at(ray, hit).tangent);
      EXPECT_NEAR(std::abs(glm::dot(tangent, glm::normalize(glm::cross(axis, radial)))), 1, 1e-3f);
    }
  }
}

}  // namespace
}  // namespace etendue
