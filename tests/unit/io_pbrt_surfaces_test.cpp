// Shapes that become meshes, and textures that are baked for them.
#include "framework/io/mesh/loop_subdivision.h"
#include "framework/io/pbrt/noise.h"
#include "framework/io/pbrt/texture_bake.h"
#include "tests/unit/io_pbrt_helpers.h"

#include <fmt/format.h>

#include <fstream>

namespace etendue {
namespace {

const Object& object_of(const Scene& scene) { return scene.objects.at(0); }

// Calls `visit(position, normal)` for each vertex of a scene's one mesh, and holds that triangles are wound as the normals say.
template <class Visit>
void for_vertices(const Scene& scene, const Visit& visit) {
  const Object& object = object_of(scene);
  ASSERT_GT(object.geometry.triangles.size(), 0u);
  ASSERT_EQ(object.normals.size(), object.geometry.positions.size());
  for (std::size_t i = 0; i < object.normals.size(); ++i) visit(object.geometry.positions[i], object.normals[i]);
  for (const uvec3& t : object.geometry.triangles) {
    const auto& p = object.geometry.positions;
    const vec3 n = glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x]);
    EXPECT_GT(glm::dot(n, object.normals[t.x] + object.normals[t.y] + object.normals[t.z]), 0);
  }
}

// The farthest midpoint of an edge.
template <class Distance>
float farthest_off(const Scene& scene, const Distance& distance) {
  float most = 0;
  const auto& p = object_of(scene).geometry.positions;
  for (const uvec3& t : object_of(scene).geometry.triangles)
    for (int i = 0; i < 3; ++i) most = std::max(most, std::abs(distance(0.5f * (p[t[i]] + p[t[(i + 1) % 3]]))));
  return most;
}

TEST(PbrtSurfaces, PartsOfQuadricsLieOnThem) {
  const Scene sphere = world("Shape \"sphere\" \"float radius\" 2 \"float zmin\" -1 \"float phimax\" 270");
  for_vertices(sphere, [](const vec3& p, const vec3& n) {
    EXPECT_NEAR(glm::length(p), 2, 1e-5f);
    EXPECT_GE(p.z, -1 - 1e-5f);
    EXPECT_FALSE(p.x > 1e-4f && p.y < -1e-4f) << "the last quarter is missing";
    EXPECT_NEAR(glm::dot(n, p / 2.0f), 1, 1e-4f);
  });
  EXPECT_LT(farthest_off(sphere, [](const vec3& p) { return glm::length(p) - 2; }), 1e-3f * 2);
  for_vertices(world("Shape \"cylinder\" \"float phimax\" 180"), [](const vec3& p, const vec3& n) {
    EXPECT_NEAR(glm::length(vec2(p)), 1, 1e-5f);
    EXPECT_NEAR(glm::dot(vec2(n), vec2(p)), 1, 1e-4f);
  });
  for_vertices(world("Shape \"disk\" \"float phimax\" 90 \"float innerradius\" .5"), [](const vec3& p, const vec3& n) {
    EXPECT_GE(glm::length(vec2(p)), 0.5f - 1e-5f);
    expect_near(n, {0, 0, 1});
  });
  const float slope = std::sqrt(0.8f * 0.8f + 1.4f * 1.4f);
  for_vertices(world("Shape \"cone\" \"float radius\" 0.8 \"float height\" 1.4"), [&](const vec3& p, const vec3& n) {
    EXPECT_NEAR(glm::length(vec2(p)), 0.8f * (1 - p.z / 1.4f), 1e-4f);
    EXPECT_NEAR(n.z, 0.8f / slope, 1e-4f);
  });
  const Scene paraboloid = world("Shape \"paraboloid\" \"float radius\" 0.8 \"float zmax\" 1.4");
  for_vertices(paraboloid, [](const vec3& p, const vec3& n) {
    EXPECT_NEAR(p.z, 1.4f * glm::dot(vec2(p), vec2(p)) / 0.64f, 1e-4f);
    EXPECT_LT(n.z, 0);
  });
  const Scene hyperboloid = world("Shape \"hyperboloid\" \"point p1\" [1 1 1] \"point p2\" [1 -1 -1]");
  for_vertices(hyperboloid, [](const vec3& p, const vec3&) { EXPECT_NEAR(p.x * p.x + p.y * p.y - p.z * p.z, 1, 1e-4f); });
  EXPECT_LT(
      farthest_off(hyperboloid, [](const vec3& p) { return std::sqrt(p.x * p.x + p.y * p.y) - std::sqrt(1 + p.z * p.z); }),
      1e-3f);
  for (const char* points : {"\"point p1\" [1 0 1] \"point p2\" [.5 0 0]", "\"point p1\" [.5 0 0] \"point p2\" [1 0 1]"})
    for_vertices(world("Shape \"hyperboloid\" " + std::string(points)),
                 [](const vec3& p, const vec3& n) { EXPECT_GT(glm::dot(vec2(n), vec2(p)), 0) << "outwards"; });
}

TEST(PbrtSurfaces, SubdivisionRoundsAnOctahedron) {
  const std::string octahedron =
      "Shape \"loopsubdiv\" \"integer indices\" [0 2 4 2 1 4 1 3 4 3 0 4 2 0 5 1 2 5 3 1 5 0 3 5] "
      "\"point P\" [1 0 0 -1 0 0 0 1 0 0 -1 0 0 0 1 0 0 -1] \"integer levels\" ";
  const Scene scene = world(octahedron + "3");
  EXPECT_EQ(object_of(scene).geometry.triangles.size(), 8u * 64);
  for (std::size_t i = 0; i < object_of(scene).normals.size(); ++i) {
    const vec3 p = object_of(scene).geometry.positions[i];
    EXPECT_NEAR(glm::length(p), 0.46f, 0.06f);
    EXPECT_LT(glm::dot(object_of(scene).normals[i], p), -0.4f) << "against the winding, as pbrt has it";
  }
  // A vertex of four neighbours keeps 1 / 2 of itself and takes 1 / 8 of each, which are two pairs of opposites.
  expect_near(object_of(scene).geometry.positions[0], {0.5f, 0, 0});
  // The limit of a vertex does not depend on how often it was split before.
  const TriangleMesh control{
      .positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
      .normals = {},
      .uvs = {},
      .triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}},
      .warnings = {}};
  expect_near(subdivide(control, 0).positions[0], subdivide(control, 4).positions[0], 1e-4f);
  // A flat square with a boundary stays flat and keeps its edges' middles.
  const Scene flat = world(
      "Shape \"loopsubdiv\" \"integer nlevels\" 2 \"integer indices\" [0 1 2 0 2 3] \"point P\" [0 0 0 1 0 0 1 1 0 0 1 0]");
  for (const vec3& p : object_of(flat).geometry.positions) EXPECT_EQ(p.z, 0);
  EXPECT_ERROR(
      world("Shape \"loopsubdiv\" \"integer indices\" [0 1 2 0 1 3 0 1 4] \"point P\" [0 0 0 1 0 0 0 1 0 0 0 1 1 1 1]"),
      "s.pbrt:3:1: Shape \"loopsubdiv\": the edge between the vertices 0 and 1 has more than two faces");
}

TEST(PbrtSurfaces, CurvesPatchesAndHeightFields) {
  const std::string points = "\"point P\" [0 0 0  1 0 0  2 0 0  3 0 0] ";
  const Scene tube = world("Shape \"curve\" \"string type\" \"cylinder\" \"float width0\" 1 \"float width1\" 2 " + points);
  for_vertices(tube, [](const vec3& p, const vec3& n) {
    EXPECT_NEAR(glm::length(vec2(p.y, p.z)), 0.5f + p.x / 6, 1e-4f);
    EXPECT_NEAR(n.x, 0, 1e-4f);
  });
  const Scene strip =
      world("Shape \"curve\" \"string type\" \"ribbon\" \"normal N\" [0 0 1 0 0 1] \"float width\" .5 " + points);
  for_vertices(strip, [](const vec3& p, const vec3& n) {
    EXPECT_NEAR(std::abs(p.y), 0.25f, 1e-4f);
    expect_near(n, {0, 0, 1}, 1e-4f);
  });
  EXPECT_ERROR(world("Shape \"curve\" " + points), "curve\" of type flat");
  EXPECT_ERROR(world("Shape \"curve\" \"point P\" [0 0 0 1 1 1]"), "has 2 points; expected a multiple of 3 and one");
  EXPECT_EQ(object_of(world("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]")).geometry.triangles.size(), 2u);
  EXPECT_EQ(object_of(world("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1]")).geometry.triangles.size(), 512u);
  EXPECT_EQ(object_of(world("Shape \"heightfield\" \"integer nu\" 3 \"integer nv\" 2 \"float Pz\" [0 0 1 1 0 0]"))
                .geometry.triangles.size(),
            4u);
}

TEST(PbrtSurfaces, FlatPatchesAreBilinearInWhatTheyShow) {
  const auto triangles = [](const std::string& points, const std::string& more, bool textured = false) {
    const std::string checks =
        "Texture \"t\" \"spectrum\" \"checkerboard\" Material \"diffuse\" \"texture reflectance\" \"t\" ";
    return object_of(world((textured ? checks : "") + "Shape \"bilinearmesh\" \"point3 P\" [" + points + "] " + more))
        .geometry.triangles.size();
  };
  const std::string square = "0 0 0 1 0 0 0 1 0 1 1 0", trapezoid = "0 0 0 3 0 0 1 1 0 2 1 0";
  EXPECT_EQ(triangles(square, "", true), 2u);
  EXPECT_EQ(triangles(square, "\"point2 uv\" [0 0 2 0 0 3 2 3]", true), 2u);
  EXPECT_EQ(triangles(square, "\"normal N\" [0 0 1 1 0 1 0 0 1 1 0 1]"), 2u);
  EXPECT_EQ(triangles(trapezoid, "\"normal N\" [0 0 1 0 0 1 0 0 1 0 0 1]"), 2u);
  EXPECT_EQ(triangles(trapezoid, ""), 2u) << "nothing depends on (u, v)";
  EXPECT_EQ(triangles(trapezoid, "", true), 512u);
  EXPECT_EQ(triangles(square, "\"point2 uv\" [0 0 2 0 0 3 2 2]", true), 512u);
  EXPECT_EQ(triangles(square, "\"normal N\" [1 0 1 0 0 1 0 0 1 1 0 1]"), 512u);
}

TEST(PbrtSurfaces, MeshFilesMayBeObjOrSmf) {
  const TestDirectory directory;
  directory.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  directory.write("m.smf", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  for (const char* shape : {"\"plymesh\" \"string filename\" \"m.obj\"", "\"objmesh\" \"string filename\" \"m.smf\""}) {
    const Scene scene = parse_pbrt("WorldBegin Shape " + std::string(shape), directory.path("s.pbrt"));
    EXPECT_EQ(object_of(scene).geometry.triangles.size(), 1u);
  }
}

TEST(PbrtTextureFields, NoiseVanishesOnTheLatticeAndRepeats) {
  EXPECT_EQ(perlin_noise({3, -4, 5}), 0);
  EXPECT_NEAR(perlin_noise({0.3f, 0.4f, 0.5f}), perlin_noise({256.3f, 0.4f, 0.5f}), 1e-4f);
  EXPECT_NE(perlin_noise({0.3f, 0.4f, 0.5f}), 0);
  EXPECT_EQ(perlin_noise({1e30f, 0, 0}), 0);
}

// The colour that the scene's one textured shape reflects at (u, v).
Rgb reflectance_at(const Scene& scene, const vec2& uv) {
  const Diffuse& diffuse = std::get<Diffuse>(scene.materials.at(object_of(scene).shapes.at(0).material));
  return evaluate(diffuse.reflectance, scene.textures, uv);
}

const std::string plane =
    "Shape \"trianglemesh\" \"point P\" [0 0 0 2 0 0 2 2 0 0 2 0] \"integer indices\" [0 1 2 0 2 3] "
    "\"float uv\" [0 0 2 0 2 2 0 2]\n";

TEST(PbrtTextureFields, WhatDependsOnUvIsBakedOverTheShapesRange) {
  const std::string use = " Material \"matte\" \"texture Kd\" \"t\" ";
  const Scene bilinear = world(
      "Texture \"t\" \"color\" \"bilerp\" \"rgb v00\" [0 0 0] \"rgb v10\" [1 0 0] \"rgb v01\" [0 1 0] "
      "\"rgb v11\" [1 1 0] \"float uscale\" .5 \"float vscale\" .5" +
      use + plane);
  for (const vec2& uv : {vec2(0, 0), vec2(0.5f, 1.25f), vec2(1.9f, 0.1f), vec2(2, 2)})
    expect_near(reflectance_at(bilinear, uv), {0.5f * uv, 0}, 1e-3f);
  const Scene product = world(
      "Texture \"a\" \"color\" \"checkerboard\" Texture \"t\" \"color\" \"scale\" \"texture tex1\" \"a\" \"texture "
      "tex2\" \"a\"" +
      use + plane);
  expect_near(reflectance_at(product, {0.5f, 0.5f}), Rgb(1));
  expect_near(reflectance_at(product, {1.5f, 0.5f}), Rgb(0));
  const Scene dots = world("Texture \"t\" \"color\" \"dots\" \"float uscale\" 8 \"float vscale\" 8" + use + plane);
  int inside = 0;
  for (int i = 0; i < 1000; ++i) inside += reflectance_at(dots, vec2(i % 40, i / 40) / 20.0f).x > 0.5f;
  EXPECT_GT(inside, 50);
  EXPECT_LT(inside, 400);
  EXPECT_EQ(world("Texture \"t\" \"color\" \"uv\"" + use + plane + plane).textures.size(), 1u) << "baked once";
  std::string nested = "Texture \"t0\" \"color\" \"uv\"\n";
  for (int i = 1; i < 9; ++i)
    nested += "Texture \"t" + std::to_string(i) + "\" \"color\" \"mix\" \"texture tex1\" \"t" + std::to_string(i - 1) +
              "\" \"texture tex2\" \"t" + std::to_string(i - 1) + "\"\n";
  EXPECT_ERROR(world(nested), "is composed of more than 64 textures");
  const std::string halved = "Texture \"t\" \"color\" \"scale\" \"texture tex\" \"t\" \"rgb scale\" [.5 .5 .5]\n";
  const std::string number = "Texture \"t\" \"float\" \"constant\" \"float value\" .25\n",
                    by_number = "Texture \"t\" \"color\" \"scale\" \"texture tex\" \"t\" \"texture scale\" \"t\"\n";
  std::string scaled = "Texture \"t\" \"color\" \"uv\"\n";
  expect_near(reflectance_at(world(scaled + number + by_number + use + plane), {0.5f, 1.75f}), {0.125f, 0.1875f, 0}, 1e-2f);
  expect_near(reflectance_at(world(scaled + halved + use + plane), {0.5f, 1.75f}), {0.25f, 0.375f, 0}, 1e-2f);
  for (int i = 0; i < 64; ++i) scaled += halved;
  EXPECT_ERROR(world(scaled), "is composed of more than 64 textures") << "by constants too, for every one nests calls deeper";
}

TEST(PbrtTextureFields, WhatDependsOnThePlaceIsBakedIntoAnAtlas) {
  const std::string planar =
      "Texture \"t\" \"color\" \"bilerp\" \"rgb v00\" [0 0 0] \"rgb v10\" [1 0 0] \"rgb v01\" [0 1 0] \"rgb "
      "v11\" [1 1 0] \"string mapping\" \"planar\" \"vector v1\" [.5 0 0] \"vector v2\" [0 .5 0] ";
  const Scene scene = world(planar + "Material \"matte\" \"texture Kd\" \"t\" " + plane);
  const Object& object = object_of(scene);
  ASSERT_EQ(object.geometry.positions.size(), 6u) << "vertices are not shared";
  for (const uvec3& t : object.geometry.triangles)
    for (const vec3& w : {vec3(1, 0, 0), vec3(0, 0, 1), vec3(0.2f, 0.3f, 0.5f)}) {
      vec2 uv(0);
      vec3 p(0);
      for (int i = 0; i < 3; ++i) uv += w[i] * object.uvs[t[i]], p += w[i] * object.geometry.positions[t[i]];
      expect_near(reflectance_at(scene, uv), 0.5f * p, 2e-3f);
    }
  const std::string spherical =
      "Texture \"t\" \"color\" \"checkerboard\" \"string mapping\" \"spherical\" Material \"matte\" \"texture Kd\" \"t\" Shape "
      "\"sphere\"";
  EXPECT_TRUE(object_of(world(spherical)).geometry.quadrics.empty()) << "a mesh, for its texture's sake";
  const auto colour = [](const std::string& film, const std::string& checks, const std::string& corners) {
    const Scene scene =
        parse_pbrt(film + " WorldBegin " + checks +
                       " Material \"matte\" \"texture Kd\" \"t\" Shape \"trianglemesh\" \"point3 P\" [" + corners + "]",
                   "s.pbrt");
    return reflectance_at(scene, scene.objects[0].uvs.at(0)).x;
  };
  const std::string version3 = "Film \"image\"", checks = "Texture \"t\" \"spectrum\" \"checkerboard\" ";
  const std::string round = checks + "\"string mapping\" \"cylindrical\"", high = "2 2 1.5  2 2.1 1.5  2.1 2 1.5";
  EXPECT_NEAR(colour("", round, high), 0, 1e-3f) << "version 4 takes z as it is, 1.5";
  EXPECT_NEAR(colour(version3, round, high), 1, 1e-3f) << "version 3 that of the direction, 0.5";
  const std::string solid3d = "Scale 2 2 2 " + checks + "\"integer dimension\" 3 Identity",
                    near = ".7 .2 .2  .8 .2 .2  .7 .3 .2";
  EXPECT_NEAR(colour("", solid3d, near), 1, 1e-3f) << "x is 0.35 in the texture's space";
  EXPECT_NEAR(colour(version3, solid3d, near), 0, 1e-3f) << "version 3 takes it as 1.4";
  for (const char* solid :
       {"fbm", "wrinkled", "windy", "marble", "checkerboard\" \"integer dimension\" 3 \"string aamode\" \"none"})
    EXPECT_EQ(world("Texture \"t\" \"color\" \"" + std::string(solid) + "\" Material \"matte\" \"texture Kd\" \"t\" " + plane)
                  .textures.size(),
              1u);
  EXPECT_ERROR(world(planar + "Material \"matte\" \"texture Kd\" \"t\" ObjectBegin \"o\" " + plane + "ObjectEnd"),
               "a texture that depends on the place");
}

// Checks of 1 m on a square of 2 km, and 2000 of them over (u, v): each texel is the mean of 4 x 4 points in four checks or so.
TEST(PbrtTextureFields, WhatIsFinerThanTexelsBecomesItsMean) {
  const std::string finer = "a texture is finer than the texels that it is baked into, which are ";
  const std::string square =
      "Shape \"trianglemesh\" \"point3 P\" [-1000 -1000 .5 1000 -1000 .5 1000 1000 .5 -1000 1000 .5] \"integer indices\" "
      "[0 1 2 0 2 3] \"float uv\" [0 0 1 0 1 1 0 1]\n";
  const std::string use = " Material \"matte\" \"texture Kd\" \"t\"\n";
  const Scene solid = world("Texture \"t\" \"color\" \"checkerboard\" \"integer dimension\" 3" + use + square + square);
  const Object& object = object_of(solid);
  for (int i = 1; i < 40; ++i) {
    const uvec3 t = object.geometry.triangles[0];
    const float x = 0.01f * static_cast<float>(i);
    const vec2 uv = (1 - 2 * x) * object.uvs[t.x] + 0.7f * x * object.uvs[t.y] + 1.3f * x * object.uvs[t.z];
    EXPECT_NEAR(reflectance_at(solid, uv).x, 0.5f, 0.25f) << "of " << i;
  }
  // The longest leg, from one corner to the opposite one, has 1020 texels.
  EXPECT_TRUE(warns(solid, "s.pbrt:4:1: Shape \"trianglemesh\": " + finer + "2.77 m apart")) << solid.warnings.back();
  EXPECT_TRUE(warns(solid, "(and in 1 more places)"));
  const std::string product = "Texture \"t\" \"color\" \"scale\" \"texture tex1\" \"a\" \"texture tex2\" \"a\"" + use + square;
  const auto checks = [](int scale) {
    return fmt::format("Texture \"a\" \"color\" \"checkerboard\" \"float uscale\" {0} \"float vscale\" {0} ", scale);
  };
  const Scene over_uv = world(checks(2000) + product);
  for (int i = 1; i < 40; ++i)
    EXPECT_NEAR(reflectance_at(over_uv, {0.02f * static_cast<float>(i), 0.63f}).x, 0.5f, 0.25f) << "of " << i;
  EXPECT_TRUE(warns(over_uv, finer + "0.000978 in (u, v) apart")) << over_uv.warnings.back();
  const Scene coarse = world(checks(8) + product);
  EXPECT_FALSE(warns(coarse, finer));
  expect_near(reflectance_at(coarse, {0.19f, 0.06f}), Rgb(0));
}

TEST(PbrtTextureFields, WhatIsBelowZeroIsToldOf) {
  const std::string negative =
      "Texture \"b\" \"spectrum\" \"bilerp\" Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"b\" \"float scale\" -1 ";
  const Scene black = world(negative + "Material \"diffuse\" \"texture reflectance\" \"t\" " + plane);
  expect_near(reflectance_at(black, {0.3f, 0.4f}), Rgb(0));
  EXPECT_TRUE(warns(black, "texture 't' reaches below 0, less than a surface can reflect: clamped to 0"));
}

TEST(PbrtTextureFields, AlphaIsAMaskOverUv) {
  const std::string half = "Texture \"h\" \"float\" \"checkerboard\" \"float tex1\" 1 \"float tex2\" 0.25 ";
  const std::string holed = plane.substr(0, plane.size() - 1) + " \"texture alpha\" \"h\" ";
  const Hit hit{.t = 1, .uv = {0.3f, 0.1f}, .instance = 0, .primitive = 0};
  const Scene scene = world(half + holed + holed);
  EXPECT_EQ(scene.textures.size(), 1u) << "once for two shapes";
  EXPECT_EQ(scene.objects[0].geometry.triangles.size(), 4u) << "nothing is cut";
  const CheckerTexture& mask = std::get<CheckerTexture>(scene.textures[0]);
  EXPECT_EQ(mask.odd, Rgb(0.25f));
  EXPECT_EQ(std::get<CheckerTexture>(parse_pbrt("Film \"image\" WorldBegin " + half + holed, "s.pbrt").textures[0]).odd,
            Rgb(1));
  EXPECT_FLOAT_EQ(world("Shape \"sphere\" \"float alpha\" 0.75").opacity_at(hit), 0.75f);
  EXPECT_FLOAT_EQ(world("Texture \"c\" \"float\" \"constant\" \"float value\" 0.75 Shape \"sphere\" \"texture alpha\" \"c\"")
                      .opacity_at(hit),
                  0.75f);
  EXPECT_TRUE(world("Shape \"sphere\" \"float alpha\" 0").objects[0].shapes.empty());
  const Scene version3 = parse_pbrt("Film \"image\" WorldBegin Shape \"sphere\" \"float alpha\" 0", "s.pbrt");
  EXPECT_EQ(version3.objects[0].shapes.size(), 1u);
  EXPECT_TRUE(warns(version3, "'alpha' has no effect, as in pbrt-v3, which knows it of trianglemesh and plymesh alone"));
  EXPECT_FALSE(world("Shape \"sphere\" \"float alpha\" 1").has_masks());
  // A texture that is composed of others is baked over the shape's (u, v).
  const Scene composed = world(half + "Texture \"m\" \"float\" \"mix\" \"texture tex1\" \"h\" \"float tex2\" 0 " +
                               plane.substr(0, plane.size() - 1) + " \"texture alpha\" \"m\" ");
  EXPECT_TRUE(std::holds_alternative<ImageTexture>(composed.textures.at(0)));
}

// Rays cannot be asked there.
TEST(PbrtTextureFields, OpacityOfLightsAndByThePlaceCutsHoles) {
  const std::string half = "Texture \"h\" \"float\" \"checkerboard\" \"float tex1\" 1 \"float tex2\" 0 ";
  const std::string holed = "AreaLightSource \"diffuse\" " + plane.substr(0, plane.size() - 1) + " \"texture alpha\" \"h\"";
  EXPECT_ERROR(world(half + holed), "an opacity that varies, on a light");
  const Scene scene = approximated(half + holed);
  const Geometry& g = object_of(scene).geometry;
  double area = 0;
  for (const uvec3& t : g.triangles)
    area += 0.5 * glm::length(glm::cross(g.positions[t.y] - g.positions[t.x], g.positions[t.z] - g.positions[t.x]));
  EXPECT_NEAR(area, 2, 0.05) << "half of a square of side 2";
  EXPECT_FALSE(scene.has_masks());
}

TEST(PbrtTextureFields, LightsOfNoOpacityShine) {
  const std::string softbox = "AreaLightSource \"diffuse\" " + plane.substr(0, plane.size() - 1) + " \"float alpha\" 0";
  for (const std::string film : {"", "Film \"image\" "}) {
    const std::string text = film + "WorldBegin " + softbox;
    EXPECT_ERROR(parse_pbrt(text, "s.pbrt"), "a light that is half transparent, or shines and is not seen");
    const Scene scene = parse_pbrt(text, "s.pbrt", {.approximate = true});
    ASSERT_EQ(scene.objects[0].shapes.size(), 1u);
    EXPECT_FALSE(scene.has_masks());
  }
}

TEST(PbrtImages, PortableFloatMapsAreRead) {
  const TestDirectory directory;
  const float texels[6] = {0.25f, 0.5f, 0.75f, 1, 0, 0.125f};  // of the lower row, then of the upper
  const std::string bytes(reinterpret_cast<const char*>(texels), sizeof texels);
  directory.write("a.pfm", "PF\n1 2\n-1.0\n" + bytes);
  const auto read = [&](const std::string& name) {
    return parse_pbrt("WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"" + name +
                          "\" Material \"diffuse\" \"texture reflectance\" \"t\" " + triangle,
                      directory.path("s.pbrt"));
  };
  const ImageTexture image = std::get<ImageTexture>(read("a.pfm").textures.at(0));
  EXPECT_EQ(image.size, ivec2(1, 2));
  EXPECT_EQ(image.texels.at(0), Rgb(1, 0, 0.125f)) << "row 0 is the upper";
  EXPECT_EQ(image.texels.at(1), Rgb(0.25f, 0.5f, 0.75f));
  directory.write("grey.pfm", "Pf\n2 3\n-1.0\n" + bytes);
  EXPECT_EQ(std::get<ImageTexture>(read("grey.pfm").textures.at(0)).texels.at(4), Rgb(0.25f));
  directory.write("half.pfm", "PF\n1 2\n-0.5\n" + bytes);
  EXPECT_EQ(std::get<ImageTexture>(read("half.pfm").textures.at(0)).texels.at(0), Rgb(0.5f, 0, 0.0625f));
  directory.write("short.pfm", "PF\n2 2\n-1.0\n" + bytes);
  EXPECT_ERROR(read("short.pfm"), "announces 2 x 2 pixels");
  directory.write("bad.pfm", "PF\nx\n");
  EXPECT_ERROR(read("bad.pfm"), "must hold width, height and scale");
}

}  // namespace
}  // namespace etendue
