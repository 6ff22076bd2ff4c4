#include "framework/io/load_scene.h"
#include "framework/io/mesh/left_out.h"
#include "framework/io/mesh/mesh_scene.h"
#include "framework/io/mesh/obj.h"
#include "framework/io/mesh/smf.h"
#include "framework/io/object_builder.h"
#include "tests/unit/io_helpers.h"

#include <set>

namespace etendue {
namespace {

const std::string quad_obj =
    "# a quad and a triangle that shares an edge\n"
    "mtllib none.mtl\n"
    "v 0 0 0\nv +1 0 0 1\nv 1 1 0 0.5 0.5 0.5\nv 0 1. .0\n"
    "vt 0 0\nvt 1 0 0\nvt 1 1\nvt 0\n"
    "vn 0 0 2\n"
    "o thing\ng part\nusemtl grey\ns 1\n"
    "f 1/1/1 2/2/1 3/3/1 4/4/1 # the quad\n"
    "v 2 0 1e0\n"
    "f -4//1 -1//1 -3//1\n"
    "l 1 2\n";

TEST(ObjReader, PolygonsBecomeTriangles) {
  const TriangleMesh mesh = parse_obj(quad_obj, "m.obj");
  ASSERT_EQ(mesh.triangles.size(), 3u);
  // Four corners of the quad; the triangle's have no texture coordinate, so they are vertices of their own.
  ASSERT_EQ(mesh.positions.size(), 7u);
  EXPECT_EQ(mesh.normals.size(), 7u);
  EXPECT_EQ(mesh.uvs.size(), 7u);
  const uvec3 last = mesh.triangles[2];
  EXPECT_EQ(mesh.positions[last.x], vec3(1, 0, 0));
  EXPECT_EQ(mesh.positions[last.y], vec3(2, 0, 1));
  EXPECT_EQ(mesh.positions[last.z], vec3(1, 1, 0));
  EXPECT_EQ(mesh.normals[last.x], vec3(0, 0, 1)) << "made unit";
  EXPECT_TRUE(mesh.names_materials);
}

TEST(ObjReader, QuadCoversItsAreaOnce) {
  const TriangleMesh mesh = parse_obj("v 0 0 0\nv 3 0 0\nv 3 2 0\nv 0 2 0\nv -1 1 0\nf 1 2 3 4 5\n", "m.obj");
  ASSERT_EQ(mesh.triangles.size(), 3u);
  float area = 0;
  for (const uvec3& t : mesh.triangles) {
    const vec3 cross = glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
    EXPECT_GT(cross.z, 0) << "winding kept";
    area += 0.5f * cross.z;
  }
  EXPECT_FLOAT_EQ(area, 7);
}

TEST(ObjReader, PolygonsMayBeFansOfTheirFirstCorner) {
  // The shorter diagonal of this saddle leads from its second corner to the fourth.
  const std::string saddle = "v -2 0 1\nv 0 -1 0\nv 2 0 1\nv 0 1 0\nv 0 0 9\n";
  const auto with_corner = [](const TriangleMesh& mesh, const vec3& corner) {
    return std::ranges::count_if(mesh.triangles, [&](const uvec3& t) {
      return mesh.positions[t.x] == corner || mesh.positions[t.y] == corner || mesh.positions[t.z] == corner;
    });
  };
  const std::string quad = saddle + "f 1 2 3 4\r\ng other\nf 1 2 -1";
  for (const TriangleMesh& mesh :
       {parse_obj(quad, "m.obj", Polygons::fans), parse_obj_parts(quad, "m.obj", false).at(0).mesh}) {
    ASSERT_EQ(mesh.triangles.size(), 3u);
    EXPECT_EQ(with_corner(mesh, {2, 0, 1}), 2);
    EXPECT_EQ(with_corner(mesh, {0, 1, 0}), 1);
    EXPECT_EQ(with_corner(mesh, {0, 0, 9}), 1);
  }
  EXPECT_EQ(parse_obj_parts(quad, "m.obj", true).size(), 2u);
  EXPECT_EQ(with_corner(parse_obj(quad, "m.obj"), {0, 1, 0}), 2) << "else cut along the shorter diagonal";
}

TEST(ObjReader, VerticesAreSharedPerDistinctTriple) {
  const TriangleMesh shared = parse_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", "m.obj");
  EXPECT_EQ(shared.positions.size(), 4u);
  const TriangleMesh split =
      parse_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvn 0 1 1\nf 1//1 2//1 3//1\nf 1//2 3//1 4//1\n", "m.obj");
  EXPECT_EQ(split.positions.size(), 5u);
}

TEST(ObjReader, LineEndsAndContinuationsAreUnderstood) {
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    const TriangleMesh mesh =
        parse_obj("v 0 0 0" + end + "v 1 \\" + end + " 0 0" + end + "\tv 0 1 0 " + end + end + "f 1 2 \\" + end + "3", "m.obj");
    ASSERT_EQ(mesh.triangles.size(), 1u);
    EXPECT_EQ(mesh.positions[1], vec3(1, 0, 0));
  }
}

TEST(ObjReader, ByteOrderMarkHidesNoVertex) {
  const TriangleMesh mesh = parse_obj("\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 0 1 0\nv 7 7 7\nf 1 2 3\n", "m.obj");
  EXPECT_EQ(mesh.positions, (std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_EQ(parse_smf("\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "m.smf").positions, mesh.positions);
}

TEST(ObjReader, ObsoleteFacesAreRead) {
  const std::string four = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";
  EXPECT_EQ(parse_obj(four + "fo 1 2 3\nf 2 4 3\n", "m.obj").triangles,
            parse_obj(four + "f 1 2 3\nf 2 4 3\n", "m.obj").triangles);
  EXPECT_ERROR(parse_obj(four + "fo 1 2 5\n", "m.obj"), "m.obj:5:8: index 5 of a vertex");
}

TEST(ObjReader, ErrorsNameTheirPlace) {
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_ERROR(parse_obj("v 0 0 zero\n", "m.obj"), "m.obj:1:7: expected a number");
  EXPECT_ERROR(parse_obj("v 0 0 nan\n", "m.obj"), "m.obj:1:7");
  EXPECT_ERROR(parse_obj("v 0 0 1e40\n", "m.obj"), "m.obj:1:7");
  EXPECT_ERROR(parse_obj("v 0 1..5 0\n", "m.obj"), "m.obj:1:5");
  EXPECT_ERROR(parse_obj("v 0 0\n", "m.obj"), "m.obj:1:6: expected 3 to 8 numbers after 'v', found 2");
  EXPECT_ERROR(parse_obj("vn 0 0\n", "m.obj"), "expected 3 numbers after 'vn', found 2");
  EXPECT_ERROR(parse_obj(three + "f 1 2 4\n", "m.obj"), "m.obj:4:7: index 4 of a vertex, but there are 3");
  EXPECT_ERROR(parse_obj(three + "f 1 2 0\n", "m.obj"), "m.obj:4:7: index 0 of a vertex");
  EXPECT_ERROR(parse_obj(three + "f 1 2 -4\n", "m.obj"), "m.obj:4:7: index -4 of a vertex, but there are 3 before it");
  EXPECT_ERROR(parse_obj(three + "f 1/1 2/1 3/1\n", "m.obj"), "index 1 of a texture coordinate, but there are 0");
  EXPECT_ERROR(parse_obj(three + "f 1//1 2//1 3//1\n", "m.obj"), "index 1 of a normal, but there are 0");
  EXPECT_ERROR(parse_obj(three + "f 1 2\n", "m.obj"), "m.obj:4:6: a face needs 3 vertices or more, found 2");
  for (const char* corner : {"3.5", "/3", "3/1/1/1", "3/1/1/", "3///", "//", "x", "99999999999"})
    EXPECT_ERROR(parse_obj(three + "vt 0 0\nvn 0 0 1\nf 1 2 " + corner + "\n", "m.obj"), "m.obj:6:7: ") << corner;
  EXPECT_ERROR(parse_obj(three, "m.obj"), "m.obj: no faces");
  EXPECT_ERROR(parse_obj("", "m.obj"), "no faces");
}

TEST(ObjReader, LastSlashesMayStandForNothing) {
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\n";
  for (const char* face : {"f 1/ 2/ 3/", "f 1// 2// 3//", "f -3// -2// -1//\n"}) {
    const TriangleMesh mesh = parse_obj(three + face, "m.obj");
    EXPECT_EQ(mesh.positions.at(1), vec3(1, 0, 0)) << face;
    EXPECT_EQ(mesh.triangles.size(), 1u) << face;
  }
  EXPECT_EQ(parse_obj(three + "f 1/1/ 2/2/ 3/3/", "m.obj").uvs.at(2), vec2(0, 1));
}

TEST(ObjReader, PartsHaveTheirMaterials) {
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl  old glass \ng a\ng b\nf 1 2 3\nf 1 3 2\n"
      "g c\nf 1/1 2/1 3/1\nusemtl # none\nf 1 2 3\nusemtl d\n";
  const std::vector<ObjPart> parts = parse_obj_parts(text, "m.obj", true);
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0].material, "old glass");
  EXPECT_EQ(parts[0].mesh.triangles.size(), 2u);
  EXPECT_EQ(parts[0].mesh.positions.size(), 3u);
  EXPECT_EQ(parts[1].material, "old glass");
  EXPECT_TRUE(parts[0].mesh.uvs.empty());
  EXPECT_FALSE(parts[1].mesh.uvs.empty());
  EXPECT_EQ(parts[2].material, "");
  EXPECT_EQ(parse_obj_parts(text, "m.obj", false).size(), 1u);
  EXPECT_ERROR(parse_obj_parts("g a\n", "m.obj", true), "m.obj: no faces");
}

TEST(ObjReader, DamagedFilesNeitherCrashNorHang) {
  damage(quad_obj, 4000, [](const std::string& text) { parse_obj(text, "m.obj"); });
  damage("g a\n" + quad_obj + "usemtl b c \nf 1 2 3\n", 4000,
         [](const std::string& text) { parse_obj_parts(text, "m.obj", true); });
}

const std::string blocks_smf =
    "# two blocks, each with its own numbers\nbegin\nbind c face\nv 0 0 0\nv 1 0 0\nv 0 1 0\nc 1 0 0\nf 1 2 3\nend\n"
    "begin\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nn 0 0 1\nf 1 2 4 3\nf -1 -2 -3\nend\n";

TEST(SmfReader, BlocksNumberTheirOwnVertices) {
  const TriangleMesh mesh = parse_smf(blocks_smf, "m.smf");
  EXPECT_EQ(mesh.positions.size(), 7u);
  ASSERT_EQ(mesh.triangles.size(), 4u);
  EXPECT_EQ(mesh.triangles[0], uvec3(0, 1, 2));
  EXPECT_EQ(mesh.triangles[1], uvec3(3, 4, 6));
  EXPECT_EQ(mesh.triangles[2], uvec3(3, 6, 5));
  EXPECT_EQ(mesh.triangles[3], uvec3(6, 5, 4));
}

TEST(SmfReader, ErrorsNameTheirPlace) {
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_EQ(parse_smf("f 1 2 3\n" + three, "m.smf").triangles.size(), 1u) << "vertices may follow";
  EXPECT_ERROR(parse_smf("v 0 0\n", "m.smf"), "m.smf:1:6: expected 3 numbers");
  EXPECT_ERROR(parse_smf("v 0 0 0 0\n", "m.smf"), "m.smf:1:9");
  EXPECT_ERROR(parse_smf("v 0 a 0\n", "m.smf"), "m.smf:1:5: expected a number");
  EXPECT_ERROR(parse_smf(three + "f 1 2\n", "m.smf"), "m.smf:4:6: a face needs 3");
  EXPECT_ERROR(parse_smf(three + "f 1 2 4\n", "m.smf"), "m.smf:4:1: a face refers to vertex 4, but the file has 3");
  EXPECT_ERROR(parse_smf(three + "f 1 2 0\n", "m.smf"), "m.smf:4:7: vertex 0");
  EXPECT_ERROR(parse_smf(three + "f 1 2 -4\n", "m.smf"), "m.smf:4:7: vertex -4");
  EXPECT_ERROR(parse_smf(three + "f 1/1 2 3\n", "m.smf"), "m.smf:4:3: expected the index of a vertex");
  EXPECT_ERROR(parse_smf("end\n", "m.smf"), "m.smf:1:1: 'end' without 'begin'");
  EXPECT_ERROR(parse_smf("begin\n" + three + "f 1 2 3\n", "m.smf"), "inside a begin block");
  EXPECT_ERROR(parse_smf("scale 2 2 2\n", "m.smf"), "m.smf:1:1: 'scale' is not supported");
  EXPECT_ERROR(parse_smf("v 0 0 0\nbegim\n", "m.smf"), "unknown keyword 'begim'; did you mean 'begin'");
  EXPECT_ERROR(parse_smf(three, "m.smf"), "m.smf: no faces");
}

TEST(SmfReader, DamagedFilesNeitherCrashNorHang) {
  damage(blocks_smf, 4000, [](const std::string& text) { parse_smf(text, "m.smf"); });
}

// Is every vertex of the mesh inside the camera's image?
bool frames(const Scene& scene) {
  const vec2 extent = scene.camera.half_extent(scene.resolution);
  for (const vec3& p : scene.objects[0].geometry.positions) {
    const vec3 c = scene.camera.to_world.inverse().point(p);
    if (!(c.z > 0 && std::abs(c.x) <= extent.x * c.z && std::abs(c.y) <= extent.y * c.z)) return false;
  }
  return true;
}

TEST(MeshScene, CameraFramesMeshesOfAnySize) {
  for (const float size : {1e-4f, 1.0f, 1e6f}) {
    TriangleMesh mesh;
    mesh.positions = {{size, 2 * size, 0}, {3 * size, 0, size}, {0, -size, -size}, {size, size, 5 * size}};
    mesh.triangles = {{0, 1, 2}, {1, 2, 3}};
    const Scene scene = mesh_scene(mesh, "m");
    EXPECT_TRUE(frames(scene)) << size;
    EXPECT_EQ(scene.resolution, ivec2(512));
    EXPECT_EQ(scene.lights.size(), 2u);
    EXPECT_TRUE(std::holds_alternative<Diffuse>(scene.materials.at(0)));
  }
}

TEST(MeshScene, ImageIsNotMirrored) {
  TriangleMesh mesh;
  mesh.positions = {{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  const Scene scene = mesh_scene(mesh, "m");
  const Transform to_camera = scene.camera.to_world.inverse();
  EXPECT_GT(to_camera.point({1, 0, 0}).x, to_camera.point({-1, 0, 0}).x) << "+x lies to the right, seen from the front";
  EXPECT_GT(to_camera.point({0, 1, 0}).y, to_camera.point({0, 0, 0}).y);
}

TEST(MeshScene, DegenerateExtentsAreFramed) {
  TriangleMesh mesh;
  mesh.positions = {{3, 3, 3}, {3, 3, 3}, {3, 3, 3}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_TRUE(frames(mesh_scene(mesh, "m")));
  for (vec3& p : mesh.positions) p = vec3(0);
  EXPECT_TRUE(frames(mesh_scene(mesh, "m")));
  mesh.positions[0] = vec3(3e38f, 0, 0);
  EXPECT_ERROR(mesh_scene(mesh, "m"), "expected 1e+12 m at most");
}

// Else a file of nothing but slivers is a black image without a reason.
TEST(MeshScene, TrianglesThatNoRayMeetsAreTold) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {1, 2, 3}};
  EXPECT_TRUE(mesh_scene(mesh, "m").warnings.empty());
  mesh.triangles.emplace_back(0, 1, 3);  // on a line
  ASSERT_EQ(mesh_scene(mesh, "m").warnings.size(), 1u);
  EXPECT_EQ(mesh_scene(mesh, "m").warnings[0], "m: 1 of 3 triangles left out, of no area or not finite");
  mesh.triangles = {{0, 1, 3}, {2, 2, 3}};
  EXPECT_EQ(mesh_scene(mesh, "m").warnings.at(0),
            "m: all 2 triangles left out, of no area or not finite: nothing of it can be seen");
  mesh.triangles.pop_back();
  EXPECT_TRUE(mesh_scene(mesh, "m").warnings.at(0).starts_with("m: its only triangle left out"));
}

TEST(ObjectBuilder, CountsTrianglesThatAreNotFinite) {
  for (const float bad : {std::nanf(""), infinity, -infinity}) {
    ObjectBuilder builder;
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, bad, 1}};
    mesh.triangles = {{0, 1, 2}};
    EXPECT_EQ(builder.add(mesh, {}), 0u);
    mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {3, 1, 2}};
    EXPECT_EQ(builder.add(mesh, {}), 2u);
  }
}

// Those that miss most by name, the others together: a scene of many meshes does not fill the screen.
TEST(LeftOutTriangles, SumsUpManyMeshes) {
  LeftOutTriangles left_out;
  for (std::uint64_t i = 0; i < 9; ++i) {
    left_out.add("m" + std::to_string(i), 10, i);
    EXPECT_EQ(left_out.warnings().size(), std::min<std::uint64_t>(i, 5));
  }
  EXPECT_TRUE(left_out.warnings()[0].starts_with("m8: 8 of 10 "));
  EXPECT_TRUE(left_out.warnings()[4].starts_with("4 more meshes: 10 of 40 "));
}

TEST(LoadScene, FilesAreToldApartByTheirEnding) {
  const TestDirectory directory;
  const std::string obj = directory.write("quad.OBJ", quad_obj), smf = directory.write("blocks.smf", blocks_smf);
  EXPECT_EQ(load_scene(obj).triangle_count(), 3u);
  EXPECT_EQ(load_scene(obj).name, obj);
  EXPECT_EQ(load_scene(smf).triangle_count(), 4u);
  EXPECT_ERROR(load_scene(directory.write("m.txt", "x")), "ends in .pbrt, .xml, .obj, .smf or .ply");
  EXPECT_ERROR(load_scene("absent.pbrt", {"cells.toml", 3, 11}), "cells.toml:3:11: no such scene file: 'absent.pbrt'");
}

TEST(LoadScene, BuiltinNamesAreUniqueAndChecked) {
  std::set<std::string> names;
  for (const BuiltinScene& scene : builtin_scenes()) EXPECT_TRUE(names.insert(scene.name).second) << scene.name;
  ASSERT_FALSE(names.empty());
  const std::string first = "builtin:" + *names.begin();
  EXPECT_EQ(load_scene(first).name, first);
  EXPECT_ERROR(load_scene(first + "x"), "command line: unknown scene '" + first + "x'; did you mean '" + first + "'");
}

TEST(LoadScene, BuiltinParametersChangeTheSceneAndAreChecked) {
  const auto triangles = [](const std::string& name) { return load_scene(name).triangle_count() - 12; };  // less the box
  EXPECT_EQ(triangles("builtin:mesh"), 100'000u);
  EXPECT_EQ(load_scene("builtin:mesh?triangles=100k").hash(), load_scene("builtin:mesh").hash());
  for (const char* count : {"1e3", "1000", "1k"}) EXPECT_EQ(triangles(std::string("builtin:mesh?triangles=") + count), 1000u);
  const Scene small = load_scene("builtin:stadium?triangles=1e3,size=10"),
              large = load_scene("builtin:stadium?triangles=1e3,size=1e3");
  EXPECT_EQ(small.name, "builtin:stadium?triangles=1e3,size=10");
  EXPECT_EQ(small.triangle_count(), large.triangle_count());
  EXPECT_NEAR(large.bounds().diagonal().x, 100 * small.bounds().diagonal().x, 1e-3 * large.bounds().diagonal().x);
  const Location where{"x.toml", 2, 3};
  EXPECT_ERROR(check_builtin("builtin:mesh?triangle=5k", where), "unknown parameter 'triangle'; did you mean 'triangles'");
  EXPECT_ERROR(check_builtin("builtin:mesh?triangles=7", where), "x.toml:2:3: builtin:mesh: triangles = 7 is out of range");
  EXPECT_ERROR(check_builtin("builtin:mesh?triangles", where), "expected key=value");
  EXPECT_ERROR(check_builtin("builtin:mesh?triangles=1k,triangles=2k", where),
               "x.toml:2:3: 'builtin:mesh?triangles=1k,triangles=2k': triangles is given twice");
  EXPECT_ERROR(check_builtin("builtin:cornell-box?size=2", where), "builtin:cornell-box has no parameters");
  EXPECT_ERROR(check_builtin("builtin:mash?triangles=1k", where), "unknown scene 'builtin:mash'");
  EXPECT_NO_THROW(check_builtin("builtin:stadium?size=20", where));
}

}  // namespace
}  // namespace etendue
