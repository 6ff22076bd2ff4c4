// Mitsuba scenes: cameras, files, transforms and shapes; where mistakes are told, and what hostile scenes cost.
#include "framework/io/load_scene.h"
#include "framework/io/mitsuba/xml.h"
#include "tests/unit/io_mitsuba_helpers.h"

#include <chrono>

namespace etendue::mitsuba_test {
namespace {

const std::string sensor = R"(<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="200"/>
<integer name="height" value="100"/><rfilter type="box"/></film></sensor>)";

// The direction in which the camera looks through a point of the film.
vec3 view(const Scene& scene, const vec2& film) { return scene.camera.ray(scene.resolution, film, vec2(0)).direction; }

TEST(MitsubaCamera, LooksAlongZWithXToTheLeft) {
  const Scene scene = read(sensor);
  EXPECT_EQ(scene.resolution, ivec2(200, 100));
  expect_near(view(scene, {100, 50}), {0, 0, 1});
  EXPECT_LT(view(scene, {199, 50}).x, 0) << "right of the image";
  EXPECT_GT(view(scene, {100, 1}).y, 0) << "top of the image";
}

TEST(MitsubaCamera, LookAtIsTurnedAsMitsubaTurnsIt) {
  const Scene scene = read(R"(<camera type="perspective"><transform name="toWorld">
    <lookAt origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform></camera>)",
                           "0.5.0");
  expect_near(view(scene, vec2(scene.resolution) * 0.5f), {0, 0, -1});
  EXPECT_GT(view(scene, {static_cast<float>(scene.resolution.x), 0}).x, 0) << "a right-handed picture";
}

TEST(MitsubaCamera, FieldOfViewFollowsItsAxis) {
  const auto half_width = [](const std::string& properties) {
    const Scene scene = read(sensor.substr(0, sensor.size() - 9) + properties + "</sensor>");
    const vec3 right = view(scene, {200, 50});
    return -right.x / right.z;
  };
  const std::string fov = "<float name=\"fov\" value=\"60\"/>";
  const float edge = std::tan(pi / 6);
  EXPECT_NEAR(half_width(fov), edge, 1e-5);
  EXPECT_NEAR(half_width(fov + "<string name=\"fov_axis\" value=\"Y\"/>"), 2 * edge, 1e-5);
  EXPECT_NEAR(half_width(fov + "<string name=\"fovAxis\" value=\"smaller\"/>"), 2 * edge, 1e-5);
  EXPECT_NEAR(half_width(fov + "<string name=\"fov_axis\" value=\"diagonal\"/>"), edge * 2 / std::sqrt(5.0f), 1e-5);
  EXPECT_NEAR(half_width("<string name=\"focal_length\" value=\"50mm\"/>"),
              std::sqrt(36.0f * 36 + 24 * 24) / 100 * 2 / std::sqrt(5.0f), 1e-5);
  EXPECT_ERROR(half_width(fov + "<string name=\"focal_length\" value=\"50mm\"/>"),
               "'focal_length' stands beside 'fov'; expected the one or the other");
  EXPECT_ERROR(half_width("<string name=\"fov_axis\" value=\"z\"/><float name=\"fov\" value=\"60\"/>"), "unknown axis 'z'");
}

TEST(MitsubaCamera, OrthographicViewsAreParallel) {
  const auto corner = [](const std::string& transform) {
    const Scene scene =
        read("<sensor type=\"orthographic\"><transform name=\"to_world\">" + transform + "</transform></sensor>");
    return scene.camera.ray(scene.resolution, {0, 0}, vec2(0));
  };
  const Ray ray = corner("<scale x=\"2\" y=\"2\"/>");
  expect_near(ray.origin, {2, 1.5f, 0});
  expect_near(ray.direction, {0, 0, 1});
  const Ray turned = corner("<scale value=\"3\"/><lookat origin=\"0, 0, 5\" target=\"0, 0, 0\" up=\"0, 1, 0\"/>");
  expect_near(turned.origin, {-3, 2.25f, 5});
  expect_near(turned.direction, {0, 0, -1});
  EXPECT_ERROR(corner("<scale x=\"2\" y=\"1\"/>"), "distorts the image");
  // Without an up it is Mitsuba's: here the world's x, so that the image stands on its side.
  expect_near(corner("<scale value=\"3\"/><lookat origin=\"0, 0, 5\" target=\"0, 0, 0\"/>").origin, {2.25f, 3, 5});
}

// A wall of 2 m x 2 m across the view, 1 m before the camera or beside it.
TEST(MitsubaCamera, WhatMitsubaCutsAwayIsTold) {
  const auto clips = [](const std::string& clip, const std::string& place, const std::string& wall = "rectangle",
                        const std::string& sensor = "perspective") {
    const Scene scene = read("<sensor type=\"" + sensor + "\">" + clip + "</sensor><shape type=\"" + wall +
                             "\"><transform name=\"to_world\"><translate " + place + "/></transform></shape>");
    return std::pair(warns(scene, "less than 'near_clip'"), warns(scene, "more than 'far_clip'"));
  };
  const auto near = [](const std::string& at) { return "<float name=\"near_clip\" value=\"" + at + "\"/>"; };
  const std::string far = "<float name=\"far_clip\" value=\"1.9\"/>";
  EXPECT_EQ(clips(near("0.9"), "z=\"1\""), std::pair(false, false));
  EXPECT_EQ(clips(near("1.1"), "z=\"1\""), std::pair(true, false));
  EXPECT_EQ(clips(near("1.1"), "z=\"1\" x=\"3\""), std::pair(false, false)) << "beside the view";
  EXPECT_EQ(clips(near("1.1"), "z=\"-1\""), std::pair(false, false)) << "behind the camera";
  EXPECT_EQ(clips(far, "z=\"2\""), std::pair(false, true));
  EXPECT_EQ(clips(far, "z=\"1.8\""), std::pair(false, false));
  EXPECT_EQ(clips(far, "z=\"1.001\"", "sphere"), std::pair(true, true)) << "its box, to either side";
  EXPECT_EQ(clips("", "z=\"20000\""), std::pair(false, true)) << "without 'far_clip' it is 10,000 m";
  EXPECT_EQ(clips(far, "z=\"2\"", "rectangle", "orthographic"), std::pair(false, true));
  EXPECT_EQ(clips(far, "z=\"200\" x=\"2.5\"", "rectangle", "orthographic"), std::pair(false, false)) << "beside parallel rays";
}

TEST(MitsubaCamera, OthersAreRefusedOrApproximated) {
  EXPECT_ERROR(read("<sensor type=\"spherical\"/>"), "s.xml:2:1: sensor \"spherical\" is not supported");
  EXPECT_TRUE(warns(approximated("<sensor type=\"spherical\"/>"), "spherical"));
  for (const char* property : {R"(<float name="principal_point_offset_x" value="0.1"/>)",
                               R"(<string name="kc" value="0.1, 0"/>)", R"(<string name="blades" value="5"/>)"}) {
    const std::string bent = "<sensor type=\"thinlens\">" + std::string(property) + "</sensor>";
    EXPECT_ERROR(read(bent), "supported") << property;
    EXPECT_TRUE(warns(approximated(bent), "thinlens")) << property;
  }
  const std::string hiding = "<integrator type=\"path\"><boolean name=\"hide_emitters\" value=\"true\"/></integrator>";
  const std::string lamp = "<shape type=\"rectangle\"><emitter type=\"area\"/></shape>";
  for (const std::string& seen : {std::string("<emitter type=\"constant\"/>"), lamp})
    EXPECT_ERROR(read(hiding + seen), "s.xml:2:25: integrator \"path\": 'hide_emitters' is not supported");
  EXPECT_EQ(read(hiding + rectangle + "<emitter type=\"point\"/>").lights.size(), 1u) << "which is not seen in any case";
  EXPECT_ERROR(read("<sensor type=\"perspectiv\"/>"), "s.xml:2:15: unknown sensor 'perspectiv'; did you mean 'perspective'");
}

TEST(Mitsuba, FiltersAndCropsAreTheFilms) {
  const auto film = [](const std::string& inside) {
    return read(
        "<sensor type=\"perspective\"><film type=\"hdrfilm\"><integer name=\"width\" value=\"200\"/><integer "
        "name=\"height\" value=\"100\"/>" +
        inside + "</film></sensor>");
  };
  const auto filter = [&](const std::string& text) { return film("<rfilter " + text + "</rfilter>").filter->shape(); };
  EXPECT_EQ(film("").filter->shape(), (FilterShape{.kind = FilterKind::gaussian, .radius = vec2(2), .sigma = 0.5f}));
  EXPECT_EQ(film("<rfilter type=\"box\"/>").filter, nullptr);
  EXPECT_EQ(filter("type=\"tent\">"), (FilterShape{.kind = FilterKind::triangle, .radius = vec2(1)}));
  EXPECT_EQ(filter("type=\"gaussian\"><float name=\"stddev\" value=\"0.25\"/>").radius, vec2(1));
  EXPECT_EQ(filter("type=\"catmullrom\">").c, 0.5f);
  const FilterShape mitchell = filter("type=\"mitchell\"><float name=\"B\" value=\"0.25\"/><float name=\"C\" value=\"0.5\"/>");
  EXPECT_EQ(mitchell.b, 0.25f);
  EXPECT_EQ(mitchell.c, 0.5f);
  EXPECT_EQ(filter("type=\"lanczos\">").radius, vec2(3));
  EXPECT_ERROR(film("<rfilter type=\"tend\"/>"), "unknown rfilter 'tend'; did you mean 'tent'");
  EXPECT_ERROR(filter("type=\"gaussian\"><float name=\"stdev\" value=\"1\"/>"),
               "unknown property 'stdev'; did you mean 'stddev'");
  EXPECT_ERROR(film("<integer name=\"cropWidht\" value=\"20\"/>"), "unknown property 'cropWidht'; did you mean 'crop_width'");
  for (const char* name : {"pixel_format", "file_format", "fileFormat", "component_format", "componentFormat", "compensate"})
    EXPECT_EQ(film("<string name=\"" + std::string(name) + "\" value=\"rgb\"/>").resolution, ivec2(200, 100)) << name;
  EXPECT_TRUE(warns(film("<string name=\"pixelFormat\" value=\"luminanceAlpha\"/>"), "here the image has colours"));
  const Scene cropped = film("<integer name=\"crop_offset_x\" value=\"50\"/><integer name=\"crop_width\" value=\"100\"/>");
  EXPECT_EQ(cropped.crop, (std::array<float, 4>{0.25f, 0.75f, 0, 1}));
  EXPECT_TRUE(warns(cropped, "`etendue render` shows the part in the crop window"));
  EXPECT_FALSE(film("<integer name=\"crop_width\" value=\"200\"/>").crop.has_value());
}

TEST(Mitsuba, OtherSensorsHaveNamesAndKeepNoSceneFromLoading) {
  const std::string second = "<sensor type=\"perspective\" id=\"above\"><float name=\"fov\" value=\"90\"/></sensor>";
  const Scene scene = read(sensor + second + "<sensor type=\"spherical\"/>");
  EXPECT_EQ(scene.resolution, ivec2(200, 100));
  ASSERT_EQ(scene.cameras.size(), 2u);
  EXPECT_EQ(scene.cameras[0].name, "sensor-1");
  EXPECT_EQ(scene.cameras[1].name, "above");
  EXPECT_EQ(scene.cameras[1].resolution, ivec2(768, 576));
  EXPECT_EQ(scene.camera.fov, scene.cameras[0].camera.fov);
  EXPECT_TRUE(warns(scene, "another sensor, which cannot be used"));
}

TEST(MitsubaIntegrator, DepthCountsEdges) {
  const auto depth = [](const std::string& type, const std::string& value) {
    return read("<integrator type=\"" + type + "\"><integer name=\"maxDepth\" value=\"" + value + "\"/></integrator>")
        .max_depth;
  };
  EXPECT_EQ(depth("path", "6"), 5);
  EXPECT_EQ(depth("path", "-1"), std::nullopt);
  EXPECT_EQ(read("<integrator type=\"moment\"><integrator type=\"direct\"/></integrator>").max_depth, 1);
  EXPECT_TRUE(warns(read("<integrator type=\"guided_path\"/>"), "integrator 'guided_path'"));
  EXPECT_ERROR(read("<integrator type=\"path\"><integer name=\"max_dept\" value=\"2\"/></integrator>"),
               "s.xml:2:25: integrator \"path\": unknown property 'max_dept'; did you mean 'max_depth'");
  EXPECT_EQ(read("<integrator type=\"path\"><integer name=\"rr_depth\" value=\"2\"/></integrator>").max_depth, std::nullopt);
}

TEST(MitsubaIntegrator, AnotherIsRefusedAndTheFirstCounts) {
  const std::string first = "<integrator type=\"path\"><integer name=\"max_depth\" value=\"3\"/></integrator>";
  const std::string second = "<integrator type=\"path\"/>", direct = "<integrator type=\"direct\"/>";
  EXPECT_ERROR(read(first + second), "another integrator beside the first");
  EXPECT_EQ(read("<integrator type=\"aov\">" + first + direct + "</integrator>").max_depth, 2) << "as in Mitsuba 3";
  for (const std::string& both : {first + direct, "<integrator type=\"aov\">" + first + direct + "</integrator>"}) {
    const Scene scene = approximated(both);
    EXPECT_EQ(scene.max_depth, 2) << both;
    EXPECT_TRUE(warns(scene, "another integrator beside the first")) << both;
  }
}

TEST(MitsubaXml, DefaultsAndReferencesAreResolved) {
  const Scene scene = read(R"(<default name="r" value="0.25"/><default name="r" value="0.75"/><default name="res" value="7"/>
    <default name="resx" value="64"/>
    <sensor type="perspective"><film type="hdrfilm"><integer name="width" value="$resx"/></film></sensor>
    <shape type="rectangle"><ref id="m"/></shape>
    <bsdf type="diffuse" id="m"><spectrum name="reflectance" value="$r"/></bsdf>)");
  EXPECT_EQ(scene.resolution.x, 64) << "the longest name that fits";
  EXPECT_EQ(std::get<Diffuse>(scene.materials.at(0)).reflectance.constant, Rgb(0.25f)) << "the first default stays";
  EXPECT_ERROR(read("<default name=\"depth\" value=\"1\"/><shape type=\"$dept\"/>"),
               "s.xml:2:47: unknown parameter 'dept'; did you mean 'depth'");
  EXPECT_ERROR(read("<bsdf type=\"diffuse\" id=\"white\"/><shape type=\"sphere\"><ref id=\"whte\"/></shape>"),
               "s.xml:2:64: unknown id 'whte'; did you mean 'white'");
  EXPECT_ERROR(
      read("<bsdf type=\"plastic\" id=\"a\"/><bsdf type=\"diffuse\" id=\"a\"/><shape type=\"sphere\"><ref id=\"a\"/></shape>"),
      "the id of two objects");
  read("<bsdf type=\"diffuse\" id=\"a\"/><bsdf type=\"diffuse\" id=\"a\"/><shape type=\"sphere\"><ref id=\"a\"/></shape>");
}

TEST(MitsubaXml, MistakesAreToldWithTheirPlace) {
  EXPECT_ERROR(read("<shape type=\"shere\"/>"), "s.xml:2:14: unknown shape 'shere'; did you mean 'sphere'");
  EXPECT_ERROR(read("<shape/>"), "s.xml:2:1: shape: 'type' is missing");
  EXPECT_ERROR(read("<shape type=\"sphere\"><bsdf/></shape>"), "s.xml:2:22: bsdf: 'type' is missing");
  EXPECT_ERROR(read("<shape type=\"sphere\">\n  <float name=\"radus\" value=\"1\"/></shape>"),
               "s.xml:3:3: shape \"sphere\": unknown property 'radus'; did you mean 'radius'");
  EXPECT_ERROR(read("<shape type=\"sphere\"><float name=\"radius\" value=\"1x\"/></shape>"), "'1x' is not a number");
  EXPECT_ERROR(read("<shape type=\"sphere\"><flot name=\"radius\" value=\"1\"/></shape>"), "unknown element 'flot'");
  EXPECT_ERROR(read("<shape type=\"sphere\"><float name=\"radius\" value=\"1\"/><float name=\"radius\" value=\"2\"/></shape>"),
               "given twice");
  EXPECT_ERROR(read("<shape"), "s.xml:");
  EXPECT_ERROR(parse_mitsuba("<html/>", "s.xml"), "s.xml:1:1: no Mitsuba scene: expected the root element <scene>");
  EXPECT_ERROR(parse_mitsuba("", "s.xml"), "s.xml:1:1: no XML");
  EXPECT_ERROR(read(sensor, "9"), "version '9'; expected 0.4 to 3");
}

TEST(MitsubaXml, IncludesAreMergedAndConfined) {
  const TestDirectory directory;
  directory.write("scene/parts/white.xml",
                  scene_text("<bsdf type=\"diffuse\" id=\"white\"><rgb name=\"reflectance\" value=\"$r\"/></bsdf>"));
  directory.write("secret.xml", "<passwords/>");
  const auto including = [&](const std::string& file) {
    return directory.write("scene/s.xml", scene_text("<default name=\"r\" value=\"0.3\"/><include filename=\"" + file +
                                                     "\"/><shape type=\"sphere\"><ref id=\"white\"/></shape>"));
  };
  const Scene scene = load_scene(including("parts/white.xml"), {}, {.confined = true});
  EXPECT_EQ(std::get<Diffuse>(scene.materials.at(0)).reflectance.constant, Rgb(0.3f));
  EXPECT_ERROR(load_scene(including("../secret.xml"), {}, {.confined = true}), "lies outside the folder of the scene");
  const std::string unconfined = error_of([&] { load_scene(including("../secret.xml")); });
  EXPECT_TRUE(contains(unconfined, "no Mitsuba scene")) << unconfined;
  EXPECT_EQ(unconfined.find("passwords"), std::string::npos) << "what is no scene is not shown";
  EXPECT_ERROR(load_scene(including("s.xml")), "include each other more than 32 deep");
}

TEST(MitsubaXml, HostileScenesEndAtOnce) {
  const auto begin = std::chrono::steady_clock::now();
  std::string deep;
  for (int i = 0; i < 200'000; ++i) deep += "<bsdf type=\"twosided\">";
  EXPECT_ERROR(read(deep), "");
  for (int i = 0; i < 200'000; ++i) deep += "</bsdf>";
  EXPECT_ERROR(read(deep), "elements nest more than 64 deep");
  EXPECT_ERROR(parse_mitsuba("<!DOCTYPE s [<!ENTITY a \"aa\">]><scene/>", "s.xml"), "document type");
  std::string bomb = "<default name=\"a0\" value=\"0123456789\"/>";
  for (int i = 1; i < 40; ++i)
    bomb += "<default name=\"a" + std::to_string(i) + "\" value=\"" +
            std::string("$a" + std::to_string(i - 1) + ",$a" + std::to_string(i - 1)) + "\"/>";
  EXPECT_ERROR(read(bomb), "replacing $names adds more than");
  EXPECT_ERROR(read("<shape type=\"sphere\"><ref id=\"a\"/></shape><bsdf type=\"twosided\" id=\"a\"><ref "
                    "id=\"b\"/></bsdf><bsdf type=\"twosided\" id=\"b\"><ref id=\"a\"/></bsdf>"),
               "refers to itself");
  std::string chain = "<shape type=\"sphere\"><ref id=\"b0\"/></shape>";
  for (int i = 0; i < 50'000; ++i)
    chain += "<bsdf type=\"twosided\" id=\"b" + std::to_string(i) + "\"><ref id=\"b" + std::to_string(i + 1) + "\"/></bsdf>";
  EXPECT_ERROR(read(chain + "<bsdf type=\"diffuse\" id=\"b50000\"/>"), "more than 64 objects deep");
  EXPECT_ERROR(read("<texture type=\"scale\" id=\"t\"><ref id=\"t\"/></texture><shape type=\"sphere\"><bsdf "
                    "type=\"diffuse\"><ref name=\"reflectance\" id=\"t\"/></bsdf></shape>"),
               "refers to itself");
  EXPECT_ERROR(read("<integrator type=\"moment\" id=\"i\"><ref id=\"i\"/></integrator>"), "more than 64 objects deep");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

TEST(MitsubaXml, DamagedScenesAreReadOrRefused) {
  const std::string text =
      scene_text(sensor +
                 "<bsdf type=\"roughconductor\" id=\"m\"><string name=\"distribution\" value=\"ggx\"/></bsdf>"
                 "<shape type=\"cube\"><ref id=\"m\"/><transform name=\"to_world\"><rotate y=\"1\" angle=\"3\"/></transform>"
                 "<emitter type=\"area\"><spectrum name=\"radiance\" value=\"400:1, 700:2\"/></emitter></shape>");
  damage(text, 500, [](const std::string& damaged) {
    parse_mitsuba(damaged, "/nonexistent/s.xml", {.confined = true, .approximate = true});
  });
}

TEST(MitsubaTransform, MisspeltAttributesAreNotMissing) {
  const auto with = [](const std::string& operation) {
    return read("<shape type=\"sphere\"><transform name=\"to_world\">" + operation + "</transform></shape>");
  };
  EXPECT_ERROR(with("<translate X=\"1\"/>"), "translate: unknown attribute 'X'");
  EXPECT_ERROR(with("<scale values=\"2\"/>"), "unknown attribute 'values'; did you mean 'value'");
  EXPECT_ERROR(with("<lookat orgin=\"0,0,1\" target=\"0,0,0\"/>"), "lookat: unknown attribute 'orgin'; did you mean 'origin'");
}

TEST(MitsubaTransform, TheFirstOperationIsAppliedFirst) {
  const auto centre = [](const std::string& operations) {
    const Scene scene = read("<shape type=\"sphere\"><transform name=\"to_world\">" + operations + "</transform></shape>");
    return std::get<Sphere>(scene.objects[0].geometry.quadrics.at(0)).centre + scene.origin;
  };
  expect_near(centre("<translate x=\"1\"/><scale value=\"2\"/>"), {2, 0, 0});
  expect_near(centre("<scale value=\"2\"/><translate value=\"1, 2, 3\"/>"), {1, 2, 3});
  expect_near(centre("<translate x=\"1\"/><rotate z=\"1\" angle=\"90\"/>"), {0, 1, 0});
  expect_near(centre("<matrix value=\"1 0 0 4 0 1 0 5 0 0 1 6 0 0 0 1\"/>"), {4, 5, 6});
  EXPECT_ERROR(centre("<scale x=\"0\"/>"), "a factor of 0 has no inverse");
  EXPECT_ERROR(centre("<rotate angle=\"3\"/>"), "rotate: expected an axis");
  EXPECT_ERROR(centre("<matrix value=\"1 2 3\"/>"), "expected 16 numbers (or 9), row by row, found 3");
  EXPECT_ERROR(centre("<skew x=\"1\"/>"), "unknown transform 'skew'");
}

vec3 normal_of_first_triangle(const Scene& scene) {
  const Geometry& g = scene.objects[0].geometry;
  const uvec3 t = g.triangles.at(0);
  const vec3 n = glm::normalize(glm::cross(g.positions[t.y] - g.positions[t.x], g.positions[t.z] - g.positions[t.x]));
  return scene.objects[0].shapes.at(0).flip_normal ? -n : n;
}

TEST(MitsubaShapes, PlanesAndSolidsFaceTheirOwnSide) {
  const auto normal = [](const std::string& inside) {
    return normal_of_first_triangle(read("<shape type=\"rectangle\">" + inside + "</shape>"));
  };
  expect_near(normal(""), {0, 0, 1});
  expect_near(normal("<boolean name=\"flipNormals\" value=\"true\"/>"), {0, 0, -1});
  expect_near(normal("<transform name=\"to_world\"><scale x=\"-1\"/></transform>"), {0, 0, 1});
  expect_near(normal("<transform name=\"to_world\"><rotate x=\"1\" angle=\"90\"/></transform>"), {0, -1, 0});
  const Scene cube = read("<shape type=\"cube\"/>");
  const Geometry& g = cube.objects[0].geometry;
  ASSERT_EQ(g.triangles.size(), 12u);
  for (const uvec3& t : g.triangles) {
    const vec3 a = g.positions[t.x], n = glm::cross(g.positions[t.y] - a, g.positions[t.z] - a);
    EXPECT_GT(glm::dot(n, a), 0) << "outward";
  }
}

TEST(MitsubaShapes, MeshesWithoutNormalsAreSmoothUnlessTheyHaveFaces) {
  const TestDirectory directory;
  directory.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0.25 0.75\nf 1/1 2/1 3/1\nf 1/1 3/1 4/1\n");
  const auto mesh = [&](const std::string& inside) {
    return load_scene(directory.write(
        "s.xml", scene_text("<shape type=\"obj\"><string name=\"filename\" value=\"m.obj\"/>" + inside + "</shape>")));
  };
  const Scene smooth = mesh("");
  EXPECT_TRUE(smooth.objects[0].shapes[0].has_normals);
  expect_near(smooth.objects[0].normals[0], glm::normalize(vec3(1, 0, 1)));
  EXPECT_EQ(smooth.objects[0].uvs[0], vec2(0.25f, 0.25f)) << "v = 0 is the top of an image";
  EXPECT_FALSE(mesh("<boolean name=\"face_normals\" value=\"true\"/>").objects[0].shapes[0].has_normals);
}

TEST(MitsubaShapes, GroupsAreInstanced) {
  const Scene scene =
      read(R"(<shape type="instance"><ref id="g"/><transform name="to_world"><translate x="5"/></transform></shape>
    <shape type="shapegroup" id="g"><shape type="cube"/><shape type="sphere"/></shape>
    <shape type="instance"><ref name="shapegroup" id="g"/></shape>)");
  EXPECT_EQ(scene.objects.size(), 2u);
  ASSERT_EQ(scene.instances.size(), 3u);
  expect_near(scene.instances[1].to_world.point(vec3(0)) - scene.instances[2].to_world.point(vec3(0)), {5, 0, 0});
  EXPECT_TRUE(scene.objects[0].shapes.empty());
  EXPECT_ERROR(read("<shape type=\"shapegroup\" id=\"g\"><shape type=\"sphere\"><emitter type=\"area\"/></shape></shape>"),
               "cannot emit light");
  EXPECT_ERROR(read("<shape type=\"instance\"/>"), "expected one reference to a shapegroup");
  EXPECT_ERROR(read("<shape type=\"heightfield\"/>"), "shape \"heightfield\" is not supported");
  EXPECT_TRUE(warns(approximated("<shape type=\"heightfield\"/>"), "taken as nothing"));
}

TEST(MitsubaShapes, MergedShapesAreReadOneByOne) {
  const Scene scene =
      read("<shape type=\"merge\"><shape type=\"sphere\"/><shape type=\"merge\"><shape type=\"cube\"/></shape></shape>");
  EXPECT_EQ(scene.objects[0].shapes.size(), 2u);
  EXPECT_ERROR(read("<shape type=\"merge\" id=\"m\"><ref id=\"m\"/></shape>"), "more than 64 objects deep");
}

TEST(MitsubaShapes, AnimationsAreRefusedOrStandStill) {
  const std::string moving =
      R"(<shape type="sphere"><animation name="to_world"><transform time="1"><translate x="5"/></transform>
    <transform time="0"><translate x="3"/></transform></animation></shape>)";
  const auto seen = [](const std::string& open, const std::string& close) {
    return "<sensor type=\"perspective\"><float name=\"shutter_open\" value=\"" + open +
           "\"/><float name=\"shutter_close\" value=\"" + close + "\"/></sensor>";
  };
  for (const std::string& sensor : {seen("0", "1"), seen("0.5", "0.5"), seen("0", "0") + seen("0", "0.1")}) {
    EXPECT_ERROR(read(sensor + moving), "an animation is not supported");
    EXPECT_TRUE(warns(approximated(sensor + moving), "an animation is not supported"));
  }
  for (const std::string& sensor : {std::string(), seen("0", "0"), seen("-1", "-1")}) {
    const Scene still = read(sensor + moving);
    expect_near(std::get<Sphere>(still.objects[0].geometry.quadrics.at(0)).centre + still.origin, {3, 0, 0});
    EXPECT_FALSE(warns(still, "animation"));
  }
  const std::string one = R"(<shape type="sphere"><animation name="to_world"><transform time="7"><translate x="5"/></transform>
    </animation></shape>)";
  EXPECT_FALSE(warns(read(seen("0", "1") + one), "animation"));
  EXPECT_ERROR(approximated("<shape type=\"sphere\"><animation name=\"to_world\"/></shape>"), "expected transforms");
}

TEST(MitsubaShapes, QuadricsAreKept) {
  const Scene scene =
      read(R"(<shape type="sphere"><point name="center" x="1" y="2" z="3"/><float name="radius" value="2"/></shape>
    <shape type="disk"/><shape type="cylinder"><point name="p1" value="0, 2, 0"/><float name="radius" value="0.5"/></shape>)");
  const auto& quadrics = scene.objects[0].geometry.quadrics;
  ASSERT_EQ(quadrics.size(), 3u);
  EXPECT_EQ(std::get<Sphere>(quadrics[0]).radius, 2);
  expect_near(std::get<Disk>(quadrics[1]).normal, {0, 0, 1});
  EXPECT_EQ(std::get<Cylinder>(quadrics[2]).length, 2);
}

TEST(MitsubaShapes, TexturedQuadricsThatGlowAreMeshesWhereTurned) {
  const auto lights = [](const std::string& turn) {
    return read("<shape type=\"cylinder\"><transform name=\"to_world\">" + turn +
                "</transform><emitter type=\"area\"/><bsdf type=\"diffuse\"><texture type=\"checkerboard\" "
                "name=\"reflectance\"/></bsdf></shape>")
        .lights.size();
  };
  EXPECT_EQ(lights("<translate x=\"1\"/>"), 1u);
  EXPECT_GT(lights("<rotate z=\"1\" angle=\"30\"/>"), 100u) << "a quadric would lose the turn of its texture";
}

TEST(MitsubaShapes, SpheresOfVersion0ScaleTheirRadiusAlone) {
  const std::string sphere = R"(<shape type="sphere"><point name="center" x="1" y="0" z="0"/><transform name="to_world">
    <scale value="2"/><translate y="5"/></transform></shape>)";
  for (const auto& [version, centre] : {std::pair("0.6.0", vec3(1, 5, 0)), std::pair("3.0.0", vec3(2, 5, 0))}) {
    const Scene scene = read(sphere, version);
    const Sphere& placed = std::get<Sphere>(scene.objects[0].geometry.quadrics.at(0));
    expect_near(placed.centre + scene.origin, centre);
    EXPECT_EQ(placed.radius, 2);
  }
}

TEST(MitsubaShapes, MirroredSpheresAreInsideOutFromVersion2On) {
  const std::string sphere = "<shape type=\"sphere\"><transform name=\"to_world\"><scale x=\"-1\"/></transform></shape>";
  for (const auto& [version, inside_out] : {std::pair("0.6.0", false), std::pair("2.0.0", true), std::pair("3.0.0", true)})
    EXPECT_EQ(read(sphere, version).objects[0].shapes.at(0).flip_normal, inside_out) << version;
}

// Mitsuba's u is the radius and its v the angle; those of our disks are the angle and the way inwards.
TEST(MitsubaShapes, TexturedDisksAreMeshesWithMitsubasCoordinates) {
  const Scene scene =
      read("<shape type=\"disk\"><bsdf type=\"diffuse\"><texture type=\"checkerboard\" name=\"reflectance\"/></bsdf></shape>");
  const Object& object = scene.objects[0];
  ASSERT_FALSE(object.uvs.empty());
  for (std::size_t i = 0; i < object.uvs.size(); ++i) {
    const float angle = 2 * pi * object.uvs[i].y;
    expect_near(object.geometry.positions[i] + scene.origin, object.uvs[i].x * vec3(std::cos(angle), std::sin(angle), 0));
  }
}

TEST(MitsubaShapes, TrianglesWithoutTextureCoordinatesHaveMitsubas) {
  const TestDirectory directory;
  directory.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto uvs = [&](const std::string& inside) {
    const std::string shape =
        "<shape type=\"obj\"><string name=\"filename\" value=\"t.obj\"/><bsdf type=\"diffuse\">" + inside + "</bsdf></shape>";
    return parse_mitsuba(scene_text(shape), directory.path("s.xml")).objects[0].uvs;
  };
  EXPECT_TRUE(uvs("").empty());
  EXPECT_EQ(uvs("<texture type=\"checkerboard\" name=\"reflectance\"/>"), (std::vector<vec2>{{0, 0}, {1, 0}, {0, 1}}));
}

TEST(MitsubaNames, BothSpellingsAreOne) {
  for (const auto& [written, snake] : std::vector<std::pair<std::string, std::string>>{{"toWorld", "to_world"},
                                                                                       {"to_world", "to_world"},
                                                                                       {"intIOR", "int_ior"},
                                                                                       {"fovAxis", "fov_axis"},
                                                                                       {"alphaU", "alpha_u"},
                                                                                       {"color0", "color0"}})
    EXPECT_EQ(snake_case(written), snake);
}

}  // namespace
}  // namespace etendue::mitsuba_test
