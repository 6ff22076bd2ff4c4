// Shapes, their orientation, objects and instances.
#include "accel/kernels/primitive_test.h"
#include "tests/unit/io_pbrt_helpers.h"

#include <algorithm>

namespace etendue {
namespace {

TEST(PbrtShapes, TriangleMeshesAreChecked) {
  const std::string mesh = "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0] ";
  EXPECT_ERROR(world("Shape \"trianglemesh\""), "'P' is missing");
  EXPECT_ERROR(world(mesh), "'indices' is missing");
  EXPECT_ERROR(world(mesh + "\"integer indices\" [0 1]"), "expected three per triangle");
  EXPECT_ERROR(world(mesh + "\"integer indices\" [0 1 4]"), "has 4 as its value 2, but there are 4 points");
  EXPECT_ERROR(world(mesh + "\"integer indices\" [0 -1 2]"), "has -1 as its value 1");
  EXPECT_ERROR(world(mesh + "\"integer indices\" [0 1 2] \"float uv\" [0 0 1]"), "expected pairs");
  EXPECT_ERROR(world("Shape \"trianglemesh\" \"point P\" [0 0 0 1]"), "expected triples");
  const Scene scene =
      world(mesh + "\"integer indices\" [0 1 2 1 2 3] \"float st\" [0 0 1 0 0 1 1 1] \"vector S\" [1 0 0 1 0 0 1 0 0 1 0 0]\n" +
            triangle);
  EXPECT_TRUE(warns(scene, "tangents"));
  ASSERT_EQ(scene.objects[0].shapes.size(), 2u);
  EXPECT_TRUE(scene.objects[0].shapes[0].has_uvs);
  EXPECT_FALSE(scene.objects[0].shapes[1].has_uvs);
  EXPECT_EQ(scene.objects[0].uvs.size(), scene.objects[0].geometry.positions.size());
  EXPECT_EQ(scene.objects[0].geometry.triangles.at(2), uvec3(4, 5, 6));
}

// As pbrt does: it keeps the first of too many coordinates in version 3 alone.
TEST(PbrtShapes, ValuesThatAreNotAsManyAsThePointsAreDropped) {
  const auto read = [](const std::string& film, const std::string& params) {
    return parse_pbrt(
        film + " WorldBegin Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2] " + params,
        "s.pbrt");
  };
  const std::string few = "\"point2 uv\" [0 0 1 0]", many = "\"point2 uv\" [0 0 1 0 0 1 .5 .5]";
  for (const std::string film : {"Film \"image\"", "Film \"rgb\""}) {
    const Scene normals = read(film, "\"normal3 N\" [0 0 1]");
    EXPECT_FALSE(normals.objects[0].shapes.at(0).has_normals);
    EXPECT_TRUE(warns(normals, "'N' has 1 values, but there are 3 points: left out, as by pbrt"));
    EXPECT_FALSE(read(film, few).objects[0].shapes.at(0).has_uvs);
    EXPECT_TRUE(warns(read(film, few), "'uv' has 2 values, but there are 3 points: left out"));
  }
  EXPECT_FALSE(read("Film \"rgb\"", many).objects[0].shapes.at(0).has_uvs);
  const Scene first = read("Film \"image\"", many);
  ASSERT_EQ(first.objects[0].uvs.size(), 3u);
  EXPECT_EQ(first.objects[0].uvs[2], vec2(0, 1));
  EXPECT_TRUE(warns(first, "'uv' has 4 values, but there are 3 points: the first count"));
}

TEST(PbrtShapes, MoreThanATurnIsOne) {
  EXPECT_EQ(world("Shape \"sphere\" \"float phimax\" 400").objects[0].geometry.quadrics.size(), 1u) << "whole";
}

TEST(PbrtShapes, DegenerateTextureCoordinatesAreDiscardedIfAskedInVersion3) {
  const auto mesh = [](const std::string& film, const std::string& uvs, const std::string& asked) {
    return parse_pbrt(
        film + " WorldBegin Shape \"trianglemesh\" \"point P\" [0 0 0  1 0 0  0 1 0] \"normal N\" [0 0 1 0 0 1 0 0 1] " +
            "\"float uv\" [" + uvs + "] \"bool discarddegenerateUVs\" " + asked,
        "s.pbrt");
  };
  const char* const version3 = "Film \"image\"";
  const Scene discarded = mesh(version3, "0 0 .5 1 .5 1", "true");
  EXPECT_FALSE(discarded.objects[0].shapes.at(0).has_uvs);
  EXPECT_TRUE(warns(discarded, "its texture coordinates are degenerate and left out"));
  EXPECT_TRUE(mesh(version3, "0 0 .5 1 .5 1", "false").objects[0].shapes.at(0).has_uvs);
  EXPECT_TRUE(mesh(version3, "0 0 .5 1 .5 .5", "true").objects[0].shapes.at(0).has_uvs);
  EXPECT_ERROR(mesh("Film \"rgb\"", "0 0 .5 1 .5 1", "true"), "discarddegenerateUVs");
}

// The geometric normal where a ray straight down meets the scene near the origin.
vec3 normal_below(const Scene& scene, const vec3& origin) {
  const Ray ray{.origin = origin, .direction = {0, 0, -1}};
  Hit hit;
  const Geometry& g = scene.objects[0].geometry;
  const TriangleRay shear(ray.direction);
  for (std::uint32_t i = 0; i < g.primitive_count(); ++i) intersect_primitive(g, i, ray, shear, hit);
  hit.instance = 0;
  return hit ? scene.surface_at(ray, hit).normal : vec3(0);
}

TEST(PbrtShapes, TrianglesThatNoRayMeetsAreTold) {
  EXPECT_FALSE(warns(world(triangle), "left out"));
  const std::string mesh = "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0] \"integer indices\" ";
  const Scene some = world(triangle + mesh + "[0 1 2 1 1 3]");
  EXPECT_TRUE(warns(some, "s.pbrt:4:1: Shape \"trianglemesh\": 1 of 2 triangles left out, of no area or not finite"));
  EXPECT_TRUE(warns(world(mesh + "[0 1 1 3 3 3]"), "all 2 triangles left out"));
  EXPECT_TRUE(warns(world("Translate 1e10 0 0 " + triangle), "its only triangle left out")) << "as it is placed";
  const TestDirectory directory;
  directory.write("thin.ply",
                  "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                  "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 1 1\n2 2 2\n3 0 1 2\n");
  const std::string scene = directory.write("s.pbrt", "WorldBegin Shape \"plymesh\" \"string filename\" \"thin.ply\"");
  EXPECT_TRUE(warns(read_pbrt(scene), "s.pbrt:1:12: 'thin.ply': its only triangle left out"));
}

TEST(PbrtShapes, OrientationFollowsWindingReversalAndHandedness) {
  const vec3 above(0.25f, 0.25f, 1), mirrored(-0.25f, 0.25f, 1);
  const std::string with_normals =
      "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0] \"normal3 N\" [0 0 -1 0 0 -1 0 0 -1]\n";
  expect_near(normal_below(world(triangle), above), {0, 0, 1});
  expect_near(normal_below(world("ReverseOrientation " + triangle), above), {0, 0, -1});
  // Mirrored, the winding as placed points down; the handedness turns it back up.
  expect_near(normal_below(world("Scale -1 1 1 " + triangle), mirrored), {0, 0, 1});
  expect_near(normal_below(world("ReverseOrientation Scale -1 1 1 " + triangle), mirrored), {0, 0, -1});
  expect_near(normal_below(world(with_normals), above), {0, 0, -1});
  expect_near(normal_below(world("ReverseOrientation " + with_normals), above), {0, 0, 1});
  for (const char* mirror : {"", "Scale -1 1 1 "}) {
    expect_near(normal_below(world(std::string(mirror) + "Shape \"sphere\""), {0, 0, 3}), {0, 0, 1});
    expect_near(normal_below(world(std::string(mirror) + "ReverseOrientation Shape \"sphere\""), {0, 0, 3}), {0, 0, -1});
    expect_near(normal_below(world(std::string(mirror) + "Shape \"disk\""), above), {0, 0, 1});
  }
}

TEST(PbrtShapes, LightsOfVersion3KeepTheSideOfTheirNormals) {
  const std::string reversed =
      "WorldBegin ReverseOrientation AreaLightSource \"diffuse\" Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0] ";
  const std::string normals = "\"normal3 N\" [0 0 -1 0 0 -1 0 0 -1]", told = "pbrt-v3 takes the light of a mesh from the side";
  const vec3 above(0.25f, 0.25f, 1);
  const Scene version3 = parse_pbrt("Film \"image\" " + reversed + normals, "s.pbrt");
  expect_near(normal_below(version3, above), {0, 0, -1});
  EXPECT_TRUE(warns(version3, told));
  const Scene version4 = parse_pbrt("Film \"rgb\" " + reversed + normals, "s.pbrt");
  expect_near(normal_below(version4, above), {0, 0, 1});
  EXPECT_FALSE(warns(version4, told));
  const Scene flat = parse_pbrt("Film \"image\" " + reversed, "s.pbrt");
  expect_near(normal_below(flat, above), {0, 0, -1});
  EXPECT_FALSE(warns(flat, told)) << "by its winding, as pbrt has it";
  // A mirroring transform turns the side that rays find as well.
  const std::string mirrored = "WorldBegin Scale -1 1 1 ",
                    straight = reversed.substr(std::string("WorldBegin ReverseOrientation").size());
  EXPECT_FALSE(warns(parse_pbrt("Film \"image\" " + mirrored + "ReverseOrientation" + straight + normals, "s.pbrt"), told));
  EXPECT_TRUE(warns(parse_pbrt("Film \"image\" " + mirrored + straight + normals, "s.pbrt"), told));
}

TEST(PbrtShapes, NormalsGoByTheInverseTranspose) {
  const Scene scene =
      world("Scale 2 1 1 Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 -1  0 1 0] \"normal3 N\" [1 0 1 1 0 1 1 0 1]");
  expect_near(scene.objects[0].normals.at(0), glm::normalize(vec3(0.5f, 0, 1)));
}

TEST(PbrtShapes, QuadricsUnderSimilaritiesArePlacedDirectly) {
  const Scene scene = world(
      "Translate 1 2 3 Scale 2 2 2 Rotate 90 0 1 0\nShape \"sphere\" \"float radius\" 0.5\n"
      "Shape \"cylinder\" \"float radius\" 0.25 \"float zmin\" 1 \"float zmax\" -1\nShape \"disk\" \"float height\" 1 \"float "
      "innerradius\" 0.5");
  EXPECT_EQ(scene.instances.size(), 1u);
  const auto& quadrics = scene.objects[0].geometry.quadrics;
  ASSERT_EQ(quadrics.size(), 3u);
  const Sphere sphere = std::get<Sphere>(quadrics[0]);
  expect_near(sphere.centre, {1, 2, 3});
  EXPECT_FLOAT_EQ(sphere.radius, 1);
  const Cylinder cylinder = std::get<Cylinder>(quadrics[1]);
  expect_near(cylinder.base, {-1, 2, 3});
  expect_near(cylinder.axis, {1, 0, 0});
  EXPECT_FLOAT_EQ(cylinder.length, 4);
  EXPECT_FLOAT_EQ(cylinder.radius, 0.5f);
  EXPECT_FALSE(cylinder.caps);
  const Disk disk = std::get<Disk>(quadrics[2]);
  expect_near(disk.centre, {3, 2, 3});
  expect_near(disk.normal, {1, 0, 0});
  EXPECT_FLOAT_EQ(disk.inner_radius, 1);
}

TEST(PbrtShapes, DistortedQuadricsBecomeInstances) {
  const Scene scene = world("Translate 1 0 0 Scale 1 2 3 Shape \"sphere\" \"float radius\" 0.5");
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_FLOAT_EQ(std::get<Sphere>(scene.objects.at(1).geometry.quadrics.at(0)).radius, 0.5f);
  expect_near(scene.instances[1].to_world.point({0, 0.5f, 0}), {1, 1, 0});
  const Scene glowing = world("AreaLightSource \"diffuse\" Scale 1 2 3 Shape \"sphere\"");
  EXPECT_EQ(glowing.lights.size(), glowing.objects[0].geometry.triangles.size()) << "a mesh, for instances emit no light";
  EXPECT_GT(glowing.lights.size(), 10000u);
  EXPECT_ERROR(world("Shape \"disk\" \"float innerradius\" 1"), "expected less than the radius");
  EXPECT_ERROR(world("Shape \"cylinder\" \"float zmin\" 1"), "no height");
}

// Texture coordinates where a ray from outside towards the origin meets the scene's one quadric, wherever it was put.
vec2 uv_from(const Scene& scene, const vec3& eye) {
  const auto instance = static_cast<std::uint32_t>(scene.instances.size() - 1);
  const Transform to_object = scene.instances[instance].to_world.inverse();
  const Ray ray{.origin = eye, .direction = -eye};
  Hit hit{.instance = instance, .primitive = 0};
  const Quadric& quadric = scene.objects[scene.instances[instance].object].geometry.quadrics.at(0);
  EXPECT_TRUE(intersect_quadric({.origin = to_object.point(eye), .direction = to_object.vector(-eye)}, quadric, infinity, hit.t,
                                hit.uv));
  return scene.surface_at(ray, hit).uv;
}

TEST(PbrtShapes, TexturedQuadricsKeepPbrtsCoordinates) {
  const std::string checks = "Texture \"t\" \"spectrum\" \"checkerboard\" Material \"diffuse\" \"texture reflectance\" \"t\" ";
  // On pbrt's sphere u is the azimuth from x towards y, and v runs from 0 at -z to 1 at +z.
  const float up = std::sin(pi / 4);
  const vec2 plain = uv_from(world(checks + "Shape \"sphere\""), vec3(0, 3 * up, 3 * up));
  EXPECT_NEAR(plain.x, 0.25f, 1e-5f);
  EXPECT_NEAR(plain.y, 0.75f, 1e-5f);
  // Turned by 90 degrees about x, the sphere's y axis lies along the world's z, its z axis along -y.
  const vec2 turned = uv_from(world(checks + "Rotate 90 1 0 0 Shape \"sphere\""), vec3(0, -3 * up, 3 * up));
  EXPECT_NEAR(turned.x, 0.25f, 1e-5f);
  EXPECT_NEAR(turned.y, 0.75f, 1e-5f);
  const vec2 cylinder = uv_from(world(checks + "Rotate 90 0 0 1 Shape \"cylinder\""), vec3(-3, 0, 1.5f));
  EXPECT_NEAR(cylinder.x, 0.25f, 1e-5f);
  EXPECT_NEAR(cylinder.y, 0.75f, 1e-5f);
}

TEST(PbrtShapes, BrushedQuadricsKeepTheirAxes) {
  const std::string brushed = "Material \"conductor\" \"float uroughness\" .3 \"float vroughness\" .01 ";
  const vec2 turned = uv_from(world(brushed + "Rotate 90 1 0 0 Shape \"sphere\""), vec3(0, -2, 2));
  EXPECT_NEAR(turned.x, 0.25f, 1e-5f);
  EXPECT_NEAR(turned.y, 0.75f, 1e-5f);
}

// An instance cannot emit, and a quadric of the world has lost the axes that its coordinates count from.
TEST(PbrtShapes, TexturedQuadricsThatGlowKeepPbrtsCoordinates) {
  const std::string checks =
      "Texture \"t\" \"spectrum\" \"checkerboard\" Material \"diffuse\" \"texture reflectance\" \"t\" "
      "AreaLightSource \"diffuse\" ";
  const Scene scene = world(checks + "Rotate 90 1 0 0 Shape \"sphere\"");
  const Object& object = scene.objects[0];
  EXPECT_EQ(scene.lights.size(), object.geometry.triangles.size());
  const auto& positions = object.geometry.positions;
  const vec3 place = std::sqrt(0.5f) * vec3(0, -1, 1);
  const auto nearest = std::ranges::min_element(positions, {}, [&](const vec3& p) { return glm::length(p - place); });
  ASSERT_NE(nearest, positions.end());
  expect_near(*nearest, place);
  const vec2 uv = object.uvs[static_cast<std::size_t>(nearest - positions.begin())];
  EXPECT_NEAR(uv.x, 0.25f, 1e-5f);
  EXPECT_NEAR(uv.y, 0.75f, 1e-5f);
  EXPECT_EQ(world(checks + "Translate 1 0 0 Shape \"disk\"").lights.size(), 1u) << "whose axes are the world's";
}

TEST(PbrtShapes, QuadrilateralsOfAPlyArePbrts) {
  const TestDirectory directory;
  const auto ply = [](const std::string& last_height) {
    return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
           "property list uchar int vertex_indices\nend_header\n0 0 0\n2 0 0\n2 2 0\n0 2 " +
           last_height + "\n4 0 1 2 3\n";
  };
  directory.write("q.ply", ply("0"));
  directory.write("bent.ply", ply("1"));
  const auto read = [&](const std::string& film, const std::string& before, const std::string& file = "q.ply") {
    return parse_pbrt(film + " WorldBegin " + before + " Shape \"plymesh\" \"string filename\" \"" + file + "\"",
                      directory.path("s.pbrt"));
  };
  const std::string checks = "Texture \"t\" \"spectrum\" \"checkerboard\" Material \"matte\" \"texture Kd\" \"t\"";
  const Scene version4 = read("", checks), version3 = read("Film \"image\"", checks);
  const Object &patch = version4.objects[0], &pair = version3.objects[0];
  ASSERT_EQ(patch.uvs.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(patch.uvs[i], 0.5f * vec2(patch.geometry.positions[i]));
  EXPECT_EQ(pair.uvs, (std::vector<vec2>{{0, 0}, {1, 0}, {1, 1}, {1, 0}, {1, 1}, {0, 0}})) << "the second: corners 3, 0, 2";
  EXPECT_TRUE(read("", "").objects[0].uvs.empty());
  const Scene light = read("", "AreaLightSource \"diffuse\" \"float power\" 10");
  EXPECT_NEAR(std::get<AreaLight>(light.lights.at(1)).radiance.x, 10 / (4 * pi), 1e-5f) << "one light, not one a triangle";
  EXPECT_TRUE(warns(read("", "", "bent.ply"), "1 quadrilaterals are bent"));
  EXPECT_FALSE(warns(version4, "bent"));
  EXPECT_FALSE(warns(read("Film \"image\"", "", "bent.ply"), "bent"));
}

TEST(PbrtShapes, QuadrilateralsOfAPlyThatShowTheirTextureOtherwiseAreTold) {
  const TestDirectory directory;
  const auto read = [&](const std::string& top, const std::string& normals, const std::string& before, const char* film = "") {
    directory.write("q.ply",
                    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                    "property float nx\nproperty float ny\nproperty float nz\nelement face 1\n"
                    "property list uchar int vertex_indices\nend_header\n0 0 0 0 0 1\n3 0 0 0 0 1\n" +
                        top + " 3 0 " + normals + "\n0 3 0 0 0 1\n4 0 1 2 3\n");
    return parse_pbrt(std::string(film) + " WorldBegin " + before + " Shape \"plymesh\" \"string filename\" \"q.ply\"",
                      directory.path("s.pbrt"));
  };
  const std::string checks = "Texture \"t\" \"spectrum\" \"checkerboard\" Material \"diffuse\" \"texture reflectance\" \"t\"";
  const char* const told = "1 quadrilaterals show their texture or normals over two triangles";
  EXPECT_TRUE(warns(read("1", "0 0 1", checks), told));
  EXPECT_TRUE(warns(read("3", "1 0 0", ""), told));
  EXPECT_FALSE(warns(read("1", "0 0 1", ""), told));
  EXPECT_FALSE(warns(read("3", "0 0 1", checks), told));
  EXPECT_FALSE(warns(read("1", "1 0 0", checks, "Film \"image\""), told)) << "pbrt-v3 has two triangles as well";
}

TEST(PbrtShapes, LightsThatAreMirroredQuadricsAreTold) {
  const std::string disk = "Scale 1 1 -1 AreaLightSource \"diffuse\" ", two_sided = "\"bool twosided\" \"true\" ";
  EXPECT_TRUE(warns(world(disk + "Shape \"disk\""), "under a mirroring transform pbrt shows the other side"));
  EXPECT_TRUE(warns(world(disk + "Shape \"sphere\" \"float phimax\" 90"), "under a mirroring transform"));
  EXPECT_FALSE(warns(world(disk + two_sided + "Shape \"disk\""), "mirroring"));
  EXPECT_FALSE(warns(world(disk + triangle), "mirroring"));
}

TEST(PbrtShapes, GlassQuadricsThatAreMirroredAreTold) {
  const std::string mirrored = "Scale 1 1 -1 ", sphere = "Shape \"sphere\"", glass = "Material \"dielectric\" ";
  EXPECT_TRUE(warns(world(mirrored + glass + sphere), "takes what lies outside for the inside of glass"));
  EXPECT_TRUE(warns(world(mirrored + "Material \"glass\" Shape \"sphere\" \"float phimax\" 90"), "the inside of glass"));
  EXPECT_FALSE(warns(world(glass + sphere), "inside of glass"));
  EXPECT_FALSE(warns(world(mirrored + sphere), "inside of glass"));
  EXPECT_FALSE(warns(world(mirrored + "Material \"thindielectric\" " + sphere), "inside of glass"));
  EXPECT_FALSE(warns(world(mirrored + glass + triangle), "inside of glass"));
}

TEST(PbrtShapes, ObjectsAreInstancedByName) {
  const Scene scene = world("ObjectBegin \"o\" Translate 1 0 0 " + triangle +
                            "ObjectEnd\nTranslate 0 5 0 ObjectInstance \"o\" Scale 2 2 2 ObjectInstance \"o\"");
  ASSERT_EQ(scene.instances.size(), 3u);
  EXPECT_EQ(scene.objects.size(), 2u);
  EXPECT_TRUE(scene.objects[0].shapes.empty());
  expect_near(scene.instances[1].to_world.point(scene.objects[1].geometry.positions[1]), {2, 5, 0});
  expect_near(scene.instances[2].to_world.point(scene.objects[1].geometry.positions[1]), {4, 5, 0});
  EXPECT_EQ(world("ObjectBegin \"o\" " + triangle + "ObjectEnd").objects.size(), 1u) << "never instanced, left out";
  EXPECT_ERROR(world("ObjectInstance \"o\""), "s.pbrt:3:16: unknown object 'o'");
  EXPECT_ERROR(world("ObjectBegin \"o\" ObjectInstance \"o\" ObjectEnd"), "instances do not nest");
  EXPECT_ERROR(world("ObjectBegin \"o\" ObjectBegin \"p\""), "inside another object");
  EXPECT_ERROR(world("ObjectBegin \"o\" ObjectEnd ObjectBegin \"o\""), "defined twice");
  EXPECT_ERROR(world("ObjectBegin \"o\" AreaLightSource \"diffuse\" " + triangle + "ObjectEnd"), "cannot emit light");
}

TEST(PbrtShapes, ObjectsOfANameAreReplacedByLaterOnesInVersion3) {
  const std::string instance = "ObjectInstance \"o\" ";
  const Scene scene = parse_pbrt("Film \"image\" WorldBegin ObjectBegin \"o\" " + triangle + "ObjectEnd " + instance +
                                     "ObjectBegin \"o\" Translate 1 0 0 " + triangle + "ObjectEnd " + instance,
                                 "s.pbrt");
  EXPECT_TRUE(warns(scene, "object 'o' is defined again: its later instances are of this one"));
  ASSERT_EQ(scene.instances.size(), 3u);
  const auto second_corner = [&](std::size_t index) {
    const Instance& i = scene.instances[index];
    return i.to_world.point(scene.objects[i.object].geometry.positions[1]);
  };
  expect_near(second_corner(1) + vec3(1, 0, 0), second_corner(2));
}

}  // namespace
}  // namespace etendue
