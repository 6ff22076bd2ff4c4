// Mitsuba scenes: what a file of Mitsuba 0.x means where later versions mean something else, and the versions that are read.
#include "framework/io/load_scene.h"
#include "tests/unit/io_mitsuba_helpers.h"

#include <fmt/format.h>

namespace etendue::mitsuba_test {
namespace {

TEST(MitsubaVersions, FilesBefore04AreRefused) {
  for (const char* version : {"0.3.0", "0.2", "0"})
    EXPECT_ERROR(read(rectangle, version), fmt::format("s.xml:1:17: scene: version '{}'; expected 0.4 to 3; files of Mitsuba "
                                                       "before 0.4 are not read: its upgrade to 0.4 mirrors cameras",
                                                       version));
  for (const char* version : {"0.4.0", "0.4", "0.6.0", "2", "3.0.0"})
    EXPECT_EQ(read(rectangle, version).objects[0].shapes.size(), 1u) << version;
  for (const char* old : {"<camera type=\"perspective\"/>", "<shape type=\"sphere\"><luminaire type=\"area\"/></shape>"})
    EXPECT_ERROR(parse_mitsuba("<scene>" + std::string(old) + "</scene>", "s.xml"), "the file states no version, and files of");
}

TEST(MitsubaVersions, WithoutAnIntegratorLightIsDirectBeforeVersion2) {
  const Scene old = read(rectangle, "0.6.0");
  EXPECT_EQ(old.max_depth, 1);
  EXPECT_TRUE(warns(old, "the scene has no integrator: direct light alone"));
  EXPECT_EQ(read("<integrator type=\"path\"/>" + rectangle, "0.6.0").max_depth, std::nullopt);
  for (const char* version : {"2.0.0", "3.0.0"}) {
    EXPECT_EQ(read(rectangle, version).max_depth, std::nullopt) << version;
    EXPECT_FALSE(warns(read(rectangle, version), "integrator")) << version;
  }
}

TEST(MitsubaVersions, TheLastSensorIsTheCameraBeforeVersion2) {
  const auto sensor = [](const std::string& width, const std::string& type = "perspective") {
    return "<sensor type=\"" + type + "\"><film type=\"hdrfilm\"><integer name=\"width\" value=\"" + width +
           "\"/></film></sensor>";
  };
  const std::string both = sensor("100") + sensor("200");
  for (const auto& [version, width] : {std::pair("0.6.0", 200), std::pair("2.0.0", 100), std::pair("3.0.0", 100)}) {
    const Scene scene = read(both, version);
    EXPECT_EQ(scene.resolution.x, width) << version;
    ASSERT_EQ(scene.cameras.size(), 2u) << version;
    EXPECT_EQ(scene.cameras[0].resolution.x, 100) << version;
  }
  const std::string last_fails = sensor("100") + sensor("200", "spherical");
  EXPECT_ERROR(read(last_fails, "0.6.0"), "sensor \"spherical\" is not supported");
  EXPECT_TRUE(warns(read(last_fails, "3.0.0"), "another sensor, which cannot be used"));
}

// A box of 2 m x 4 m x 6 m with its middle at (1, 2, 3).
TEST(MitsubaVersions, WithoutASensorItIsMitsubasOwn) {
  const std::string box =
      "<shape type=\"cube\"><transform name=\"to_world\"><scale x=\"1\" y=\"2\" z=\"3\"/><translate x=\"1\" y=\"2\" z=\"3\"/>"
      "</transform></shape>";
  const float tan_half = std::tan(pi / 8);
  for (const auto& [version, widest] : {std::pair("0.6.0", 4.0f), std::pair("2.0.0", 6.0f), std::pair("3.0.0", 6.0f)}) {
    const Scene scene = read(box, version);
    EXPECT_TRUE(warns(scene, "the scene has no sensor: Mitsuba's own")) << version;
    EXPECT_EQ(scene.resolution, ivec2(768, 576));
    const Ray middle = scene.camera.ray(scene.resolution, {384, 288}, vec2(0));
    expect_near(middle.origin + scene.origin, {1, 2, -widest / (2 * tan_half)});
    expect_near(middle.direction, {0, 0, 1});
    const vec3 right = scene.camera.ray(scene.resolution, {768, 288}, vec2(0)).direction;
    EXPECT_NEAR(-right.x / right.z, tan_half, 1e-5) << "45 degrees across the width, +x to the left";
  }
  const Scene empty = read("<emitter type=\"constant\"/>");
  expect_near(empty.camera.ray(empty.resolution, {384, 288}, vec2(0)).origin + empty.origin, vec3(0));
}

TEST(MitsubaVersions, ChecksOfOpacityChangePlacesFromVersion2On) {
  const std::string checks = R"(<shape type="rectangle"><bsdf type="mask"><bsdf type="diffuse"/>
    <texture name="opacity" type="checkerboard"><rgb name="color0" value="1"/><rgb name="color1" value="0"/></texture>
    </bsdf></shape>)";
  for (const auto& [version, first] : {std::pair("0.6.0", 1.0f), std::pair("2.0.0", 0.0f), std::pair("3.0.0", 0.0f)}) {
    const Scene scene = read(checks, version);
    const Texture& mask = scene.textures.at(scene.objects[0].shapes.at(0).mask);
    const auto opacity = [&](float u) { return evaluate(mask, {u, 0.25f}).x; };
    EXPECT_EQ(opacity(0.25f), first) << version;
    EXPECT_EQ(opacity(0.75f), 1 - first) << version;
  }
}

TEST(MitsubaVersions, UvscaleIsTheDefaultOfBothScales) {
  const auto scale = [](const std::string& more) {
    const Scene scene = read(
        "<shape type=\"rectangle\"><bsdf type=\"diffuse\"><texture name=\"reflectance\" type=\"checkerboard\">"
        "<float name=\"uvscale\" value=\"4\"/>" +
            more + "</texture></bsdf></shape>",
        "0.6.0");
    return 0.5f * std::get<CheckerTexture>(scene.textures.at(0)).uv_scale;  // checks are half a unit wide
  };
  EXPECT_EQ(scale(""), vec2(4));
  EXPECT_EQ(scale("<float name=\"uscale\" value=\"1\"/>"), vec2(1, 4));
  EXPECT_EQ(scale("<float name=\"uscale\" value=\"1\"/><float name=\"vscale\" value=\"2\"/>"), vec2(1, 2));
}

TEST(MitsubaVersions, EllipticCylindersAreToldOfFromVersion2On) {
  const auto told = [](const std::string& transform, const std::string& version) {
    return warns(read("<shape type=\"cylinder\"><transform name=\"to_world\">" + transform + "</transform></shape>", version),
                 "it stays round");
  };
  const std::string uneven = "<scale x=\"1\" y=\"2\" z=\"1\"/>";
  EXPECT_FALSE(told(uneven, "0.6.0"));
  EXPECT_TRUE(told(uneven, "2.0.0"));
  EXPECT_TRUE(told(uneven, "3.0.0"));
  EXPECT_TRUE(told("<rotate y=\"1\" angle=\"45\"/><scale x=\"1\" y=\"1\" z=\"2\"/>", "3.0.0")) << "slanted";
  EXPECT_FALSE(told("<scale x=\"2\" y=\"2\" z=\"5\"/><rotate y=\"1\" angle=\"45\"/>", "3.0.0")) << "longer alone";
}

TEST(MitsubaVersions, UnknownValuesHaveNoEffectBeforeVersion2) {
  const std::string metal = "<shape type=\"rectangle\"><bsdf type=\"roughconductor\">", end = "</bsdf></shape>";
  const std::string unknown = metal + "<rgb name=\"diffuseReflectance\" value=\"0.3\"/>" + end;
  EXPECT_TRUE(warns(read(unknown, "0.6.0"),
                    "s.xml:2:53: bsdf \"roughconductor\": 'diffuseReflectance' has no effect, as in Mitsuba 0.x"));
  for (const char* version : {"2.0.0", "3.0.0"}) EXPECT_ERROR(read(unknown, version), "unknown property 'diffuseReflectance'");
  EXPECT_ERROR(read(metal + "<float name=\"alpa\" value=\"0.3\"/>" + end, "0.6.0"),
               "unknown property 'alpa'; did you mean 'alpha'");
  EXPECT_ERROR(read(metal + "<texture name=\"bump\" type=\"checkerboard\"/>" + end, "0.6.0"), "unknown property 'bump'")
      << "objects that have no place are an error in all versions";
  EXPECT_ERROR(read("<shape type=\"rectangle\"><film type=\"hdrfilm\"/></shape>", "0.6.0"), "a film has no place in it");
}

TEST(MitsubaVersions, ScalesOfLightsAndBumpsAreOfLaterVersions) {
  const std::string scale = "<float name=\"scale\" value=\"5\"/>";
  const std::string told = "'scale' has no effect, as in Mitsuba 0.x";
  const std::string lamp = "<shape type=\"rectangle\"><emitter type=\"area\">" + scale + "</emitter></shape>";
  EXPECT_EQ(std::get<AreaLight>(read(lamp, "0.6.0").lights.at(0)).radiance, Rgb(1));
  EXPECT_TRUE(warns(read(lamp, "0.6.0"), told));
  EXPECT_EQ(std::get<AreaLight>(read(lamp).lights.at(0)).radiance, Rgb(5));
  for (const char* type : {"point", "spot", "directional", "constant"})
    EXPECT_TRUE(warns(read(rectangle + "<emitter type=\"" + type + "\">" + scale + "</emitter>", "0.6.0"), told)) << type;
  EXPECT_EQ(std::get<PointLight>(read("<emitter type=\"point\">" + scale + "</emitter>", "0.6.0").lights.at(0)).intensity,
            Rgb(1));
  const std::string bump = "<shape type=\"rectangle\"><bsdf type=\"bumpmap\">" + scale +
                           "<texture type=\"checkerboard\"/><bsdf type=\"diffuse\"/></bsdf></shape>";
  EXPECT_EQ(read(bump, "0.6.0").reliefs.at(0).scale, 1);
  EXPECT_TRUE(warns(read(bump, "0.6.0"), told));
  EXPECT_EQ(read(bump).reliefs.at(0).scale, 5);
}

TEST(MitsubaVersions, NamesMayBeGivenTwiceBeforeVersion2) {
  const std::string labels =
      "<shape type=\"sphere\" name=\"a\"/><shape type=\"sphere\" name=\"a\"><bsdf type=\"diffuse\" name=\"m\"/>"
      "<emitter type=\"area\" name=\"m\"/></shape>";
  const Scene scene = read(labels, "0.6.0");
  EXPECT_EQ(scene.objects[0].shapes.size(), 2u);
  EXPECT_EQ(scene.lights.size(), 1u);
  EXPECT_FALSE(warns(scene, "given twice"));
  EXPECT_ERROR(read(labels), "given twice");
  const std::string radii =
      "<shape type=\"sphere\"><float name=\"radius\" value=\"1\"/><float name=\"radius\" value=\"2\"/></shape>";
  const Scene last = read(radii, "0.6.0");
  EXPECT_EQ(std::get<Sphere>(last.objects[0].geometry.quadrics.at(0)).radius, 2);
  EXPECT_TRUE(warns(last, "shape \"sphere\": 'radius' is given twice"));
  EXPECT_ERROR(read(radii), "given twice");
  const std::string texture = "<texture name=\"reflectance\" type=\"checkerboard\"/>",
                    colour = "<rgb name=\"reflectance\" value=\"0.1\"/>";
  for (const std::string& both : {texture + colour, colour + texture})
    EXPECT_FALSE(material_of<Diffuse>("<bsdf type=\"diffuse\">" + both + "</bsdf>", "0.6.0").reflectance.is_constant());
}

TEST(MitsubaVersions, TypesMayBeInCapitalsBeforeVersion2) {
  EXPECT_EQ(read("<shape type=\"Rectangle\"><bsdf type=\"Diffuse\"/></shape>", "0.6.0").objects[0].shapes.size(), 1u);
  EXPECT_ERROR(read("<shape type=\"Rectangle\"/>"), "unknown shape 'Rectangle'; did you mean 'rectangle'");
  const std::string flipped = "<shape type=\"rectangle\"><boolean name=\"flip_normals\" value=\"TRUE\"/></shape>";
  EXPECT_TRUE(read(flipped).objects[0].shapes.at(0).flip_normal);
  const std::string none = "<bsdf type=\"conductor\"><string name=\"material\" value=\"None\"/></bsdf>";
  for (const char* version : {"0.6.0", "3.0.0"}) EXPECT_TRUE(material_of<Conductor>(none, version).ideal) << version;
}

// Three parts of 1, 2 and 3 triangles. Mitsuba gives a part its number where the next one begins.
TEST(MitsubaVersions, OnePartOfAnObjMayBeTakenBeforeVersion2) {
  const TestDirectory directory;
  const std::string parts =
      "v 3 0 0\nv 2 2 0\nv 0 3 0\nv -2 2 0\nv -3 0 0\nv -2 -2 0\nv 0 -3 0\nv 2 -2 0\n"
      "f 1 2 3\ng second\nf 1 3 4\nf 1 4 5\ng third\nf 1 5 6\nf 1 6 7\nf 1 7 8\n";
  const auto read_part = [&](const std::string& obj, const std::string& index, const std::string& version = "0.6.0") {
    directory.write("m.obj", obj);
    return parse_mitsuba(
        scene_text("<shape type=\"obj\"><string name=\"filename\" value=\"m.obj\"/><integer name=\"shapeIndex\" "
                   "value=\"" +
                       index + "\"/></shape>",
                   version),
        directory.path("s.xml"));
  };
  const auto triangles = [&](const std::string& obj, const std::string& index) {
    return read_part(obj, index).objects[0].geometry.triangles.size();
  };
  EXPECT_EQ(triangles(parts, "-1"), 6u);
  EXPECT_EQ(triangles(parts, "0"), 1u);
  EXPECT_EQ(triangles(parts, "1"), 5u) << "the last part comes with the one before it";
  EXPECT_TRUE(warns(read_part(parts, "1"), "as in Mitsuba the last part comes with this one"));
  EXPECT_ERROR(read_part(parts, "2"), "'shape_index' is 2; 'm.obj' has 2 parts");
  EXPECT_EQ(triangles(parts + "g end\n", "1"), 2u);
  EXPECT_EQ(triangles(parts + "g end\n", "2"), 3u);
  EXPECT_ERROR(read_part(parts, "0", "3.0.0"), "unknown property 'shapeIndex'");
}

}  // namespace
}  // namespace etendue::mitsuba_test
