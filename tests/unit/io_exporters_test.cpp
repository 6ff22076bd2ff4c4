// Scenes as exporting programs write them and the formats' documents show them, beside the everyday: each loads, or says why
// not.
#include "framework/io/image/exr.h"
#include "framework/io/image/image_file.h"
#include "framework/io/load_scene.h"
#include "framework/materials/texture.h"
#include "tests/unit/io_helpers.h"
#include "tests/unit/io_mitsuba_helpers.h"
#include "tests/unit/io_pbrt_helpers.h"

namespace etendue {
namespace {

namespace mts = mitsuba_test;

const std::string mark = "Shape \"sphere\"";
// Those fourteen bytes.
const std::string mark_gz(
    "\x1f\x8b\x08\x00\x00\x00\x00\x00\x02\x03\x0b\xce\x48\x2c\x48\x55\x50\x2a\x2e\xc8\x48\x2d\x4a\x55\x02\x00\x68\x5a\x1f\x74"
    "\x0e\x00\x00\x00",
    34);

std::string png_of(std::vector<std::uint8_t> rgb, ivec2 size) {
  const auto png = encode_png(rgb.data(), size);
  return {png.begin(), png.end()};
}

TEST(ExportedScenes, MayBeCompressedByGzip) {
  const TestDirectory directory;
  directory.write("part.pbrt.gz", mark_gz);
  const std::string scene = directory.write("s.pbrt", "WorldBegin Include \"part.pbrt.gz\" Import \"part.pbrt.gz\"");
  EXPECT_EQ(load_scene(scene).objects[0].geometry.quadrics.size(), 2u);
  directory.write("part.pbrt.gz", mark_gz + mark_gz);  // two members
  EXPECT_EQ(load_scene(scene).objects[0].geometry.quadrics.size(), 4u);
  directory.write("part.pbrt.gz", mark_gz.substr(0, 20));
  EXPECT_ERROR(load_scene(scene), "s.pbrt:1:20: '" + directory.path("part.pbrt.gz"));
  EXPECT_ERROR(load_scene(scene), "is gzip-compressed: it is cut short");
  directory.write("part.pbrt.gz", mark_gz.substr(0, 26) + "12345678");
  EXPECT_ERROR(load_scene(scene), "its data are damaged");
}

TEST(ExportedScenes, DisneysMaterialIsItsLargestLobe) {
  EXPECT_ERROR(world("Material \"disney\" \"rgb color\" [.2 .4 .6]"), "material \"disney\" is not supported");
  EXPECT_EQ(approximate_material_of<Conductor>("Material \"disney\" \"float metallic\" 1 \"float roughness\" .5").alpha,
            vec2(0.25f));
  const auto glass = approximate_material_of<Dielectric>(
      "Material \"disney\" \"float spectrans\" 1 \"float eta\" 1.4 \"rgb color\" [.25 1 1]");
  EXPECT_FLOAT_EQ(glass.eta, 1.4f);
  expect_near(glass.transmit_tint, Rgb(0.5f, 1, 1));
  EXPECT_FLOAT_EQ(approximate_material_of<Plastic>("Material \"disney\" \"float sheen\" .3 \"float clearcoat\" 1").alpha,
                  0.25f);
}

TEST(ExportedScenes, NurbsFollowTheirControlPoints) {
  // A quarter of a cylinder about z: an arc of degree 2 along u, a line along v.
  const std::string quarter = R"(Shape "nurbs" "integer nu" 3 "integer nv" 2 "integer uorder" 3 "integer vorder" 2
    "float uknots" [0 0 0 2 2 2] "float vknots" [0 0 1 1] "float Pw" [1 0 0 1  .70710678 .70710678 0 .70710678  0 1 0 1
      1 0 3 1  .70710678 .70710678 2.1213203 .70710678  0 1 3 1])";
  const Scene scene = world(quarter);
  const auto& positions = scene.objects[0].geometry.positions;
  ASSERT_EQ(positions.size(), 65u * 65u);
  Bounds bounds;
  for (const vec3& p : positions) {
    EXPECT_NEAR(glm::length(vec2(p)), 1, 1e-5);
    bounds.extend(p);
  }
  expect_near(bounds.lower, {0, 0, 0});
  expect_near(bounds.upper, {1, 1, 3});
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const vec3 n = scene.objects[0].normals.at(i);
    EXPECT_NEAR(glm::dot(n, vec3(vec2(positions[i]), 0)), 1, 1e-4) << "outwards";
  }
  EXPECT_ERROR(world(R"(Shape "nurbs" "integer nu" 3 "integer nv" 2 "integer uorder" 4 "integer vorder" 2)"),
               "'uorder' is 4; expected 2 to the number of points, 3");
  EXPECT_ERROR(world(R"(Shape "nurbs" "integer nu" 2 "integer nv" 2 "integer uorder" 2 "integer vorder" 2
    "float uknots" [0 0 1])"),
               "'uknots' has 3 numbers; expected 4, none below the one before");
}

TEST(ExportedScenes, DirectionMixesTextures) {
  const auto colour_with = [](const std::string& direction) {
    const Scene scene =
        world("Texture \"t\" \"spectrum\" \"directionmix\" \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 0 1] \"vector3 dir\" " +
              direction + " Material \"diffuse\" \"texture reflectance\" \"t\" " + triangle);
    return evaluate(scene.textures.at(0), scene.objects[0].uvs.at(0));
  };
  expect_near(colour_with("[0 0 -2]"), Rgb(1, 0, 0));  // the triangle faces z
  expect_near(colour_with("[0 3 0]"), Rgb(0, 0, 1));
  expect_near(colour_with("[0 3 4]"), Rgb(0.8f, 0, 0.2f));
}

TEST(ExportedScenes, SpectraMayHaveAnyExtension) {
  const TestDirectory directory;
  directory.write("flat.txt", "400 2\n700 2\n");
  const Scene scene = load_scene(directory.write(
      "s.pbrt", "WorldBegin Material \"conductor\" \"spectrum eta\" \"flat.txt\" \"spectrum k\" \"metal-Ag-k\" " + triangle));
  expect_near(std::get<Conductor>(scene.materials.at(0)).eta, Rgb(2), 1e-4f);
}

TEST(ExportedScenes, ImagesMayHaveTheirOwnGamma) {
  const TestDirectory directory;
  directory.write("a.png", png_of({255, 0, 188}, {1, 1}));
  const auto texels = [&](const std::string& name, const std::string& text) {
    return std::get<ImageTexture>(load_scene(directory.write(name, text)).textures.at(0)).texels.at(0);
  };
  const float blue = std::pow(188.0f / 255, 2.2f);
  expect_near(texels("s.pbrt",
                     "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\" \"string encoding\" "
                     "\"gamma 2.2\" Material \"diffuse\" \"texture reflectance\" \"t\" " +
                         triangle),
              Rgb(1, 0, blue));
  const float half = 0.5f;  // floats are decoded by version 3 where it is told to, and only there
  directory.write("half.pfm", "Pf\n1 1\n-1\n" + std::string(reinterpret_cast<const char*>(&half), sizeof half));
  const auto of_floats = [&](const std::string& before, const std::string& gamma) {
    return texels("s.pbrt", before + " WorldBegin Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"half.pfm\" " +
                                gamma + " Material \"matte\" \"texture Kd\" \"t\" " + triangle);
  };
  const std::string told = "\"bool gamma\" \"true\"";
  expect_near(of_floats("Film \"image\"", told), Rgb(0.21404f), 1e-4f);
  expect_near(of_floats("Film \"image\"", ""), Rgb(0.5f));
  expect_near(of_floats("", told), Rgb(0.5f));
  const auto mitsuba = [&](const std::string& inside) {
    return texels("s.xml", mts::scene_text(
                               "<shape type=\"rectangle\"><bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\">"
                               "<string name=\"filename\" value=\"a.png\"/>" +
                               inside + "</texture></bsdf></shape>"));
  };
  expect_near(mitsuba("<float name=\"gamma\" value=\"2.2\"/>"), Rgb(1, 0, blue));
  expect_near(mitsuba("<string name=\"channel\" value=\"b\"/><boolean name=\"raw\" value=\"true\"/>"), Rgb(188.0f / 255));
  EXPECT_ERROR(mitsuba("<string name=\"channel\" value=\"x\"/>"), "expected 'r', 'g', 'b', 'a' or none");
}

TEST(ExportedScenes, AreaLightsMayStateTheirPower) {
  const auto radiance = [](const std::string& shape, bool approximate = false) {
    const std::string light = "AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"float power\" 6 " + shape;
    const Scene scene = approximate ? approximated(light) : world(light);
    return std::get<AreaLight>(scene.lights.at(0)).radiance;
  };
  expect_near(radiance("Scale 2 2 2 Shape \"disk\""), 6 / (4 * pi * pi) * Rgb(1, 2, 3));
  // Each of pbrt's triangles is a light; a patch is one.
  expect_near(radiance(R"(Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0] "integer indices" [0 1 3 0 3 2])"),
              6 / (0.5f * pi) * Rgb(1, 2, 3), 1e-4f);
  expect_near(radiance(R"(Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 0])"), 6 / pi * Rgb(1, 2, 3), 1e-4f);
  const std::string uneven = R"(Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0 -2 0 0] "integer indices" [0 1 2 0 2 3])";
  EXPECT_ERROR(radiance(uneven), "each of its faces is a light of the same 'power'");
  expect_near(radiance(uneven, true), 12 / (1.5f * pi) * Rgb(1, 2, 3), 1e-4f);
}

TEST(ExportedScenes, MapsMayStateTheirIlluminance) {
  const TestDirectory directory;
  Image map({64, 32});
  std::fill(map.pixels.begin(), map.pixels.end(), dvec3(3));
  write_exr(directory.path("m.exr"), map);
  const Scene scene = load_scene(directory.write(
      "s.pbrt", "WorldBegin LightSource \"infinite\" \"string mapname\" \"m.exr\" \"float illuminance\" 7 " + triangle));
  const auto& light = std::get<EnvironmentLight>(scene.lights.at(0));
  // The even light of radiance L brings pi L; pbrt-v4 counts half of it.
  EXPECT_NEAR(light.scale.x * light.texels[0].x, 2 * 7 / pi, 0.02);
}

TEST(ExportedScenes, MetalsHaveOtherMeasurements) {
  const auto metal = [](const std::string& name) {
    return mts::material_of<Conductor>("<bsdf type=\"conductor\"><string name=\"material\" value=\"" + name + "\"/></bsdf>",
                                       "3.0.0", true);
  };
  EXPECT_EQ(metal("Cu_palik").eta, metal("Cu").eta);
  EXPECT_EQ(metal("SiC_palik").k, metal("SiC").k);
  EXPECT_ERROR(metal("Xy_palik"), "unknown metal 'Xy_palik'");
}

TEST(ExportedScenes, DistortedDisksEmitLightAsMeshes) {
  const Scene scene = mts::read(
      "<shape type=\"disk\"><transform name=\"to_world\"><scale x=\"3\" y=\"2\"/></transform>"
      "<emitter type=\"area\"><rgb name=\"radiance\" value=\"5\"/></emitter></shape>");
  EXPECT_EQ(scene.lights.size(), 200u);
  double area = 0;
  const Geometry& g = scene.objects[0].geometry;
  for (const uvec3& t : g.triangles) {
    const vec3 across = glm::cross(g.positions[t[1]] - g.positions[t[0]], g.positions[t[2]] - g.positions[t[0]]);
    EXPECT_GT(across.z, 0);
    area += 0.5 * across.z;
  }
  EXPECT_NEAR(area, 6 * pi, 0.01);
}

TEST(ExportedScenes, DistortedSpheresStaySpheres) {
  const std::string sphere =
      "<shape type=\"sphere\"><float name=\"radius\" value=\"0.5\"/><transform name=\"to_world\">"
      "<scale x=\"2\" y=\"3\" z=\"2\"/><translate x=\"5\"/></transform><emitter type=\"area\"/></shape>";
  for (const char* version : {"0.6.0", "3.0.0"}) {
    const Scene scene = mts::read(sphere, version);
    const Sphere& placed = std::get<Sphere>(scene.objects.at(0).geometry.quadrics.at(0));
    EXPECT_EQ(placed.radius, 1) << version;
    expect_near(placed.centre + scene.origin, {5, 0, 0});
    EXPECT_EQ(scene.lights.size(), 1u);
    EXPECT_FALSE(scene.has_instances());
    EXPECT_TRUE(warns(scene, "'to_world' distorts it: it stays a sphere"));
  }
  const std::string mirrored =
      "<shape type=\"sphere\"><transform name=\"to_world\"><scale x=\"-1\" y=\"3\"/></transform></shape>";
  EXPECT_FALSE(mts::read(mirrored, "0.6.0").objects[0].shapes.at(0).flip_normal);
  EXPECT_TRUE(mts::read(mirrored, "3.0.0").objects[0].shapes.at(0).flip_normal);
}

TEST(ExportedScenes, QuadricsWithReliefOrImagesOfLightAreMeshes) {
  const TestDirectory directory;
  directory.write("a.png", png_of({0, 0, 0, 255, 255, 255}, {1, 2}));
  const std::string image = "<texture type=\"bitmap\" name=\"radiance\"><string name=\"filename\" value=\"a.png\"/></texture>";
  const auto light_at = [&](const std::string& shape, const vec3& place) {
    const Scene scene = load_scene(directory.write(
        "s.xml", mts::scene_text("<shape type=\"" + shape + "\"><emitter type=\"area\">" + image + "</emitter></shape>")));
    const Object& object = scene.objects[0];
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < object.geometry.positions.size(); ++i)
      if (glm::length(object.geometry.positions[i] - place) < glm::length(object.geometry.positions[nearest] - place))
        nearest = i;
    EXPECT_GT(glm::dot(object.normals.at(nearest), place), 0.9f) << "outwards";
    return evaluate(scene.textures.at(0), object.uvs.at(nearest)).x;
  };
  EXPECT_LT(light_at("sphere", glm::normalize(vec3(1, 0, 1))), 0.1f) << "the image's first row is at +z";
  EXPECT_GT(light_at("sphere", glm::normalize(vec3(1, 0, -1))), 0.9f);
}

// Each of 30 merges refers ten times to the next.
TEST(ExportedScenes, ReferencesThatMultiplyEndInAnError) {
  std::string merges;
  for (int i = 0; i < 30; ++i) {
    merges += "<shape type=\"merge\" id=\"m" + std::to_string(i) + "\">";
    for (int k = 0; k < 10; ++k) merges += "<ref id=\"m" + std::to_string(i + 1) + "\"/>";
    merges += "</shape>";
  }
  EXPECT_ERROR(mts::read(merges + "<shape type=\"sphere\" id=\"m30\"/>"), "with all references followed there are more than");
}

TEST(ExportedScenes, MitsubasRarerTypesHaveAnswers) {
  const std::string named = "<shape type=\"rectangle\"/>";
  EXPECT_ERROR(mts::read("<sensor type=\"distant\"/>" + named), "sensor \"distant\" is not supported");
  EXPECT_TRUE(warns(mts::approximated("<sensor type=\"distant\"/>" + named), "sensor \"distant\""));
  const auto plain =
      mts::material_of<Plastic>("<bsdf type=\"principled\"><float name=\"specular\" value=\"0\"/></bsdf>", "3.0.0", true);
  EXPECT_NEAR(plain.coat.eta(), 1, 0.01f);
}

// Two faces with an edge in common, each with vertices of its own.
std::string bent_obj(const std::string& between) {
  return "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n" + between + "v 1 0 0\nv 1 0 1\nv 1 1 1\nv 1 1 0\nf -4 -3 -2 -1\n";
}

TEST(ExportedScenes, PartsOfObjFilesAreSmoothByThemselvesBeforeVersion2) {
  const TestDirectory directory;
  const auto normal = [&](const std::string& between, const std::string& version, const std::string& more = "") {
    directory.write("m.obj", bent_obj(between));
    const Scene scene = load_scene(directory.write(
        "s.xml",
        mts::scene_text("<shape type=\"obj\"><string name=\"filename\" value=\"m.obj\"/>" + more + "</shape>", version)));
    const Object& object = scene.objects[0];
    return object.normals.empty() ? vec3(0) : object.normals.at(1);
  };
  expect_near(normal("", "0.6.0"), glm::normalize(vec3(-1, 0, 1)));
  for (const char* between : {"g b\n", "usemtl b\n"}) {
    expect_near(normal(between, "0.6.0"), vec3(0, 0, 1));
    expect_near(normal(between, "0.6.0", "<boolean name=\"collapse\" value=\"true\"/>"), glm::normalize(vec3(-1, 0, 1)));
  }
  expect_near(normal("o b\n", "0.6.0"), glm::normalize(vec3(-1, 0, 1)));
  expect_near(normal("", "3.0.0"), vec3(0, 0, 1));
  EXPECT_EQ(normal("", "0.6.0", "<boolean name=\"faceNormals\" value=\"true\"/>"), vec3(0));
}

TEST(ExportedScenes, BsdfsHaveTheNamesOfMaterialsBeforeVersion2) {
  const TestDirectory directory;
  directory.write("m.obj", "mtllib m.mtl\nusemtl old glass\n" + bent_obj("g x\nusemtl wall\n"));
  const auto text = [](const std::string& bsdfs, const std::string& version) {
    return mts::scene_text("<shape type=\"obj\"><string name=\"filename\" value=\"m.obj\"/>" + bsdfs + "</shape>", version);
  };
  const auto materials = [&](const std::string& bsdfs) {
    const Scene scene = load_scene(directory.write("s.xml", text(bsdfs, "0.5.0")));
    std::string kinds;
    for (const Shape& shape : scene.objects[0].shapes)
      kinds += std::holds_alternative<Conductor>(scene.materials.at(shape.material))    ? "metal "
               : std::holds_alternative<Dielectric>(scene.materials.at(shape.material)) ? "glass "
                                                                                        : "diffuse ";
    return kinds;
  };
  const std::string glass = "<bsdf type=\"dielectric\" name=\"old glass\"/>", wall = "<bsdf type=\"conductor\" name=\"wall\"/>";
  EXPECT_EQ(materials(glass + wall), "glass metal ");
  EXPECT_FALSE(warns(load_scene(directory.path("s.xml")), "are not read"));
  EXPECT_EQ(materials(wall), "diffuse metal ");
  EXPECT_TRUE(warns(load_scene(directory.path("s.xml")), "'m.obj': the materials it names are not read: faces without a bsdf"));
  EXPECT_EQ(materials(wall + "<boolean name=\"loadMaterials\" value=\"false\"/>"), "diffuse metal ");
  EXPECT_FALSE(warns(load_scene(directory.path("s.xml")), "are not read"));
  EXPECT_EQ(materials("<bsdf type=\"dielectric\"/>" + wall), "glass metal ") << "the one without a name is for all";
  const std::string other = "<bsdf type=\"conductor\" name=\"bsdf\"/>";
  EXPECT_EQ(materials(other), "metal metal ");
  const Scene warned = load_scene(directory.path("s.xml"));
  EXPECT_TRUE(warns(warned, "no face of 'm.obj' is of the material 'bsdf'"));
  EXPECT_ERROR(load_scene(directory.write("s.xml", text(glass + wall, "3.0.0"))), "has 2 bsdfs; expected one");
  EXPECT_ERROR(load_scene(directory.write("s.xml", text(wall + "<emitter type=\"area\"/>", "0.5.0"))), "lets none emit light");
}

}  // namespace
}  // namespace etendue
